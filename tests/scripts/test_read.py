"""Reading scripts: what they say, and everything that is wrong with one, each with its place and its cure."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pymeshlab
import pytest

from pymeshfair.declaration import Length
from pymeshfair.errors import UnknownNameError
from pymeshfair.meshlab.facts import former_filters
from pymeshfair.registry import find_filter
from pymeshfair.scripts import Problem, ScriptError, parse_script, read_script
from tests.scripts.texts import apply_coord_every_kind, one_filter, problems, script, step, taubin


def every_kind(*params: str) -> bytes:
    """A script of the filter with a parameter of every kind."""
    return one_filter("Every Kind", *params)


def test_a_script_is_read_in_order_with_lines_and_values() -> None:
    """Steps come in order with the line where they begin and the given values alone, in declared order."""
    read = parse_script(
        script(
            '<filter name="Box/Cube"/>',
            "<!-- a remark -->",
            '<filter name="Taubin Smooth">',
            ' <Param type="RichInt" name="stepSmoothNum" value="3" unknown="attribute"/>',
            ' <Param type="RichFloat" name="lambda" value="0.25" description="d" tooltip="t"/>',
            "</filter>",
        ),
        "test.mlx",
    )
    assert [s.filter.python_name for s in read.steps] == ["create_cube", "apply_coord_taubin_smoothing"]
    assert [s.line for s in read.steps] == [3, 5]
    assert read.steps[0].values == {}
    assert list(read.steps[1].values.items()) == [("lambda_", 0.25), ("stepsmoothnum", 3)]
    assert read.path is None


@pytest.mark.parametrize(
    ("param", "value"),
    [
        ('type="RichBool" name="flag" value="false"', False),
        ('type="RichInt" name="count" value=" -3 "', -3),
        ('type="RichInt" name="count" value="+007"', 7),
        ('type="RichDynamicFloat" name="share" value="0.1" min="0" max="1"', 0.1),
        ('type="RichFloat" name="share" value="1"', 1.0),
        ('type="RichFloat" name="number" value=".5"', 0.5),
        ('type="RichFloat" name="number" value="5."', 5.0),
        ('type="RichFloat" name="number" value="-1E-3"', -0.001),
        ('type="RichAbsPerc" name="number" value="2" min="0" max="9"', 2.0),
        ('type="RichAbsPerc" name="size" value="0.3" min="0" max="9"', Length(0.3)),
        ('type="RichFloat" name="size" value="0.3"', Length(0.3)),
        ('type="RichAbsPerc" name="size" value="0.3" min="0" max="9" relative="1%"', Length(1.0, "percent")),
        ('type="RichAbsPerc" name="size" value="0.3" min="0" max="9" relative="0.5edge"', Length(0.5, "edge")),
        ('type="RichAbsPerc" name="offset" value="-0.3" min="-1" max="1"', Length(-0.3)),
        ('type="RichEnum" name="word" value="2" enum_cardinality="3"', "drei"),
        ('type="RichEnum" name="word" value="2" enum_cardinality="3" enum_val2="three"', "drei"),
        ('type="RichInt" name="word" value="0"', "one"),
        ('type="RichString" name="text" value="a&#10;b &amp; &lt;c&gt; &quot;&#233;&quot;"', 'a\nb & <c> "é"'),
        ('type="RichMesh" name="LayerId" value="7"', 7),
        ('type="RichInt" name="LayerId" value="7"', 7),
        ('type="RichPosition" name="place" x="1" y="-2.5" z="1e3"', (1.0, -2.5, 1000.0)),
        ('type="RichPosition" name="axis" x="1" y="0" z="0"', (1.0, 0.0, 0.0)),
        ('type="RichColor" name="tint" r="255" g="0" b="7" a="128"', (255, 0, 7, 128)),
        (
            'type="RichMatrix44f" name="matrix" ' + " ".join(f'val{i}="{i}"' for i in range(16)),
            ((0.0, 1.0, 2.0, 3.0), (4.0, 5.0, 6.0, 7.0), (8.0, 9.0, 10.0, 11.0), (12.0, 13.0, 14.0, 15.0)),
        ),
    ],
)
def test_values_of_every_kind_are_read(param: str, value: Any) -> None:
    """Every type that MeshLab reads into the same kind of value is accepted, and the value is exact."""
    read = step(every_kind(f"<Param {param}/>"))
    (got,) = read.values.values()
    assert got == value
    assert type(got) is type(value)


def only_problem(data: bytes) -> Problem:
    """The only thing that is wrong."""
    (found,) = problems(data)
    return found


@pytest.mark.parametrize(
    ("param", "message", "suggestion"),
    [
        ('type="RichBool" name="flag" value="False"', "in small letters, got 'False'; MeshLab would read it as true", "false"),
        ('type="RichBool" name="flag" value="TRUE"', "takes true or false", "true"),
        ('type="RichBool" name="flag" value="1"', "takes true or false", "true"),
        ('type="RichBool" name="flag" value="maybe"', "takes true or false", None),
        ('type="RichBool" name="flag"', "the attribute value is missing", None),
        ('type="RichInt" name="count" value="1.0"', "takes a whole number from -3 to 12, got '1.0'", None),
        ('type="RichInt" name="count" value="1e1"', "takes a whole number", None),
        ('type="RichInt" name="count" value="2.5"', "takes a whole number", None),
        ('type="RichInt" name="count" value=""', "takes a whole number", None),
        ('type="RichInt" name="count" value="0x10"', "takes a whole number", None),
        ('type="RichInt" name="count" value="1_0"', "takes a whole number", None),
        ('type="RichInt" name="count" value="13"', "from -3 to 12, got 13", None),
        ('type="RichInt" name="count" value="99999999999999"', "from -3 to 12, got 99999999999999", None),
        ('type="RichFloat" name="count" value="1"', "has the type RichInt, not 'RichFloat'", "RichInt"),
        ('type="RichFloat" name="number" value="0,3"', "takes a number, got '0,3'", None),
        ('type="RichFloat" name="number" value="nan"', "takes a number, got 'nan'", None),
        ('type="RichFloat" name="number" value="-inf"', "takes a number, got '-inf'", None),
        ('type="RichFloat" name="number" value="1e400"', "takes a number, got '1e400'", None),
        ('type="RichFloat" name="number" value="1e39"', "single precision", None),
        ('type="RichFloat" name="number" value="1e-50"', "single precision", None),
        ('type="RichFloat" name="number" value="1%"', "takes a number, got '1%'", None),
        ('type="RichFloat" name="number" value="1" relative="1%"', "relative= belongs to lengths alone", None),
        ('type="RichInt" name="number" value="1"', "has the type RichFloat, not 'RichInt'; MeshLab would take 0", "RichFloat"),
        ('type="RichString" name="number" value="1"', "has the type RichFloat, not 'RichString'", "RichFloat"),
        ('name="number" value="1"', "the attribute type is missing", "RichFloat"),
        ('type="richfloat" name="number" value="1"', "has the type RichFloat, not 'richfloat'", "RichFloat"),
        ('type="RichDynamicFloat" name="share" value="1.5" min="0" max="2"', "from 0.0 to 1.0, got 1.5", None),
        ('type="RichDynamicFloat" name="share" value="1" max="1"', "the attribute min is missing", None),
        ('type="RichDynamicFloat" name="share" value="1" min="0" max="x"', "the attribute max must be a number, got 'x'", None),
        ('type="RichAbsPerc" name="size" value="1" min="0"', "the attribute max is missing", None),
        (
            'type="RichAbsPerc" name="size" value="1%" min="0" max="1"',
            r"takes a number as value= \(1% or 0.5edge belongs in relative=\), got '1%'",
            None,
        ),
        ('type="RichAbsPerc" name="size" value="-1" min="0" max="1"', "of at least 0.0, got -1.0$", None),
        ('type="RichAbsPerc" name="size" min="0" max="1" relative="1%"', "the attribute value is missing", None),
        ('type="RichAbsPerc" name="size" value="1" min="0" max="1" relative="2"', "a length with a unit, got '2'", "2%"),
        (
            'type="RichAbsPerc" name="size" value="1" min="0" max="1" relative="2mm"',
            "a length such as 1% or 0.5edge, got '2mm'",
            None,
        ),
        ('type="RichAbsPerc" name="size" value="1" min="0" max="1" relative="-2%"', "of at least 0.0, got -2.0%", None),
        ('type="RichEnum" name="word" value="3" enum_cardinality="3"', "0: one; 1: two .*; 2: drei.*, got '3'", None),
        ('type="RichEnum" name="word" value="-1" enum_cardinality="3"', "got '-1'", None),
        ('type="RichEnum" name="word" value="drei" enum_cardinality="3"', "the number of a choice", "2"),
        ('type="RichEnum" name="word" value="1"', "the attribute enum_cardinality is missing", None),
        (
            'type="RichEnum" name="word" value="1" enum_cardinality="2000000000"',
            "enum_cardinality must be a whole number from 0",
            None,
        ),
        ('type="RichEnum" name="word" value="0" enum_cardinality="3" enum_val0="drei"', "here it means 'one'", "2"),
        ('type="RichString" name="text"', "the attribute value is missing", None),
        ('type="RichMesh" name="LayerId" value="-1"', "the id of a layer", None),
        ('type="RichPoint3f" name="place" x="0" y="0" z="0"', "type 'RichPoint3f' is an old name", "RichPosition"),
        ('type="RichPosition" name="place" x="0" y="0"', "the attribute z is missing", None),
        ('type="RichPosition" name="place" x="0" y="0" z="inf"', "three finite numbers, got 'inf'", None),
        ('type="RichColor" name="tint" r="256" g="0" b="0" a="0"', "from 0 to 255", None),
        ('type="RichColor" name="tint" r="1.5" g="0" b="0" a="0"', "got '1.5'", None),
        ('type="RichMatrix44f" name="matrix" val0="1"', "the attribute val1 is missing", None),
    ],
)
def test_every_wrong_value_is_a_problem_with_its_cure(param: str, message: str, suggestion: str | None) -> None:
    """One wrong attribute is one problem, at its line, naming filter and parameter, saying what is allowed and what to write."""
    found = only_problem(every_kind("", f"<Param {param}/>"))
    assert (found.file, found.line, found.filter) == ("test.mlx", 5, "Every Kind")
    assert found.parameter is not None
    assert f'name="{found.parameter}"' in param
    assert re.search(message, found.message), found.message
    assert found.suggestion == suggestion


@pytest.mark.parametrize(
    ("name", "message", "suggestion"),
    [
        ("taubin smooth", "there is no filter of that name", "Taubin Smooth"),
        ("Taubin Smooth ", "there is no filter of that name", "Taubin Smooth"),
        ("apply_coord_taubin_smoothing", "the filter's name in Python; scripts use the one in MeshLab's menus", "Taubin Smooth"),
        ("apply_coord_every_kind", "the filter's name in Python", "Every Kind"),
        (
            "Quadric Edge Collapse Decimation",
            "renamed this filter to 'Simplification: ",
            "Simplification: Quadric Edge Collapse Decimation",
        ),
        ("Repair non Manifold Edges by splitting vertices", "the parameter method with the value 1", "Repair non Manifold Edges"),
        ("0123456789", "there is no filter of that name", None),
        ("", "there is no filter of that name", None),
    ],
)
def test_unknown_filters_are_problems_with_the_right_name(name: str, message: str, suggestion: str | None) -> None:
    """A filter under a wrong, Python or former name is refused, with the name that MeshLab knows today."""
    found = only_problem(one_filter(name))
    assert (found.line, found.filter, found.suggestion) == (3, name, suggestion)
    assert message in found.message


@pytest.mark.parametrize(
    ("data", "line", "message", "suggestion"),
    [
        (script("<filter/>"), 3, "<filter> has no name", None),
        (script('<Filter name="Taubin Smooth"/>'), 3, "the element <Filter> is unknown here", "filter"),
        (script("<Setting/>", '<filter name="Taubin Smooth"/>'), 3, "the element <Setting> is unknown here", "setting"),
        (script("<pyfilter/>", '<filter name="Taubin Smooth"/>'), 3, "the element <pyfilter> is unknown here", "filter"),
        (script('<xmlfilter name="Compute Geometric Measures"><xmlparam name="a"/></xmlfilter>'), 3, "of MeshLab 2016", "filter"),
        (
            script('<xmlfilter name="Screened Poisson Surface Reconstruction"/>'),
            3,
            "called 'Surface Reconstruction: Scr",
            "filter",
        ),
        (taubin("<param/>"), 4, "the element <param> is unknown here", "Param"),
        (
            taubin("<Param><x/></Param>".replace("<Param>", '<Param type="RichBool" name="Selected" value="true">')),
            4,
            "<x>",
            None,
        ),
        (taubin("<Param/>"), 4, "<Param> has no name; MeshLab would drop it", None),
        (taubin('<filter name="Box/Cube"/>'), 4, "the element <filter> is unknown here", None),
        (taubin('<Param type="RichFloat" name="lamda" value="1"/>'), 4, "it has lambda, mu, stepSmoothNum, Selected", "lambda"),
        (taubin('<Param type="RichFloat" name="lambda_" value="1"/>'), 4, "no such parameter", "lambda"),
        (taubin('<Param type="RichInt" name="stepsmoothnum" value="1"/>'), 4, "no such parameter", "stepSmoothNum"),
        (one_filter("Convex Hull", '<Param type="RichBool" name="x" value="true"/>'), 4, "it has none", None),
        (taubin("0.5"), 4, "the text '0.5' means nothing here", None),
        (script(), 4, "has no <filter>, so it would do nothing", None),
        (b"<FilterScript/>", 1, "has no <filter>, so it would do nothing", None),
        (b"<!DOCTYPE html>\n<FilterScript><filter name='Box/Cube'/></FilterScript>", 1, "document type 'html'", "FilterScript"),
        (one_filter("Set Mesh Camera", '<Param type="RichShotf" name="Shot"/>'), 4, "MeshLab reads and writes no cameras", None),
    ],
)
def test_elements_that_mean_nothing_are_problems(data: bytes, line: int, message: str, suggestion: str | None) -> None:
    """Whatever MeshLab would pass over in silence, or fail at, is a problem at its line."""
    found = only_problem(data)
    assert message in found.message
    assert (found.line, found.suggestion) == (line, suggestion)


@pytest.mark.parametrize(
    ("of_filter", "of_param", "message", "suggestion"),
    [
        ('tags="a"', "", "<filter> has no attribute 'tags'", "tag"),
        ("", 'Relative="1%"', "<Param> has no attribute 'Relative'", "relative"),
        ("", 'relativ="1%"', "<Param> has no attribute 'relativ'", "relative"),
        ("", 'Setting="size"', "<Param> has no attribute 'Setting'", "setting"),
        ('note="a"', 'description="a" tooltip="b" isxmlparam="0" string="c" related="d"', None, None),
    ],
)
def test_an_attribute_that_is_nearly_one_of_ours_is_a_problem(
    of_filter: str, of_param: str, message: str | None, suggestion: str | None
) -> None:
    """MeshLab ignores what it does not know, so that a length would be absolute or a setting without effect; others may be."""
    param = f'<Param type="RichAbsPerc" name="Threshold" value="1" min="0" max="100" {of_param}/>'
    found = problems(script(f'<filter name="Merge Close Vertices" {of_filter}>', param, "</filter>"))
    assert [(p.message, p.suggestion, p.filter) for p in found] == (
        [] if message is None else [(message, suggestion, "Merge Close Vertices")]
    )


def test_a_parameter_given_twice_is_a_problem() -> None:
    """The second of two values for one parameter is refused, whichever of them MeshLab would take."""
    param = '<Param type="RichFloat" name="lambda" value="0.5"/>'
    found = only_problem(taubin(param, param))
    assert (found.line, found.parameter) == (5, "lambda")
    assert "given twice" in found.message


def test_all_problems_of_a_script_are_listed_in_its_order() -> None:
    """Reading does not stop at the first problem; each has a line of the message, with file, line, filter and parameter."""
    data = script(
        '<filter name="Taubin Smooth">',
        '  <Param type="RichInt" name="lambda" value="x"/>',
        '  <Param type="RichInt" name="stepSmoothNum" value="-1"/>',
        "</filter>",
        '<filter name="Dilate selektion"/>',
        "<remark/>",
    )
    with pytest.raises(ScriptError) as caught:
        parse_script(data, "folder/my.mlx")
    lines = str(caught.value).splitlines()
    assert len(lines) == len(caught.value.problems) == 5
    assert lines[0] == (
        "folder/my.mlx:4: filter 'Taubin Smooth': parameter 'lambda': has the type RichFloat, not 'RichInt'; "
        "MeshLab would take 0 or the default (did you mean 'RichFloat'?)"
    )
    assert lines[1].startswith("folder/my.mlx:4: filter 'Taubin Smooth': parameter 'lambda': takes a number, got 'x'")
    assert lines[2].startswith("folder/my.mlx:5: ")
    assert (
        lines[3]
        == "folder/my.mlx:7: filter 'Dilate selektion': there is no filter of that name (did you mean 'Dilate Selection'?)"
    )
    assert lines[4].startswith("folder/my.mlx:8: the element <remark>")


def test_after_many_problems_reading_ends() -> None:
    """Of a thousand wrong filters a hundred are listed, and a last line says that there are more."""
    found = problems(script(*['<filter name="nothing like it"/>'] * 900))
    assert len(found) == 101
    assert "only the first 100 are listed" in found[-1].message


def test_long_values_are_cut_in_messages() -> None:
    """A value of a million letters does not make a message of a million letters."""
    for param in (
        f'type="RichFloat" name="lambda" value="{"9" * 1_000_000}"',
        f'type="RichFloat" name="{"q" * 1_000_000}" value="1"',
    ):
        found = only_problem(taubin(f"<Param {param}/>"))
        assert len(str(found)) < 400


@pytest.mark.parametrize(
    ("head", "comment"),
    [
        ("<!--Title-->", "Title"),
        ("<!--\n  Title\n\n    indented\n  end  \n\n-->", "Title\n\n  indented\nend"),
        ("<!-- One -->\n<!-- Two -->", "One\n\nTwo"),
        ("", ""),
    ],
)
def test_the_head_comment_is_kept_without_its_frame(head: str, comment: str) -> None:
    """The comments before the first filter are the script's comment, without marks, common indentation and empty ends."""
    data = f"<!DOCTYPE FilterScript>\n{head}\n<FilterScript><filter name='Box/Cube'/><!-- later --></FilterScript>"
    assert parse_script(data.encode(), "test.mlx").comment == comment


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_unicode_with_a_byte_order_mark_is_read(encoding: str) -> None:
    """UTF-8 with and without its mark and UTF-16 with one are read; UTF-16 without one is refused, as it is by XML itself."""
    text = one_filter("Every Kind", '<Param type="RichString" name="text" value="Maß é 漢"/>').decode()
    data = text.encode(encoding)
    if encoding in ("utf-16-le", "utf-16-be"):
        assert problems(data)
        mark = b"\xff\xfe" if encoding == "utf-16-le" else b"\xfe\xff"
        data = mark + data
    assert step(data).values == {"text": "Maß é 漢"}


def test_other_encodings_are_refused_by_name() -> None:
    """Bytes that are not UTF-8 are named with their line; a declared Latin-1 is refused even where the bytes would do."""
    latin = one_filter("Every Kind", '<Param type="RichString" name="text" value="Maß"/>').decode().encode("latin-1")
    found = only_problem(latin)
    assert (found.line, found.message) == (4, "is not UTF-8 text (byte 0xdf); save it as UTF-8")
    declared = b'<?xml version="1.0" encoding="ISO-8859-1"?>\n' + taubin()
    assert "written in 'ISO-8859-1', but is read as UTF-8; save it as UTF-8" in only_problem(declared).message
    assert step(b'<?xml version="1.0" encoding="UTF-8"?>\n' + taubin()).filter.name == "Taubin Smooth"


def test_files_are_read_by_path(tmp_path: Path) -> None:
    """A file gives the same script as its bytes, and remembers its path; `str` and `Path` both do."""
    path = tmp_path / "a.mlx"
    path.write_bytes(taubin())
    assert read_script(path) == read_script(str(path)) == parse_script(taubin(), "x")
    assert read_script(str(path)).path == path


@pytest.mark.parametrize("name", ["missing.mlx", ".", "missing/a.mlx", "nul\0.mlx", "x" * 5000])
def test_files_that_cannot_be_read_are_problems(name: str, tmp_path: Path) -> None:
    """A missing file, a folder and an impossible name are a ScriptError that names the path."""
    with pytest.raises(ScriptError, match=r"cannot be read|is not a file") as caught:
        read_script(tmp_path / name)
    assert caught.value.problems[0].file == str(tmp_path / name)


def test_the_sample_script_of_the_pymeshlab_wheel_is_read() -> None:
    """The script that pymeshlab itself ships for its tests has nothing wrong and reads as it says."""
    sample = Path(pymeshlab.__file__).parent / "tests/sample_meshes/sample_filter_script.mlx"
    names = [s.filter.python_name for s in read_script(sample).steps]
    assert names == ["create_cube", "meshing_surface_subdivision_catmull_clark", "meshing_surface_subdivision_butterfly"]
    assert read_script(sample).steps[2].values == {"iterations": 2, "threshold": Length(0.034641), "selected": False}


def test_former_names_lead_to_names_of_today() -> None:
    """Every entry of the table of former filters leads from a name that is gone to one that exists, or says what to do."""
    assert len(former_filters()) >= 53
    for old, former in former_filters().items():
        assert former.idle or former.note if former.now is None else find_filter(former.now).name == former.now
        with pytest.raises(UnknownNameError):
            find_filter(old)


def test_steps_fill_in_what_is_known_without_a_mesh() -> None:
    """A step with defaults has every value but those that MeshLab computes for the mesh; new values are checked."""
    taubin_step = step(taubin('<Param type="RichFloat" name="mu" value="-0.6"/>'))
    assert dict(taubin_step.with_defaults().values) == {"lambda_": 0.5, "mu": -0.6, "stepsmoothnum": 10}
    assert taubin_step.with_values({"selected": True}).values == {"mu": -0.6, "selected": True}
    assert set(step(one_filter("Every Kind")).with_defaults().values) == {p.name for p in apply_coord_every_kind.parameters}

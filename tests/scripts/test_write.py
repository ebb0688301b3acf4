"""Writing scripts: what is written reads back exactly, here and in pymeshlab."""

from __future__ import annotations

import math
import os
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pymeshfair.declaration import (
    Bool,
    Color,
    Enum,
    FileOpen,
    FileSave,
    Filter,
    Float,
    Int,
    Length,
    Matrix,
    Mesh,
    Parameter,
    Percentage,
    Point,
    Shot,
    String,
)
from pymeshfair.errors import PymeshfairError
from pymeshfair.meshlab.facts import meshlab_filters
from pymeshfair.registry import find_filter
from pymeshfair.scripts import Script, Step, format_script, parse_script, read_script, write_script
from pymeshfair.scripts.script import clean_comment
from pymeshfair.scripts.values import is_expression, number_text
from tests.scripts.texts import apply_coord_every_kind

# XML holds no other characters; lone surrogates are no text at all.
TEXTS = st.text(st.characters(exclude_categories=["Cs", "Cc"]) | st.sampled_from("\t\n\r"), max_size=20).filter(
    lambda text: "\ufffe" not in text and "\uffff" not in text
)
SINGLE = st.floats(width=32, allow_nan=False, allow_infinity=False, allow_subnormal=False)
NUMBERS = SINGLE | st.floats(min_value=-1e30, max_value=1e30).filter(lambda x: x == 0 or abs(x) > 1e-44)
POSITIVE = st.floats(min_value=0, max_value=1e30).filter(lambda x: x == 0 or x > 1e-44)


def values_of(known: Filter, parameter: Parameter) -> st.SearchStrategy[Any]:
    """Everything that a parameter of a filter allows in a script."""
    if isinstance(parameter, String) and is_expression(known.python_name, parameter.xml_name):
        return st.sampled_from(["q", "x < 0.5 && y > 1", "min(x, y) ? 1 : 2"])
    finite = st.floats(allow_nan=False, allow_infinity=False)
    lengths = st.sampled_from(["absolute", "percent", "edge"])
    strategies: dict[type[Parameter], st.SearchStrategy[Any]] = {
        Bool: st.booleans(),
        Point: st.tuples(finite, finite, finite),
        Color: st.tuples(*[st.integers(0, 255)] * 4),
        Matrix: st.tuples(*[st.tuples(*[finite] * 4)] * 4),
        Mesh: st.integers(0, 2**31 - 1),
    }
    if isinstance(parameter, Int):
        least, most = parameter.minimum, parameter.maximum
        return st.integers(-(2**31) + 1 if least is None else least, 2**31 - 1 if most is None else most)
    if isinstance(parameter, Float):
        return NUMBERS if parameter.minimum is None else st.floats(parameter.minimum, parameter.maximum).filter(_single)
    if isinstance(parameter, Percentage):
        return st.builds(Length, NUMBERS if parameter.minimum is None else POSITIVE, lengths)
    if isinstance(parameter, Enum):
        return st.sampled_from(parameter.choices)
    return next((s for kind, s in strategies.items() if isinstance(parameter, kind)), TEXTS)


def _single(number: float) -> bool:
    return number == 0 or abs(number) > 1e-44


@st.composite
def steps(draw: st.DrawFn) -> Step:
    """A step with any of its parameters given."""
    known = draw(st.sampled_from([apply_coord_every_kind, *meshlab_filters()]))
    given_ones = [p for p in known.parameters if not isinstance(p, Shot) and draw(st.booleans())]
    return Step(known, known.check({p.name: draw(values_of(known, p)) for p in given_ones}))


COMMENTS = TEXTS.map(clean_comment).filter(lambda text: "--" not in text and not text.endswith("-"))


# The one fixture for every example makes the filter of every kind known, which no example changes.
@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(st.builds(Script, st.lists(steps(), min_size=1, max_size=4).map(tuple), COMMENTS))
def test_what_is_written_reads_back(script: Script) -> None:
    """Reading what was written gives the same steps, values and comment, once the defaults that the writer adds are added."""
    text = format_script(script)
    read = parse_script(text.encode(), "again")
    assert read == script.with_defaults()
    assert format_script(read) == text


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_are_written_exactly_and_short(number: float) -> None:
    """A number's text reads back as the same bits, and no more is written than Python's shortest text."""
    text = number_text(number)
    assert math.copysign(1.0, float(text)) == math.copysign(1.0, number)
    assert float(text) == number
    assert len(text) <= len(repr(number))


def test_a_script_reads_like_one_of_meshlabs() -> None:
    """One filter of each sort gives exactly this text: declared order, MeshLab's names, types, bounds and choices."""
    script = Script(
        (
            Step(find_filter("create_cube"), {"size": 2.0}),
            Step(find_filter("apply_coord_taubin_smoothing"), {"mu": -0.6}),
            Step(find_filter("meshing_remove_t_vertices"), {"method": "Edge Flip"}),
            Step(
                find_filter("meshing_isotropic_explicit_remeshing"),
                {"targetlen": Length(0.5, "edge"), "maxsurfdist": Length(0.1)},
            ),
            Step(find_filter("generate_convex_hull")),
        ),
        comment="Title\n\nFor: <every> mesh & cloud",
    )
    lines = format_script(script).splitlines()
    assert lines[:6] == ["<!DOCTYPE FilterScript>", "<!--", "Title", "", "For: <every> mesh & cloud", "-->"]
    assert lines[6:] == [
        "<FilterScript>",
        '  <filter name="Box/Cube">',
        '    <Param type="RichFloat" name="size" value="2"/>',
        "  </filter>",
        '  <filter name="Taubin Smooth">',
        '    <Param type="RichFloat" name="lambda" value="0.5"/>',
        '    <Param type="RichFloat" name="mu" value="-0.6"/>',
        '    <Param type="RichInt" name="stepSmoothNum" value="10"/>',
        "  </filter>",
        '  <filter name="Remove T-Vertices">',
        '    <Param type="RichEnum" name="method" value="1" enum_cardinality="2"'
        ' enum_val0="Edge Collapse" enum_val1="Edge Flip"/>',
        '    <Param type="RichFloat" name="Threshold" value="40"/>',
        '    <Param type="RichBool" name="Repeat" value="true"/>',
        "  </filter>",
        '  <filter name="Remeshing: Isotropic Explicit Remeshing">',
        '    <Param type="RichInt" name="Iterations" value="10"/>',
        '    <Param type="RichBool" name="Adaptive" value="false"/>',
        '    <Param type="RichBool" name="SelectedOnly" value="false"/>',
        '    <Param type="RichAbsPerc" name="TargetLen" value="0.125" min="0" max="100" relative="0.5edge"/>',
        '    <Param type="RichFloat" name="FeatureDeg" value="30"/>',
        '    <Param type="RichBool" name="CheckSurfDist" value="true"/>',
        '    <Param type="RichAbsPerc" name="MaxSurfDist" value="0.1" min="0" max="100"/>',
        *[
            f'    <Param type="RichBool" name="{n}Flag" value="true"/>'
            for n in ("Split", "Collapse", "Swap", "Smooth", "Reproject")
        ],
        "  </filter>",
        '  <filter name="Convex Hull"/>',
        "</FilterScript>",
    ]


def test_absolute_values_are_those_of_the_given_mesh() -> None:
    """Next to 1 % stands a hundredth of the given diagonal, next to 2 edges twice the given edge; the slider holds the value."""
    known = apply_coord_every_kind
    lengths = {"size": Length(1.0, "percent"), "offset": Length(-2.0, "edge")}
    text = format_script(Script((Step(known, lengths),)), diagonal=50.0, mean_edge=0.25)
    assert '<Param type="RichAbsPerc" name="size" value="0.5" min="0" max="50" relative="1%"/>' in text
    assert '<Param type="RichAbsPerc" name="offset" value="-0.5" min="-0.5" max="50" relative="-2edge"/>' in text
    far = format_script(Script((Step(known, {"size": Length(80.0)}),)), diagonal=50.0)
    assert 'name="size" value="80" min="0" max="80"/>' in far


def _seen_by_meshlab(parameter: Parameter, value: Any) -> dict[str, str]:
    """The attributes that pymeshlab writes for a value that it has read: numbers with six digits, plain ones as C floats."""

    def digits(number: float | np.float32) -> str:
        return f"{number:.6g}"

    if isinstance(parameter, Bool):
        return {"value": str(value).lower()}
    if isinstance(parameter, Float):
        return {"value": digits(np.float32(value))}
    if isinstance(parameter, Percentage):
        return {"value": digits(np.float32(value.resolve(diagonal=100.0, mean_edge=lambda: 0.25)))}
    if isinstance(parameter, Enum):
        words = {f"enum_val{i}": word for i, word in enumerate(parameter.choices)}
        return {"value": str(parameter.choices.index(value)), "enum_cardinality": str(len(parameter.choices)), **words}
    if isinstance(parameter, Point):
        return dict(zip("xyz", map(digits, value), strict=True))
    if isinstance(parameter, Color):
        return dict(zip("rgba", map(str, value), strict=True))
    if isinstance(parameter, Matrix):
        return {f"val{i}": digits(x) for i, x in enumerate(x for row in value for x in row)}
    return {"value": str(value)}


def _unusual(parameter: Parameter, default: Any) -> Any:
    """A value that differs from the default wherever the parameter allows one, and is no round number."""
    if isinstance(parameter, Bool):
        return not default
    if isinstance(parameter, Int):
        return (parameter.minimum or 0) + 3
    if isinstance(parameter, Float):
        if parameter.minimum is not None and parameter.maximum is not None:
            return parameter.minimum + (parameter.maximum - parameter.minimum) / math.pi
        return -1 / 3
    if isinstance(parameter, Percentage):
        return Length(1 / 3, "percent")
    if isinstance(parameter, Enum):
        return parameter.choices[-1]
    if isinstance(parameter, Mesh):
        return 7
    if isinstance(parameter, Point):
        return (1 / 3, -1e-7, 12345678.9)
    if isinstance(parameter, Color):
        return (1, 2, 3, 4)
    if isinstance(parameter, Matrix):
        return tuple(tuple(math.sqrt(4 * i + j) for j in range(4)) for i in range(4))
    return 'a <b> & "c" \u00e9\n\td'


@pytest.mark.parametrize("sort", ["defaults", "other values"])
def test_pymeshlab_reads_every_filter_that_we_write(sort: str, tmp_path: Path) -> None:
    """All 281 filters in one script, with defaults or other values: pymeshlab loads it and saves the same values for each."""
    all_steps = []
    for known in meshlab_filters():
        if sort == "defaults":
            values = {p.name: p.default for p in known.parameters if p.default is not None}
        else:
            values = {p.name: _unusual(p, p.default) for p in known.parameters if not isinstance(p, Shot)}
        all_steps.append(Step(known, known.check(values)))
    write_script(Script(tuple(all_steps)), tmp_path / "ours.mlx")
    meshes = pymeshlab.MeshSet()
    meshes.load_filter_script(str(tmp_path / "ours.mlx"))
    meshes.save_filter_script(str(tmp_path / "theirs.mlx"))
    saved = ET.parse(tmp_path / "theirs.mlx").getroot().findall("filter")
    assert len(saved) == len(all_steps) == 281
    compared = 0
    for step, element in zip(all_steps, saved, strict=True):
        assert element.get("name") == step.filter.name
        given_ones: list[Parameter] = [p for p in step.filter.parameters if p.name in step.values]
        assert [p.get("name") for p in element] == [p.xml_name for p in given_ones]
        for parameter, written in zip(given_ones, element, strict=True):
            expected = _seen_by_meshlab(parameter, step.values[parameter.name])
            assert {key: written.get(key) for key in expected} == expected
            assert written.get("type") == parameter.xml_type
            compared += 1
    assert compared >= (950 if sort == "other values" else 850)  # of 953, three of which are cameras


def test_a_script_of_ours_does_in_pymeshlab_what_it_says(tmp_path: Path) -> None:
    """Loaded and applied by pymeshlab itself, a written script moves a mesh exactly as the filters called one by one."""
    script = Script(
        (
            Step(find_filter("create_sphere"), {"radius": 2.0, "subdiv": 4}),
            Step(find_filter("apply_coord_random_displacement"), {"displacement": Length(0.05), "randomseed": 7}),
            Step(find_filter("apply_coord_taubin_smoothing"), {"lambda_": 0.4, "stepsmoothnum": 3}),
        )
    )
    write_script(script, tmp_path / "script.mlx")
    by_script, by_calls = pymeshlab.MeshSet(), pymeshlab.MeshSet()
    by_script.load_filter_script(str(tmp_path / "script.mlx"))
    by_script.apply_filter_script()
    by_calls.create_sphere(radius=2.0, subdiv=4)
    by_calls.apply_coord_random_displacement(displacement=pymeshlab.PureValue(0.05), randomseed=7)
    by_calls.apply_coord_taubin_smoothing(lambda_=0.4, stepsmoothnum=3)
    np.testing.assert_array_equal(by_script.current_mesh().vertex_matrix(), by_calls.current_mesh().vertex_matrix())


@pytest.mark.parametrize("text", ["\0", "\x0b", "\ud800", "\uffff"])
def test_what_xml_cannot_hold_is_an_error(text: str) -> None:
    """A control character or half a surrogate pair in a value or comment is refused instead of written wrongly."""
    with pytest.raises(PymeshfairError, match="cannot be written to a script"):
        format_script(Script((Step(apply_coord_every_kind, {"text": f"a{text}b"}),)))
    with pytest.raises(PymeshfairError, match="cannot be written to a script"):
        format_script(Script((), comment=text))


@pytest.mark.parametrize("comment", ["a -- b", "ends with -", "<!-- -->"])
def test_a_comment_that_would_end_early_is_an_error(comment: str) -> None:
    """Two hyphens would break the comment, so they are refused."""
    with pytest.raises(PymeshfairError, match="head comment"):
        format_script(Script((), comment=comment))


def test_a_file_appears_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A failed write leaves the former file and nothing else; a successful one replaces it and ends its lines with LF."""
    path = tmp_path / "a.mlx"
    first = Script((Step(find_filter("create_cube")),))
    write_script(first, path)
    assert b"\r" not in path.read_bytes()
    assert read_script(path) == first.with_defaults()

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as context:
        context.setattr(os, "fsync", full)
        with pytest.raises(PymeshfairError, match=r"cannot write .*a\.mlx: no space left on device"):
            write_script(Script((Step(find_filter("create_cone")),)), path, overwrite=True)
    assert read_script(path) == first.with_defaults()
    assert [p.name for p in tmp_path.iterdir()] == ["a.mlx"]
    with pytest.raises(PymeshfairError, match="does not exist; make it first"):
        write_script(first, tmp_path / "missing" / "a.mlx")


def test_files_are_written_with_the_types_that_meshlab_reads() -> None:
    """Paths to open and to save keep their own types, which MeshLab reads only with a count of extensions."""
    known: Filter = find_filter("nxs_build")
    text = format_script(Script((Step(known, {"input_file": "a.ply", "output_file": "b.nxs"}),)))
    kinds = {p.name: type(p) for p in known.parameters}
    assert (kinds["input_file"], kinds["output_file"]) == (FileOpen, FileSave)
    assert '<Param type="RichOpenFile" name="input_file" value="a.ply" exts_cardinality="0"/>' in text
    assert '<Param type="RichSaveFile" name="output_file" value="b.nxs"/>' in text

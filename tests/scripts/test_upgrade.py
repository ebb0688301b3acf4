"""Upgrading scripts: every former name, every change graded, nothing left to upgrade, and the same mesh in pymeshlab."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair.declaration import Length
from pymeshfair.meshlab.facts import former_filter, former_filters, parameter_facts
from pymeshfair.registry import find_filter
from pymeshfair.scripts import ScriptError, Upgrade, format_script, upgrade_script
from pymeshfair.scripts.read import same_but_case
from pymeshfair.scripts.upgrade import relative_script
from tests.scripts.texts import one_filter, script

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"
POISSON = "Surface Reconstruction: Screened Poisson"
REPAIR = "Repair non Manifold Edges"
PRINCIPAL = "Compute curvature principal directions"


#: the former filters that no filter of today stands for
GONE = [name for name, former in former_filters().items() if former.now is None and not former.splits]


def upgraded(data: bytes) -> Upgrade:
    """The upgraded script, after a look that upgrading it again changes nothing."""
    found = upgrade_script(data, "old.mlx")
    text = format_script(found.script, known_mesh=False)
    again = upgrade_script(text.encode(), "new.mlx")
    assert again.changes == ()
    assert format_script(again.script, known_mesh=False) == text
    return found


def values(data: bytes) -> dict[str, Any]:
    """The values of the only step after the upgrade."""
    (step,) = upgraded(data).script.steps
    return dict(step.values)


@pytest.mark.parametrize("old", [name for name, former in former_filters().items() if former.now is not None])
def test_every_former_name_becomes_the_name_of_today(old: str) -> None:
    """A former filter becomes the one in the table with the values that the table sets, and the change is listed at its line."""
    former = former_filters()[old]
    found = upgraded(one_filter(old))
    (step,) = found.script.steps
    assert step.filter.name == former.now
    written = {p.xml_name: step.values[p.name] for p in step.filter.parameters if p.name in step.values}
    assert written.keys() == former.sets.keys()
    changes = [change for change in found.changes if change.filter == old]
    assert changes[0].line == 3
    assert changes[0].same_meaning == (not former.note and not former.invented)


@pytest.mark.parametrize("old", GONE)
def test_a_filter_that_is_gone_is_left_out_or_refused(old: str) -> None:
    """A filter that changed nothing is left out with the same meaning; any other is refused, with what to do."""
    data = script(f'<filter name="{old}"/>', '<filter name="Close Holes"/>')
    if former_filters()[old].idle:
        found = upgraded(data)
        assert [step.filter.name for step in found.script.steps] == ["Close Holes"]
        assert [change.same_meaning for change in found.changes] == [True]
    else:
        with pytest.raises(ScriptError, match=r"there is no such filter today: .{20}"):
            upgrade_script(data, "old.mlx")


@pytest.mark.parametrize(("operator", "today"), [("0", "Intersection"), ("1", "Union"), ("2", "Difference")])
def test_an_operation_on_solids_becomes_the_one_that_its_operator_says(operator: str, today: str) -> None:
    """One filter with an operator is three today; the layers keep their numbers, what told the resolution is left out."""
    params = [
        '<Param type="RichMesh" name="FirstMesh" value="1"/>',
        '<Param type="RichMesh" name="SecondMesh" value="0"/>',
        '<Param type="RichAbsPerc" name="Delta" value="0.1" min="0" max="1"/>',
        f'<Param type="RichEnum" name="Operator" value="{operator}" enum_cardinality="3"/>',
    ]
    found = upgraded(one_filter("CSG Operation", *params))
    assert found.script.steps[0].filter.name == f"Mesh Boolean: {today}"
    assert found.script.steps[0].values == {"first_mesh": 1, "second_mesh": 0}
    assert len(found.warnings) == 1


def test_an_operator_that_never_was_is_refused() -> None:
    """Without one it is the intersection, as it was."""
    assert upgraded(one_filter("CSG Operation")).script.steps[0].filter.name == "Mesh Boolean: Intersection"
    with pytest.raises(ScriptError, match="there is no such filter today"):
        upgrade_script(one_filter("CSG Operation", '<Param type="RichEnum" name="Operator" value="7"/>'), "old.mlx")


def test_every_name_of_meshlabs_history_is_known() -> None:
    """Each of 507 names is of today but for capital letters and blanks, has a successor, or is gone with a reason."""
    lines = (Path(__file__).parent / "meshlab_names.txt").read_text("utf-8").splitlines()[1:]
    names = [line[1:-1] for line in lines]
    assert len(names) == 507
    unknown = [name for name in names if same_but_case(name) is None and former_filter(name) is None]
    assert unknown == []


def test_capital_letters_and_blanks_of_a_former_name_do_not_count() -> None:
    """MeshLab changed them on the way: 2012 had 'Remove T-Vertices by edge flip'."""
    found = upgraded(one_filter("Remove T-Vertices by  edge flip"))
    assert found.script.steps[0].values == {"method": "Edge Flip"}
    assert not found.warnings


def test_a_choice_keeps_its_number_where_its_word_was_wrong() -> None:
    """Until 2020 the weight 1 of vertex normals was called 'By Angle' and was by area, as the number 1 still is."""
    words = "enum_val0='None (avg)' enum_val1='By Angle' enum_val2='By Area' enum_val3='As defined by N. Max'"
    param = f'<Param type="RichEnum" name="weightMode" value="1" enum_cardinality="4" {words}/>'
    found = upgraded(one_filter("Recompute Vertex Normals", param))
    assert found.script.steps[0].values == {"weightmode": "By Area"}
    assert not found.warnings
    new = (
        param.replace("By Angle", "x")
        .replace("By Area", "By Angle")
        .replace("'x'", "'By Area'")
        .replace("None (avg)", "Simple Average")
    )
    assert len(upgraded(one_filter("Recompute Vertex Normals", new)).changes) == 1


def test_one_angle_becomes_two() -> None:
    """Creases were once found by one angle; now by one for either side, of which one is negative."""
    angle = '<Param type="RichFloat" name="AngleDeg" value="{}"/>'.format
    crease = "Crease Marking with NonFaux Edges"
    assert values(one_filter(crease, angle("30"))) == {"angledegneg": -30.0, "angledegpos": 30.0}
    assert values(one_filter(crease, angle("-30"))) == {"angledegneg": 30.0, "angledegpos": -30.0}


@pytest.mark.parametrize(("old", "method"), [("by removing faces", "Remove Faces"), ("by splitting vertices", "Split Vertices")])
def test_merged_filters_say_which_method_they_were(old: str, method: str) -> None:
    """Without its method the merged filter would remove faces, whatever the old one did."""
    found = upgraded(one_filter(f"{REPAIR} {old}"))
    assert dict(found.script.steps[0].values) == {"method": method}
    assert not found.warnings


def test_parameters_follow_their_new_names_and_kinds() -> None:
    """Renamed parameters keep their value, one that became a choice sets it, and those that are gone are left out."""
    param = '<Param type="RichBool" name="{}" value="{}"/>'.format
    assert values(
        one_filter("Transform: Align to Principal Axis", param("FreezeMatrix", "false"), param("UseVertex", "true"))
    ) == {
        "pointsflag": True,
        "freeze": False,
    }
    assert values(one_filter("Transform: Rotate", param("ToAll", "true"))) == {"alllayers": True}
    move = "Transform: Move, Translate, Center"
    assert values(one_filter(move, param("centerFlag", "true"))) == {"traslmethod": "Center on Layer BBox"}
    assert values(one_filter(move, param("centerFlag", "false"))) == {}
    assert upgraded(one_filter("Convex Hull", param("reorient", "true"))).warnings == ()
    assert len(upgraded(one_filter("Convex Hull", param("reorient", "false"))).warnings) == 1


def test_a_texture_that_exists_is_set_as_ever(tmp_path: Path) -> None:
    """`Set Texture` with the size of a picture to paint takes the one that is there, and plain pymeshlab saves the result.

    That none is painted where there is none is said.
    """
    picture = SAMPLES / "TextureDouble_A.png"
    params = [
        f'<Param type="RichString" name="textName" value="{picture}"/>',
        '<Param type="RichInt" name="textDim" value="64"/>',
    ]
    found = upgraded(one_filter("Set Texture", *params))
    assert ["the picture has to exist" in warning for warning in found.warnings] == [True]
    (tmp_path / "new.mlx").write_text(format_script(found.script, known_mesh=False), encoding="utf-8")
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(SAMPLES / "bunny10k_textured.obj"))
    meshes.load_filter_script(str(tmp_path / "new.mlx"))
    meshes.apply_filter_script()
    assert [Path(name).name for name in meshes.current_mesh().textures()] == [picture.name]
    meshes.save_current_mesh(str(tmp_path / "out.obj"))


def test_parameters_of_the_unscreened_reconstruction_mean_it_under_every_name() -> None:
    """`OctDepth` is of the old filter alone, so that a name that no MeshLab had means with it what its sister means."""
    depth = '<Param type="RichInt" name="OctDepth" value="9"/>'
    assert values(one_filter("Poisson Reconstruction", depth)) == values(one_filter("Surface Reconstruction: Poisson", depth))
    assert values(one_filter("Poisson Reconstruction", depth.replace("OctDepth", "depth"))) == {"depth": 9}


def test_the_old_poisson_filter_is_the_unscreened_one_of_today() -> None:
    """Depth and samples keep their values, the weight of the points is 0, and an offset other than 1 is a change of meaning."""
    params = [
        '<Param type="RichInt" name="OctDepth" value="9"/>',
        '<Param type="RichInt" name="SolverDivide" value="7"/>',
        '<Param type="RichFloat" name="SamplesPerNode" value="5"/>',
    ]
    found = upgraded(one_filter("Surface Reconstruction: Poisson", *params, '<Param type="RichFloat" name="Offset" value="1"/>'))
    assert dict(found.script.steps[0].values) == {"depth": 9, "samplespernode": 5.0, "pointweight": 0.0}
    assert len(found.warnings) == 1
    other = upgraded(one_filter("Surface Reconstruction: Poisson", *params, '<Param type="RichFloat" name="Offset" value="2"/>'))
    assert len(other.warnings) == 2


def test_xmlfilters_get_the_types_of_their_parameters() -> None:
    """An <xmlfilter> of MeshLab 2016 becomes a <filter> whose values are those of its <xmlparam>s."""
    data = script(
        '<xmlfilter name="Screened Poisson Surface Reconstruction">',
        '<xmlparam name="depth" value="6"/>',
        '<xmlparam name="confidence" value="false"/>',
        '<xmlparam name="scale" value="1.25"/>',
        "</xmlfilter>",
    )
    assert values(data) == {"depth": 6, "confidence": False, "scale": 1.25}


@pytest.mark.parametrize(
    ("param", "value"),
    [
        ('type="RichPoint3f" name="viewPos" x="1" y="2" z="3"', (1.0, 2.0, 3.0)),
        ('type="RichInt" name="k" value="7"', 7),
        ('type="RichFloat" name="K" value="7"', 7),
        ('type="RichBool" name="flipFlag" value="True"', True),
    ],
)
def test_types_case_and_missing_attributes_are_mended(param: str, value: Any) -> None:
    """A value that can be read in the type of its parameter gets that type; capital letters do not matter."""
    (got,) = values(one_filter("Compute Normals for Point Sets", f"<Param {param}/>")).values()
    assert got == value


@pytest.mark.parametrize(("name", "warned"), [("OctDepth", False), ("depth", False), ("Depth", True), ("pointweight", True)])
def test_a_parameter_in_letters_that_no_meshlab_reads_is_a_change_of_meaning(name: str, warned: bool) -> None:
    """MeshLab tells capital letters apart and takes the default; old names that a version had mean what they meant."""
    param = (
        f'<Param type="RichFloat" name="{name}" value="6"/>'
        if "w" in name
        else f'<Param type="RichInt" name="{name}" value="6"/>'
    )
    assert bool(upgraded(one_filter(POISSON, param)).warnings) is warned


def test_a_value_without_a_type_stays_without_effect() -> None:
    """Every MeshLab drops it and takes its default: so does the upgraded script."""
    data = one_filter("Compute Normals for Point Sets", '<Param name="K" value="7"/>')
    found = upgraded(data)
    assert dict(found.script.steps[0].values) == {}
    assert "without a type every MeshLab ignores" in str(found.changes[-1])
    assert not found.warnings


@pytest.mark.parametrize(
    ("name", "warned"), [("Taubin Smooth", 1), ("Laplacian smooth (surface preserve)", 0)], ids=["of today", "of old"]
)
def test_a_value_that_meshlab_reads_otherwise_today_is_a_change_of_meaning(name: str, warned: int) -> None:
    """In a filter of today a wrong type is read as 0, so that setting the value is a change; a filter of old is not run."""
    known = find_filter(former.now if (former := former_filter(name)) and former.now else name)
    number = next(p.xml_name for p in known.parameters if p.xml_type in ("RichInt", "RichDynamicFloat", "RichFloat"))
    found = upgraded(one_filter(name, f'<Param type="RichBool" name="{number}" value="3"/>'))
    assert len([text for text in found.warnings if "reads another value" in text]) == warned


@pytest.mark.parametrize(
    ("written", "warned"), [("FALSE", True), ("False", True), ("1", True), (" true", True), ("TRUE", False), ("true", False)]
)
def test_a_switch_that_meshlab_reads_otherwise_is_a_change_of_meaning(written: str, warned: bool) -> None:
    """MeshLab reads FALSE as true, and drops 1, so that the switch which is meant is another one; TRUE is true there, too."""
    found = upgraded(one_filter("Taubin Smooth", f'<Param type="RichBool" name="Selected" value="{written}"/>'))
    assert bool(found.warnings) is warned


@pytest.mark.parametrize(("again", "warned"), [("true", False), ("false", True)])
def test_a_parameter_given_twice_changes_the_meaning_only_if_its_values_differ(again: str, warned: bool) -> None:
    """The two texts TRUE and true are one value; of two values the last one is kept."""
    params = [f'<Param type="RichBool" name="Selected" value="{text}"/>' for text in ("TRUE", again)]
    assert bool(upgraded(one_filter("Taubin Smooth", *params)).warnings) is warned


@pytest.mark.parametrize(("again", "warned"), [("0.5", False), ("0.4", True)])
def test_a_slider_with_other_bounds_is_the_same_value(again: str, warned: bool) -> None:
    """MeshLab takes the value alone, so that `min` and `max` of a parameter given twice change no meaning."""
    given = [f'type="RichAbsPerc" name="Threshold" value="{v}" min="0" max="{top}"' for v, top in (("0.5", 1), (again, 2))]
    found = upgraded(one_filter("Merge Close Vertices", *(f"<Param {param}/>" for param in given)))
    assert len(found.changes) == 1
    assert bool(found.warnings) is warned


@pytest.mark.parametrize(
    ("name", "param", "added"),
    [
        ("Subdivision Surfaces: Catmull-Clark", "", {"iterations": 1}),
        ("Catmull-Clark Subdivision Surfaces", "", {"iterations": 1}),
        (
            "Compute curvature principal directions",
            '<Param type="RichInt" name="Method" value="1"/>',
            {"scale": Length(5.0, "percent")},
        ),
        (PRINCIPAL, '<Param type="RichInt" name="Method" value="0"/>', {}),
    ],
)
def test_a_parameter_that_older_versions_lacked_gets_the_value_that_does_the_same(
    name: str, param: str, added: dict[str, Any]
) -> None:
    """Today's default would make four times as many faces, or measure over twice the size: measured with MeshLab 2020.09."""
    found = upgraded(one_filter(name, param))
    written = dict(found.script.steps[0].values)
    written.pop("method", None)
    assert written == added
    assert bool(found.warnings) == bool(added)


def test_a_second_document_type_is_left_out() -> None:
    """The script behind two document types is read, with its lines as they are."""
    found = upgraded(
        b"<!DOCTYPE FilterScript>\n<!DOCTYPE FilterScript>\n<FilterScript>\n<filter name='Close Holes'/></FilterScript>"
    )
    assert found.script.steps[0].line == 4
    assert [change.same_meaning for change in found.changes] == [True]


def test_what_nothing_is_known_of_is_refused_as_ever() -> None:
    """A value that no type can read and an unknown filter keep their problems and their lines."""
    data = script(
        '<filter name="Taubin Smooth">',
        '<Param type="RichInt" name="stepSmoothNum" value="three"/>',
        "</filter>",
        '<filter name="Make It Nice"/>',
    )
    with pytest.raises(ScriptError) as caught:
        upgrade_script(data, "old.mlx")
    assert [problem.line for problem in caught.value.problems] == [4, 6]


def test_a_parameter_that_no_version_has_is_left_out_as_a_change_of_meaning() -> None:
    """Plain MeshLab warns of it and goes on: so does the upgraded script once that is accepted, and the nearest name is said."""
    decimate = "Quadric Edge Collapse Decimation"
    param = '<Param type="RichFloat" name="{}" value="1"/>'.format
    found = upgraded(one_filter(decimate, param("BoundaryValue"), param("BoundaryWeigth")))
    assert dict(found.script.steps[0].values) == {}
    first, second = found.warnings
    assert "no version of MeshLab has such a parameter" in first
    assert "'BoundaryWeight'" in second


def old_poisson(*after: str) -> bytes:
    """A script of MeshLab 2016 that reconstructs, and then does something."""
    return script('<xmlfilter name="Screened Poisson Surface Reconstruction"/>', *after)


def test_the_input_is_no_longer_deleted_by_a_step_that_would_delete_the_result() -> None:
    """Delete Current Mesh behind a reconstruction once deleted its input; today it would delete its result, and is left out."""
    found = upgraded(old_poisson('<filter name="Delete Current Mesh"/>', '<filter name="Close Holes"/>'))
    assert [step.filter.name for step in found.script.steps] == [POISSON, "Close Holes"]
    assert not found.warnings
    found = upgraded(old_poisson('<filter name="Delete Current Mesh"/>', '<filter name="Flatten Visible Layers"/>'))
    assert ["now nothing is deleted" in text for text in found.warnings] == [True]
    found = upgraded(script('<filter name="Surface Reconstruction: Poisson"/>', '<filter name="Delete Current Mesh"/>'))
    assert ["now nothing is deleted" in text for text in found.warnings] == [False, True]
    found = upgraded(script(f'<filter name="{POISSON}"/>', '<filter name="Delete Current Mesh"/>'))
    assert ["now nothing is deleted" in text for text in found.warnings] == [True]


def test_steps_after_an_old_reconstruction_work_on_its_result() -> None:
    """In MeshLab 2016 they worked on the input: the meaning changes, and that is said. A script of today is left alone."""
    assert len(upgraded(old_poisson('<filter name="Close Holes"/>')).warnings) == 1
    today = script(f'<filter name="{POISSON}"/>', '<filter name="Close Holes"/>')
    assert upgraded(today).changes == ()


def test_a_leftover_selection_is_not_worked_on() -> None:
    """A step behind Close Holes that does not say Selected gets false, unless the holes or another step say otherwise."""
    smooth = '<filter name="Laplacian Smooth"/>'
    found = upgraded(script('<filter name="Close Holes"/>', smooth))
    assert found.script.steps[1].values["selected"] is False
    assert len(found.warnings) == 1
    unselected = '<filter name="Close Holes"><Param type="RichBool" name="NewFaceSelected" value="false"/></filter>'
    assert upgraded(script(unselected, smooth)).changes == ()
    assert upgraded(script('<filter name="Close Holes"/>', '<filter name="Select All"/>', smooth)).changes == ()


def test_lengths_become_parts_of_the_mesh_they_were_made_for() -> None:
    """A length of 2 on a mesh with a diagonal of 40 is 5 %; 0 stays 0, and so does a length that is relative."""
    data = one_filter("Merge Close Vertices", '<Param type="RichAbsPerc" name="Threshold" value="2" min="0" max="40"/>')
    (step,) = relative_script(upgraded(data), [40.0]).script.steps
    assert step.values == {"threshold": Length(5.0, "percent")}
    zero = relative_script(upgraded(data.replace(b'value="2"', b'value="0"')), [40.0])
    assert zero.script.steps[0].values == {"threshold": Length(0.0)}
    assert relative_script(relative_script(upgraded(data), [40.0]), [7.0]).script.steps == (step,)


def test_comments_that_are_not_kept_are_told() -> None:
    """The head stays; those between the steps, within one and at the end are one change, at the line of the first."""
    step = '<filter name="Taubin Smooth"/>'
    kept, lost = b"<!-- head -->", b"<!-- end -->"
    found = upgraded(kept + script(step, "<!-- between -->", '<filter name="Taubin Smooth"><!-- within --></filter>') + lost)
    assert found.script.comment == "head"
    assert list(map(str, found.changes)) == ["line 4: comments between the steps and at the end are left out (3) (same meaning)"]
    assert upgraded(kept + script(step)).changes == ()


OLD = script(
    '<filter name="Remove Duplicated Vertex"/>',
    f'<filter name="{REPAIR} by splitting vertices"/>',
    '<filter name="Transform: Scale">',
    '<Param type="RichFloat" name="axisx" value="3"/>',
    "</filter>",
    '<filter name="Laplacian smooth (surface preserve)"/>',
    '<filter name="Transform: Move, Translate, Center">',
    '<Param type="RichBool" name="centerFlag" value="true"/>',
    "</filter>",
)


def test_an_upgraded_script_gives_plain_pymeshlab_the_mesh_that_its_filters_give(tmp_path: Path) -> None:
    """Pymeshlab loads the written script and gives the coordinates that calls of the same filters give, to the bit."""
    path = tmp_path / "new.mlx"
    path.write_text(format_script(upgraded(OLD).script, known_mesh=False), encoding="utf-8")
    # Decimation is left out, as it orders ties and faces differently from call to call.
    by_script, by_calls = pymeshlab.MeshSet(), pymeshlab.MeshSet()
    for meshes in (by_script, by_calls):
        meshes.create_cone()
    before = by_calls.current_mesh().vertex_matrix()
    by_script.load_filter_script(str(path))
    by_script.apply_filter_script()
    by_calls.meshing_remove_duplicate_vertices()
    by_calls.meshing_repair_non_manifold_edges(method="Split Vertices")
    by_calls.compute_matrix_from_scaling_or_normalization(axisx=3.0)
    by_calls.apply_coord_laplacian_smoothing_surface_preserving()
    by_calls.compute_matrix_from_translation(traslmethod="Center on Layer BBox")
    meshes = [m.current_mesh() for m in (by_script, by_calls)]
    assert not np.allclose(meshes[0].vertex_matrix(), before)
    assert np.array_equal(meshes[0].vertex_matrix(), meshes[1].vertex_matrix())
    assert np.array_equal(meshes[0].face_matrix(), meshes[1].face_matrix())


def test_every_fact_about_a_parameter_leads_to_one_of_today() -> None:
    """New names, set values and dropped names of the table agree with the filters of today."""
    for former in (*former_filters().values(), *parameter_facts().values()):
        if former.now is not None:
            today = {p.xml_name for p in find_filter(former.now).parameters}
            turned = {name for cases in former.turns.values() for case in cases.values() for name in case}
            assert {*former.renames.values(), *former.sets, *turned} <= today
            assert not {*former.renames, *former.drops, *former.loses, *former.turns} & today


def test_a_switch_without_a_value_is_refused_as_in_any_script() -> None:
    """Nothing can be upgraded there, and the script is refused with the line of the parameter."""
    with pytest.raises(ScriptError, match=r"old\.mlx:4: .*'Selected': the attribute value is missing"):
        upgrade_script(one_filter("Taubin Smooth", '<Param type="RichBool" name="Selected"/>'), "old.mlx")

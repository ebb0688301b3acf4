"""`pymeshfair export` writes what plain pymeshlab runs alike, and refuses what it could not run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from pymeshfair import MeshSet
from pymeshfair.registry import find_filter
from pymeshfair.scripts import Script, ScriptError, Step, format_script, read_script
from pymeshfair.scripts.values import parse_value
from pymeshfair.scripts.write import MeshFacts, export_script

from .command_line import document, invoke

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"
RELATIVE = """<!DOCTYPE FilterScript>
<FilterScript>
  <filter name="Remove Isolated pieces (wrt Diameter)">
    <Param type="RichAbsPerc" name="MinComponentDiag" value="10" min="0" max="100" relative="10%"/>
  </filter>
  <filter name="Taubin Smooth"/>
</FilterScript>
"""


@pytest.fixture
def recipe(tmp_path: Path) -> Path:
    """A script with a relative length and a step that leaves everything to defaults."""
    path = tmp_path / "relative.mlx"
    path.write_text(RELATIVE, encoding="utf-8")
    return path


@pytest.fixture
def sphere(tmp_path: Path) -> Path:
    """A sphere of radius 5."""
    meshes = MeshSet()
    meshes.create_sphere(subdiv=2, radius=5.0)
    path = tmp_path / "sphere.ply"
    meshes.save_current_mesh(str(path))
    return path


def test_lengths_are_mesh_units_of_the_mesh_and_every_parameter_is_there(recipe: Path, sphere: Path, tmp_path: Path) -> None:
    """10 % of the sphere's diagonal is written as such, without relative=, with all parameters in MeshLab's order."""
    plain = tmp_path / "plain.mlx"
    assert invoke("export", recipe, "-o", plain, "--for", sphere).exit_code == 0
    assert "relative=" not in plain.read_text("utf-8")
    pieces, taubin = read_script(plain).steps
    assert pieces.values["mincomponentdiag"].amount == pytest.approx(0.1 * 10 * 3**0.5, rel=1e-6)
    assert list(taubin.values) == ["lambda_", "mu", "stepsmoothnum"]
    by_script, by_calls = pymeshlab.MeshSet(), pymeshlab.MeshSet()
    for meshes in (by_script, by_calls):
        meshes.load_new_mesh(str(sphere))
    by_script.load_filter_script(str(plain))
    by_script.apply_filter_script()
    by_calls.apply_coord_taubin_smoothing()
    assert np.array_equal(by_script.current_mesh().vertex_matrix(), by_calls.current_mesh().vertex_matrix())


SCALED = """<!DOCTYPE FilterScript>
<FilterScript>
  <filter name="Transform: Scale, Normalize"><Param type="RichFloat" name="axisX" value="10"/></filter>
  <filter name="Merge Close Vertices">
    <Param type="RichAbsPerc" name="Threshold" value="1" min="0" max="100" relative="1%"/>
  </filter>
</FilterScript>
"""


def test_lengths_are_those_of_the_mesh_that_the_step_meets(tmp_path: Path) -> None:
    """Behind a step that makes the mesh ten times larger 1 % is ten times as long, and plain pymeshlab gives what a run gives."""
    recipe, plain, bone = tmp_path / "scaled.mlx", tmp_path / "plain.mlx", SAMPLES / "bone.ply"
    recipe.write_text(SCALED, encoding="utf-8")
    done = invoke("export", recipe, "-o", plain, "--for", bone)
    assert done.exit_code == 0, done.stderr
    ours, theirs = MeshSet(), pymeshlab.MeshSet()
    for meshes, script in ((ours, recipe), (theirs, plain)):
        meshes.load_new_mesh(str(bone))
        before = meshes.current_mesh().vertex_number()
        meshes.load_filter_script(str(script))
        meshes.apply_filter_script()
    found = theirs.current_mesh().vertex_matrix()
    assert len(found) < before
    np.testing.assert_array_equal(found, ours.current_mesh().vertex_matrix())


def test_the_steps_that_are_measured_have_the_name_of_their_recipe(sphere: Path, tmp_path: Path) -> None:
    """The error about a mesh names the recipe for clouds; advice for one that needs two meshes is advice that export can take."""
    refused = invoke("export", "cloud_to_mesh", "-o", tmp_path / "plain.mlx", "--for", sphere)
    assert refused.exit_code != 0
    assert "cloud_to_mesh is for clouds of points" in refused.stderr
    script(tmp_path / "two.mlx", filter_element("transfer_attributes_per_vertex", sourcemesh="1", targetmesh="0"))
    refused = invoke("export", tmp_path / "two.mlx", "-o", tmp_path / "plain.mlx", "--for", sphere)
    assert refused.exit_code == 2
    assert "there is only layer 0; --for runs the steps on one mesh alone: write the lengths of this step" in refused.stderr
    assert "--with" not in refused.stderr


def test_relative_lengths_need_a_mesh(recipe: Path, tmp_path: Path) -> None:
    """Without --for the length is named with its line, and nothing is written."""
    refused = invoke("export", recipe, "-o", tmp_path / "plain.mlx", "--json")
    assert refused.exit_code == 2
    (problem,) = document(refused.stdout)["error"]["problems"]
    assert (problem["line"], problem["parameter"]) == (3, "MinComponentDiag")
    assert not (tmp_path / "plain.mlx").exists()


def test_filters_that_meshlab_lacks_are_named_and_refused(tmp_path: Path, sphere: Path) -> None:
    """A recipe with a filter of ours is refused, with the name of the filter."""
    refused = invoke("export", "smooth_implicit", "-o", tmp_path / "plain.mlx", "--for", sphere, "--json")
    assert refused.exit_code == 2
    problems = document(refused.stdout)["error"]["problems"]
    assert problems
    assert all("which MeshLab lacks" in problem["message"] for problem in problems)
    assert not (tmp_path / "plain.mlx").exists()


def script(path: Path, *filters: str) -> Path:
    """A script of these elements."""
    path.write_text(f"<!DOCTYPE FilterScript><FilterScript>{''.join(filters)}</FilterScript>", encoding="utf-8")
    return path


def filter_element(name: str, **values: str) -> str:
    """The element of a filter whose values, choices by number, are given as texts."""
    known = find_filter(name)
    step = Step(known).with_values({n: parse_value(known.parameter(n), text) for n, text in values.items()})
    return "".join(format_script(Script((step,))).splitlines(keepends=True)[2:-1])


#: what is to be known of the sphere
CLOSED = MeshFacts(10.0 * 3**0.5, 1.0, closed=True)
#: values with which our filters do what MeshLab's do
UNIFORM = {"update": "meshlab", "operator": "uniform", "iterations": "4"}
EQUAL = (
    ("apply_coord_explicit_smoothing", {**UNIFORM, "border": "along"}, "Laplacian Smooth"),
    ("apply_coord_explicit_smoothing", {**UNIFORM, "border": "free"}, "Laplacian Smooth"),
    ("apply_coord_taubin_fairing", {"step": "0.5", "mu": "-0.53125", "iterations": "4"}, "Taubin Smooth"),
)


@pytest.mark.parametrize(("name", "values", "equal"), EQUAL)
def test_a_filter_of_ours_is_replaced_by_its_equal(
    name: str, values: dict[str, str], equal: str, sphere: Path, tmp_path: Path
) -> None:
    """The exported script makes in plain pymeshlab the mesh that ours makes, to rounding, and it is said what was replaced."""
    ours = script(tmp_path / "ours.mlx", filter_element(name, **values))
    text, (told,) = export_script(read_script(ours), mesh=CLOSED)
    (tmp_path / "plain.mlx").write_text(text, encoding="utf-8")
    assert f"is MeshLab's {equal!r}, which does the same" in told
    meshes, plain = MeshSet(), pymeshlab.MeshSet()
    for each, path in ((meshes, ours), (plain, tmp_path / "plain.mlx")):
        each.load_new_mesh(str(sphere))
        before = each.current_mesh().vertex_matrix()
        each.load_filter_script(str(path))
        each.apply_filter_script()
    found = plain.current_mesh().vertex_matrix()
    assert np.abs(found - before).max() > 1e-3
    np.testing.assert_allclose(found, meshes.current_mesh().vertex_matrix(), atol=1e-12)


TAUBIN = filter_element("apply_coord_taubin_fairing")


@pytest.mark.parametrize(
    ("elements", "why"),
    [
        (["<filter name='Delete Selected Faces'/>", TAUBIN], "an earlier step may open it or make a selection"),
        (["<filter name='Select Border'/>", TAUBIN], "an earlier step may open it or make a selection"),
        ([filter_element("apply_coord_taubin_fairing", operator="cotangent")], "cannot run this step"),
        ([filter_element("apply_coord_taubin_fairing", pass_band="0.1")], "cannot run this step"),
        ([filter_element("apply_coord_taubin_fairing", selected="true")], "cannot run this step"),
        ([filter_element("apply_coord_explicit_smoothing")], "cannot run this step"),
        ([filter_element("apply_coord_explicit_smoothing", **UNIFORM, border="fixed")], "cannot run this step"),
        ([filter_element("apply_coord_explicit_smoothing", update="meshlab", operator="cotangent")], "cannot run this step"),
    ],
)
def test_what_is_not_equal_is_refused(elements: list[str], why: str, tmp_path: Path) -> None:
    """Another operator, a selection, or a mesh that a step may have opened: the reason is said."""
    with pytest.raises(ScriptError) as refused:
        export_script(read_script(script(tmp_path / "ours.mlx", *elements)), mesh=CLOSED)
    (problem,) = refused.value.problems
    assert why in problem.message


def test_taubin_is_replaced_on_a_closed_mesh_alone(sphere: Path, tmp_path: Path) -> None:
    """Without a mesh the message asks for one; an open one is refused."""
    ours = script(tmp_path / "ours.mlx", TAUBIN)
    unknown = invoke("export", ours, "-o", tmp_path / "plain.mlx")
    assert "say with --for MESH which mesh the script is for" in unknown.stderr
    with pytest.raises(ScriptError, match="and this one is open"):
        export_script(read_script(ours), mesh=replace(CLOSED, closed=False))
    told = invoke("export", ours, "-o", tmp_path / "plain.mlx", "--for", sphere)
    assert "step 1, 'Taubin Fairing', is MeshLab's 'Taubin Smooth', which does the same" in told.stdout


def test_settings_tags_and_limits_are_left_out(tmp_path: Path) -> None:
    """MeshLab knows none of them; the steps keep their values."""
    recipe = tmp_path / "settings.mlx"
    recipe.write_text(
        '<FilterScript require="watertight"><setting name="rounds" default="3"/><filter name="Taubin Smooth" tag="smooth">'
        '<Param type="RichInt" name="stepSmoothNum" value="3" setting="rounds"/></filter></FilterScript>',
        encoding="utf-8",
    )
    assert invoke("export", recipe, "-o", tmp_path / "plain.mlx").exit_code == 0
    text = (tmp_path / "plain.mlx").read_text(encoding="utf-8")
    assert not [word for word in ("setting", "tag", "require") if word in text]
    assert 'name="stepSmoothNum" value="3"' in text

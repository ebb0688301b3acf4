"""Recipes as objects of Python: built, loaded, checked, run, saved and shown."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

import pymeshfair
from pymeshfair import MeshSet, Recipe
from pymeshfair.declaration import Length
from pymeshfair.errors import GuardBroken, ParameterError, UnknownNameError
from pymeshfair.meshlab.base import ScriptStepFailedError
from pymeshfair.recipe import load_recipe
from pymeshfair.scripts import parse_script
from tests.meshes import icosphere


def built() -> Recipe:
    """A recipe of three steps, two of which use one setting."""
    recipe = Recipe("clean", "Clean <it>\n\nFor: balls.")
    size = recipe.setting("size", "20%", unit="length", description="Smaller things go.")
    recipe.meshing_remove_connected_component_by_diameter(mincomponentdiag=size)
    recipe.meshing_isotropic_explicit_remeshing(iterations=1, targetlen=size)
    recipe.apply_coord_taubin_fairing(iterations=2, step=0.4)
    recipe.tag("smooth")
    return recipe


def ball() -> MeshSet:
    """A mesh set with one sphere."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*icosphere(3)))
    return meshes


def test_a_recipe_is_built_saved_and_loaded(tmp_path: Path) -> None:
    """Steps, settings, tags and comment come back from the file; what was left out is said there with its default."""
    recipe = built()
    recipe.save(tmp_path / "clean.mlx")
    loaded = Recipe.load(tmp_path / "clean.mlx")
    assert loaded.script == recipe.script.with_defaults()
    assert loaded == recipe
    recipe.set("smooth.iterations=3")
    assert loaded != recipe
    assert loaded == Recipe.load(str(tmp_path / "clean.mlx"))
    assert (loaded.name, loaded.script.comment) == ("clean", "Clean <it>\n\nFor: balls.")
    assert [s.name for s in loaded.script.settings] == ["size"]
    assert [step.tag for step in loaded] == ["", "", "smooth"]


def test_a_comment_is_the_same_before_and_after_its_file(tmp_path: Path) -> None:
    """Indentation and empty lines at the ends are left out at once, so that the first line is the title."""
    recipe = Recipe("own", "\n    My title \n\n    For: balls.\n    ")
    recipe.apply_coord_taubin_fairing()
    recipe.save(tmp_path / "own.mlx")
    assert recipe.script.comment == "My title\n\nFor: balls."
    assert Recipe.load(tmp_path / "own.mlx") == recipe


def test_steps_are_counted_and_iterated() -> None:
    """A recipe is a sequence of steps with checked values."""
    recipe = built()
    assert len(recipe) == 3
    assert [step.filter.name for step in recipe][2] == recipe[-1].filter.name == "Taubin Fairing"
    assert recipe[1].values["targetlen"] == Length(20.0, "percent")
    assert "meshing_isotropic_explicit_remeshing, apply_coord_taubin_fairing" in repr(recipe)
    assert repr(Recipe("new")) == "<Recipe 'new': no steps>"


def test_wrong_steps_are_refused_when_they_are_added() -> None:
    """A wrong name, value, setting or tag leaves the recipe as it was and gets the message that a script would get."""
    recipe = built()
    before = recipe.script
    with pytest.raises(AttributeError, match="did you mean 'meshing_close_holes'"):
        recipe.meshing_close_hole()  # type: ignore[attr-defined]
    with pytest.raises(UnknownNameError, match="did you mean 'maxholesize'"):
        recipe.meshing_close_holes(maxholesiz=3)  # type: ignore[call-arg]
    with pytest.raises(ParameterError, match="takes a length such as '1%'"):
        recipe.meshing_merge_close_vertices(threshold=pymeshlab.PercentageValue(1))
    with pytest.raises(ParameterError, match="another setting 'size' already, whose default is 20%"):
        recipe.meshing_merge_close_vertices(threshold=recipe.setting("size", "1%"))
    with pytest.raises(ParameterError, match="'x >' is no expression that MeshLab can evaluate: it knows"):
        recipe.compute_selection_by_condition_per_vertex(condselect="x >")
    with pytest.raises(ParameterError, match="must consist of letters"):
        recipe.setting("a b", "1%")
    with pytest.raises(ParameterError, match="must consist of letters"):
        recipe.tag("a.b")
    with pytest.raises(ParameterError, match="there is no step 3; the recipe has 3"):
        recipe.tag("third", step=3)
    with pytest.raises(UnknownNameError, match="no setting 'sizes'"):
        recipe.set("smooth.iterations=3", sizes="1%")
    assert recipe.script is before


def test_lengths_of_pymeshlab_are_taken_where_their_meaning_is_known() -> None:
    """A part of the diagonal in a plugin's filter, mesh units in all; those of MeshLab's filters may be of other lengths."""
    recipe, written = Recipe(), Recipe()
    recipe.apply_coord_implicit_fairing(detail_size=pymeshlab.PercentageValue(3))
    recipe.apply_coord_implicit_fairing(detail_size=pymeshlab.PureValue(0.3))
    recipe.meshing_merge_close_vertices(threshold=pymeshlab.PureValue(0.1))
    written.apply_coord_implicit_fairing(detail_size="3%")
    written.apply_coord_implicit_fairing(detail_size="0.3")
    written.meshing_merge_close_vertices(threshold="0.1")
    assert recipe == written


def test_values_are_set_as_on_the_command_line() -> None:
    """A setting changes all steps that use it; TAG.PARAM=VALUE changes one."""
    recipe = built()
    recipe.set("smooth.iterations=5", size="30%")
    assert [recipe[0].values["mincomponentdiag"], recipe[1].values["targetlen"]] == [Length(30.0, "percent")] * 2
    assert recipe[2].values["iterations"] == 5


def test_a_setting_serves_parameters_of_every_type() -> None:
    """One text is read as each parameter takes it: here a whole number and a number."""
    recipe = Recipe("numbers")
    two = recipe.setting("two", "2")
    recipe.apply_coord_taubin_fairing(iterations=two)
    recipe.apply_scalar_anisotropic_diffusion_per_vertex(range_sigma=two)
    assert (recipe[0].values["iterations"], recipe[1].values["range_sigma"]) == (2, 2.0)
    recipe.set(two=3)
    assert (recipe[0].values["iterations"], recipe[1].values["range_sigma"]) == (3, 3.0)


def test_limits_are_set_and_kept(tmp_path: Path) -> None:
    """A limit is that of the command line, is written to the file and breaks a run that goes beyond it."""
    recipe = built()
    recipe.limit(max_displacement="0.001%", require="watertight")
    recipe.limit(require="components=1")
    recipe.save(tmp_path / "limited.mlx")
    assert Recipe.load(tmp_path / "limited.mlx").script.guards.texts() == {
        "max_displacement": "0.001%",
        "require": "components=1",
    }
    with pytest.raises(ParameterError, match="did you mean 'max_displacement'"):
        recipe.limit(max_displacment="1%")
    with pytest.raises(ParameterError, match="max_volume_change 'much' is no percentage"):
        recipe.limit(max_volume_change="much")
    with pytest.raises(ParameterError, match=r"^max_displacement is 5: write a text, such as '1%'$"):
        recipe.limit(max_displacement=5)  # type: ignore[arg-type]
    ball().save_current_mesh(str(tmp_path / "ball.ply"))
    with pytest.raises(GuardBroken, match="max_displacement"):
        recipe.run(tmp_path / "ball.ply", tmp_path / "out.ply")


def test_a_recipe_runs_on_a_mesh_set_and_on_a_file(tmp_path: Path) -> None:
    """Both ways give the mesh that the same calls on a mesh set give; each step's report comes back.

    The steps are such that MeshLab repeats to the bit; its remeshing now and then stops early.
    """
    recipe, expected = Recipe("clean"), ball()
    for steps in (recipe, expected):
        steps.meshing_remove_connected_component_by_diameter(mincomponentdiag="20%")
        steps.meshing_decimation_clustering(threshold="10%")
        steps.apply_coord_taubin_fairing(iterations=2, step=0.4)
    vertices = expected.current_mesh().vertex_matrix()
    meshes = ball()
    assert len(recipe.apply(meshes)) == 3
    np.testing.assert_array_equal(meshes.current_mesh().vertex_matrix(), vertices)
    ball().save_current_mesh(str(tmp_path / "ball.ply"))
    result = recipe.run(tmp_path / "ball.ply", tmp_path / "out.ply")
    assert [step.python_name for step in result.steps] == [step.filter.python_name for step in recipe]
    assert result.after["vertices"] == len(vertices) < 642


def test_a_failing_step_is_named() -> None:
    """The error says which step failed and why."""
    recipe = Recipe("fails")
    recipe.apply_coord_taubin_fairing()
    recipe.apply_coord_explicit_smoothing(selected=True)
    with pytest.raises(ScriptStepFailedError, match="step 2 of 2, 'Explicit Smoothing': "):
        recipe.apply(ball())


def test_a_check_tells_what_may_surprise(tmp_path: Path) -> None:
    """A length out of proportion is told for a mesh set and for a file, a missing layer without any mesh."""
    recipe = Recipe("checked")
    recipe.meshing_merge_close_vertices(threshold="5")
    assert recipe.check() == []
    (told,) = recipe.check(ball())
    assert "threshold is 5" in told
    ball().save_current_mesh(str(tmp_path / "ball.ply"))
    assert recipe.check(tmp_path / "ball.ply") == [told]
    recipe.get_hausdorff_distance(sampledmesh=0, targetmesh=1)
    assert ["is layer 1" in text for text in recipe.check()] == [True]
    assert recipe.check(layers=2) == []


def test_a_shipped_recipe_is_loaded_by_name() -> None:
    """It is the recipe that the command line runs."""
    assert Recipe.load("smooth_taubin").script == load_recipe("smooth_taubin").script
    assert pymeshfair.Recipe is Recipe


def test_the_page_on_recipes_does_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its script is valid and means what its Python builds; the Python runs."""
    page = (Path(__file__).parents[1] / "docs/writing_recipes.md").read_text("utf-8")
    xml, python = (re.findall(rf"```{kind}\n(.*?)```", page, re.DOTALL) for kind in ("xml", "python"))
    monkeypatch.chdir(tmp_path)
    ball().save_current_mesh("scan.ply")
    scope: dict[str, Any] = {}
    exec(python[0], scope)
    written = parse_script(xml[0].encode(), "page")
    built = scope["recipe"].script
    assert replace(written, comment=built.comment) == built
    assert (tmp_path / "clean.ply").exists()

"""`pymeshfair export` writes what plain pymeshlab runs alike, and refuses what it could not run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from pymeshfair import MeshSet
from pymeshfair.scripts import read_script

from .command_line import document, invoke

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

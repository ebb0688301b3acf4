"""The recipes that fair, each on the kind of shape that it is for."""

from __future__ import annotations

import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from pymeshfair import MeshSet
from pymeshfair.filters.geometry import edge_lengths
from pymeshfair.filters.inspection.surface_measures import surface_measures
from pymeshfair.filters.topology import edges
from pymeshfair.recipe import load_recipe
from tests.meshes import Floats, Mesh, icosphere, noisy

EXAMPLES = Path(__file__).parents[1] / "examples"

RECIPES = ("fair_selection", "improve_triangles", "blend_parts")


def mesh_set(mesh: Mesh, **attributes: Floats) -> MeshSet:
    """A mesh set with this mesh alone."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*mesh, **attributes))
    return meshes


def apply(name: str, meshes: MeshSet) -> Floats:
    """The vertices of the current mesh after the recipe."""
    meshes.load_filter_script(str(load_recipe(name).script.path))
    meshes.apply_filter_script()
    return np.asarray(meshes.current_mesh().vertex_matrix())


@pytest.mark.parametrize("name", RECIPES)
def test_every_parameter_is_written(name: str) -> None:
    """MeshLab's own reader fills nothing in, so each step says all."""
    for step in load_recipe(name).script.steps:
        assert set(step.values) == {p.name for p in step.filter.parameters}, step.filter.name


def dented_ball() -> tuple[Mesh, Floats]:
    """A unit sphere with a dent of depth 0.3 and rim radius 0.5 at the top, and colours with the dent in red."""
    vertices, faces = icosphere(4)
    inside = np.linalg.norm(vertices[:, :2], axis=1) / 0.5
    dent = np.where((inside < 1) & (vertices[:, 2] > 0), 0.3 * (1 - inside**2), 0.0)
    colors = np.ones((len(vertices), 4))
    colors[dent > 0, 1:3] = 0.0
    return ((1 - dent)[:, None] * vertices, faces), colors


@pytest.mark.parametrize("marked", ["painted", "selected"])
def test_a_dent_that_is_marked_goes(marked: str) -> None:
    """Of a dent 0.3 deep, painted red or selected, a twentieth is left; all other vertices keep every bit."""
    mesh, colors = dented_ball()
    meshes = mesh_set(mesh, v_color_matrix=colors) if marked == "painted" else mesh_set(mesh)
    dent = colors[:, 1] == 0.0
    if marked == "selected":
        meshes.compute_selection_by_condition_per_vertex(condselect="x^2 + y^2 + z^2 < 0.99999")
    found = apply("fair_selection", meshes)
    assert np.abs(np.linalg.norm(found[dent], axis=1) - 1).max() < 0.3 / 20
    left = (found == mesh[0]).all(axis=1)
    assert left[~dent].all()
    assert not left[dent].all()


def test_nothing_marked_is_said() -> None:
    """A mesh with no selected and no red vertex is refused with what to do."""
    with pytest.raises(pymeshlab.PyMeshLabException, match=r"nothing is selected in .*: select the vertices of the part"):
        apply("fair_selection", mesh_set(icosphere(2)))


def test_triangles_get_better_on_the_same_ball() -> None:
    """The mean quality rises by a tenth and more, and no vertex is further from the sphere than its edges are."""
    vertices, faces = noisy(icosphere(4), 0.015)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    found = apply("improve_triangles", mesh_set((vertices, faces)))
    before, after = (surface_measures(v, faces).triangle_quality for v in (vertices, found))
    assert before is not None
    assert after is not None
    assert after > 1.1 * before
    # A triangle of longest edge h lies up to h^2 / 6 below the unit sphere: its circumradius is h / sqrt(3) if it is equilateral.
    h = edge_lengths(vertices, edges(faces)).max()
    assert np.abs(np.linalg.norm(found, axis=1) - 1).max() < h**2 / 6


def test_two_tubes_in_two_layers_become_one() -> None:
    """The example's parts are one tube after the recipe: one component, two rims, oriented, the tubes themselves as they were."""
    example = runpy.run_path(str(EXAMPLES / "join_two_tubes.py"))
    meshes = example["two_tubes"]()
    parts = [meshes.mesh(i).vertex_matrix() for i in (0, 1)]
    found = apply("blend_parts", meshes)
    assert len(meshes) == 1
    np.testing.assert_array_equal(found[: len(parts[0]) + len(parts[1])], np.concatenate(parts))
    measures = surface_measures(found, meshes.current_mesh().face_matrix())
    assert (measures.components, measures.border_edges, measures.non_manifold_edges) == (1, 64 + 44, 0)
    assert meshes.current_mesh().selected_vertex_number() == len(found) - len(parts[0]) - len(parts[1])


@pytest.mark.slow
def test_the_example_writes_what_it_says(tmp_path: Path) -> None:
    """Run as a program, it saves the joined tubes and tells that they are one part with two open rims."""
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / "join_two_tubes.py"), str(tmp_path / "joined.ply")],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "1 part, 2 open rims, genus 0\n"
    assert (tmp_path / "joined.ply").stat().st_size > 0
    bare = subprocess.run([sys.executable, str(EXAMPLES / "join_two_tubes.py")], capture_output=True, text=True, check=False)
    assert bare.returncode == 1
    assert bare.stderr.startswith("usage: python join_two_tubes.py OUTPUT")

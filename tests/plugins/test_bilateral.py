"""Bilateral filters and anisotropic diffusion as MeshLab users meet them: on a mesh set, with names, lengths and help."""

from __future__ import annotations

from typing import Any

import numpy as np
import pymeshlab
import pytest
from numpy.typing import NDArray

import pymeshfair
from pymeshfair.declaration import Filter, MeshElement
from pymeshfair.filters.denoising.bilateral import bilateral_fleishman, bilateral_jones
from pymeshfair.filters.denoising.clouds import bilateral_projection
from pymeshfair.filters.diffusion.anisotropic import perona_malik
from pymeshfair.plugins import denoising, smoothing
from tests.meshes import Mesh, icosphere, noisy

Floats = NDArray[np.float64]

NAMES = (
    "apply_coord_bilateral_fleishman",
    "apply_coord_bilateral_jones",
    "apply_coord_bilateral_projection_of_points",
    "apply_scalar_anisotropic_diffusion_per_vertex",
    "apply_color_anisotropic_diffusion_per_vertex",
)
DECLARED: list[Filter] = [getattr(denoising if name in NAMES[:3] else smoothing, name) for name in NAMES]


def mesh_set(mesh: Mesh, **attributes: Any) -> pymeshfair.MeshSet:
    """A mesh set with this mesh alone."""
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(mesh[0], mesh[1], **attributes))
    return meshes


@pytest.mark.parametrize(
    ("name", "function"),
    [("apply_coord_bilateral_fleishman", bilateral_fleishman), ("apply_coord_bilateral_jones", bilateral_jones)],
)
def test_positions_are_those_of_the_function(name: str, function: Any) -> None:
    """Defaults leave both scales to the function; a length may be a percentage of the diagonal."""
    mesh = noisy(icosphere(3), 0.01)
    meshes = mesh_set(mesh)
    meshes.apply_filter(name)
    np.testing.assert_allclose(meshes.current_mesh().vertex_matrix(), function(*mesh), rtol=0, atol=1e-12)
    meshes = mesh_set(mesh)
    diagonal = meshes.current_mesh().bounding_box().diagonal()
    values = {"range_kernel": "tukey", "space_kernel": "l2", "border": "fixed"}
    meshes.apply_filter(name, range_sigma=pymeshlab.PercentageValue(2), space_sigma=pymeshlab.PureValue(0.2), **values)
    expected = function(*mesh, range_sigma=0.02 * diagonal, space_sigma=0.2, **values)
    np.testing.assert_allclose(meshes.current_mesh().vertex_matrix(), expected, rtol=0, atol=1e-12)


def test_points_are_projected_with_estimated_or_own_normals() -> None:
    """A cloud is filtered without faces, by normals of its neighbourhoods or by those that it carries."""
    points = noisy(icosphere(3), 0.01)[0]
    truth = icosphere(3)[0]
    for use, normals in ((False, None), (True, truth)):
        meshes = pymeshfair.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(points, v_normals_matrix=truth))
        meshes.apply_filter("apply_coord_bilateral_projection_of_points", use_normals=use, neighbors=12)
        expected = bilateral_projection(points, normals=normals, neighbors=12)
        np.testing.assert_allclose(meshes.current_mesh().vertex_matrix(), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("iterations", [2, "auto"])
def test_own_normals_that_points_lack_are_told(iterations: Any) -> None:
    """Points with normals of 0 would all stay, without a word or as free of noise."""
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(noisy(icosphere(3), 0.01)[0]))
    with pytest.raises(pymeshlab.PyMeshLabException, match="have no normals: compute them first, or use use_normals=False"):
        meshes.apply_filter("apply_coord_bilateral_projection_of_points", use_normals=True, iterations=iterations)


def test_a_far_vertex_does_not_matter_for_values() -> None:
    """Diffusion of scalars reads no coordinates: wherever a vertex lies, the values are the same."""
    vertices, faces = icosphere(2)
    values, found = np.sin(np.arange(len(vertices))), []
    for x in (0.0, 1e20):
        moved = np.where(np.arange(len(vertices))[:, None] == 3, [x, 0.0, 0.0], vertices)
        meshes = mesh_set((moved, faces), v_scalar_array=values)
        meshes.apply_filter("apply_scalar_anisotropic_diffusion_per_vertex")
        found.append(meshes.current_mesh().vertex_scalar_array())
    np.testing.assert_array_equal(found[0], found[1])


def test_points_are_projected_onto_quadrics() -> None:
    """The degree is that of the function."""
    points = noisy(icosphere(3), 0.01)[0]
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points))
    meshes.apply_filter("apply_coord_bilateral_projection_of_points", degree=2, neighbors=40)
    expected = bilateral_projection(points, degree=2, neighbors=40)
    np.testing.assert_allclose(meshes.current_mesh().vertex_matrix(), expected, rtol=0, atol=1e-12)


def test_scalars_are_diffused() -> None:
    """The scalar is that of the function, its step a share of the longest; positions keep every bit."""
    vertices, faces = icosphere(3)
    scalars = vertices[:, 2] + np.random.default_rng(0).normal(0, 0.05, len(vertices))
    meshes = mesh_set((vertices, faces), v_scalar_array=scalars)
    meshes.apply_filter("apply_scalar_anisotropic_diffusion_per_vertex", step=0.5, range_kernel="tukey", range_sigma=0.4)
    expected = perona_malik(scalars, faces, step=0.5 / 6, edge_stop="tukey", contrast=0.4)
    np.testing.assert_allclose(meshes.current_mesh().vertex_scalar_array(), expected, rtol=0, atol=1e-12)
    assert meshes.current_mesh().vertex_matrix().tobytes() == vertices.tobytes()


def test_colors_are_diffused_and_opacity_stays() -> None:
    """Red, green and blue are those of the function to the 8 bits of MeshLab's colours."""
    vertices, faces = icosphere(3)
    colors = np.random.default_rng(0).integers(0, 256, (len(vertices), 4)) / 255.0
    meshes = mesh_set((vertices, faces), v_color_matrix=colors)
    given = meshes.current_mesh().vertex_color_matrix()
    meshes.apply_filter("apply_color_anisotropic_diffusion_per_vertex", iterations=5)
    found = meshes.current_mesh().vertex_color_matrix()
    np.testing.assert_allclose(found[:, :3], perona_malik(given[:, :3], faces, iterations=5), rtol=0, atol=1.01 / 255)
    assert found[:, 3].tobytes() == given[:, 3].tobytes()


def test_a_step_of_0_is_refused() -> None:
    """It would change nothing; the message says what to take."""
    meshes = mesh_set(icosphere(2), v_scalar_array=icosphere(2)[0][:, 0].copy())
    with pytest.raises(pymeshlab.PyMeshLabException, match="step=0 changes nothing: take a share of the largest stable step"):
        meshes.apply_filter("apply_scalar_anisotropic_diffusion_per_vertex", step=0.0)


def test_requirements_and_changes_are_declared() -> None:
    """What a filter needs is checked before it runs; what it changes is said."""
    assert [bool(d.requires & MeshElement.FACENUMBER) for d in DECLARED] == [True, True, False, True, True]
    assert [d.changes for d in DECLARED[3:]] == [MeshElement.VERTQUALITY, MeshElement.VERTCOLOR]


def test_automatic_iterations_are_chosen_and_told() -> None:
    """What is told, given to the function, does the same; a cloud without noise keeps every bit, and a note says why."""
    truth = np.random.default_rng(0).normal(size=(2000, 3))
    truth /= np.linalg.norm(truth, axis=1, keepdims=True)
    points = truth + 0.02 * np.random.default_rng(1).normal(size=truth.shape)
    name = "apply_coord_bilateral_projection_of_points"
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points))
    told = meshes.apply_filter(name, iterations="auto")
    assert told["chosen"]["iterations"] > 0
    assert told["chosen"]["degree"] == 2
    assert told["tried"][0] == {**told["tried"][0], "neighbors": 0, "iterations": 0}
    expected = bilateral_projection(points, **told["chosen"])
    np.testing.assert_allclose(meshes.current_mesh().vertex_matrix(), expected, rtol=0, atol=1e-12)
    assert np.abs(np.linalg.norm(expected, axis=1) - 1.0).mean() < 0.5 * np.abs(np.linalg.norm(points, axis=1) - 1.0).mean()
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(truth))
    told = meshes.apply_filter(name, iterations="auto")
    assert told["chosen"]["iterations"] == 0
    assert meshes.current_mesh().vertex_matrix().tobytes() == truth.tobytes()

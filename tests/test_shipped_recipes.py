"""Each shipped recipe on the kind of scan that it is for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pymeshlab
import pytest
from numpy.typing import NDArray

from pymeshfair import MeshSet
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.inspection.surface_measures import surface_measures
from pymeshfair.recipe import load_recipe, shipped_recipes
from tests.meshes import grid, icosphere

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"
BUILT_IN_ALONE = ("smooth_taubin",)


def after_recipe(name: str, vertices: NDArray[np.float64], faces: NDArray[np.int32] | None = None) -> MeshSet:
    """A mesh set whose current mesh has gone through the recipe."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices) if faces is None else pymeshlab.Mesh(vertices, faces))
    path = load_recipe(name).script.path
    meshes.load_filter_script(str(path))
    meshes.apply_filter_script()
    return meshes


def bunny() -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """The bunny of the pymeshlab wheel, closed, 34,834 vertices."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(SAMPLES / "bunny.obj"))
    return meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()


@pytest.mark.parametrize("name", shipped_recipes())
def test_every_recipe_says_for_which_scans_what_it_does_and_what_to_tune(name: str) -> None:
    """The head comment has a title and the three paragraphs that the pages and `info` show."""
    info = load_recipe(name).info
    assert all((info.title, info.purpose, info.does, info.tune))


@pytest.mark.parametrize("name", BUILT_IN_ALONE)
def test_recipes_of_built_in_filters_do_the_same_in_plain_pymeshlab(name: str) -> None:
    """The reader and runner of pymeshlab give the coordinates that ours give, to the bit."""
    recipe = load_recipe(name)
    assert all(step.filter.is_builtin for step in recipe.script.steps)
    vertices, faces = bunny()
    plain = pymeshlab.MeshSet()
    plain.add_mesh(pymeshlab.Mesh(vertices, faces))
    plain.load_filter_script(str(recipe.script.path))
    plain.apply_filter_script()
    ours = after_recipe(name, vertices, faces)
    np.testing.assert_array_equal(ours.current_mesh().vertex_matrix(), plain.current_mesh().vertex_matrix())
    assert not np.array_equal(plain.current_mesh().vertex_matrix(), vertices)


def test_clean_point_cloud_removes_strays_and_gives_normals() -> None:
    """Of a sphere of 4,000 points and 40 strays around it, the strays go, nearly all points stay, and the normals are radial."""
    random = np.random.default_rng(20260)
    surface = random.normal(size=(4000, 3))
    surface /= np.linalg.norm(surface, axis=1, keepdims=True)
    strays = random.normal(size=(40, 3))
    strays *= random.uniform(1.3, 2.0, size=(40, 1)) / np.linalg.norm(strays, axis=1, keepdims=True)
    mesh = after_recipe("clean_point_cloud", np.concatenate([surface, strays])).current_mesh()
    radii = np.linalg.norm(mesh.vertex_matrix(), axis=1)
    assert (radii > 1.2).sum() == 0
    assert (radii < 1.2).sum() >= 3990
    normals = mesh.vertex_normal_matrix()
    radial = mesh.vertex_matrix() / radii[:, None]
    assert np.median(np.abs((normals * radial).sum(axis=1))) > 0.99
    assert mesh.vertex_scalar_array().max() <= 0.99


def test_clean_point_cloud_smooths_when_told() -> None:
    """By itself it moves no point; with smooth=auto the distance of a noisy sphere's points falls to less than half."""
    random = np.random.default_rng(20263)
    points = random.normal(size=(4000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points += random.normal(scale=0.02, size=points.shape)
    left = []
    for smooth in (0, "auto"):
        meshes = MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(points))
        meshes.apply_recipe("clean_point_cloud", smooth=smooth)
        left.append(meshes.current_mesh().vertex_matrix())
    assert {tuple(p) for p in left[0].tolist()} <= {tuple(p) for p in points.tolist()}
    before, after = (np.abs(np.linalg.norm(found, axis=1) - 1.0).mean() for found in left)
    assert after < 0.5 * before


def test_remove_outliers_keeps_the_surface() -> None:
    """Of a sphere of 4,000 points and 40 strays around it, nearly all strays go and nearly all points stay."""
    random = np.random.default_rng(20262)
    surface, strays = random.normal(size=(4000, 3)), random.normal(size=(40, 3))
    surface /= np.linalg.norm(surface, axis=1, keepdims=True)
    strays *= random.uniform(1.3, 2.0, size=(40, 1)) / np.linalg.norm(strays, axis=1, keepdims=True)
    mesh = after_recipe("remove_outliers", np.concatenate([surface, strays])).current_mesh()
    radii = np.linalg.norm(mesh.vertex_matrix(), axis=1)
    assert (radii > 1.2).sum() <= 4
    assert (radii < 1.2).sum() >= 3990
    assert mesh.vertex_scalar_array().max() <= 0.9


@pytest.mark.slow
def test_smooth_implicit_removes_the_noise_and_keeps_the_dimensions() -> None:
    """Of noise of 0.3 edges on a ball less than a third is left, and its sides stay to 1 %."""
    vertices, faces = icosphere(4)
    level = 0.3 * mean_edge_length(vertices, faces)
    rough = vertices * (1.0 + np.random.default_rng(11).normal(scale=level, size=(len(vertices), 1)))
    places = after_recipe("smooth_implicit", rough, faces).current_mesh().vertex_matrix()
    assert np.sqrt(np.mean((np.linalg.norm(places, axis=1) - 1.0) ** 2)) < level / 3.0
    np.testing.assert_allclose(np.ptp(places, axis=0), 2.0, rtol=0.01)


@pytest.mark.slow
def test_smooth_implicit_smooths_and_keeps_the_volume() -> None:
    """Noise of a fifth of an edge on the bunny is more than halved in roughness while the volume stays to 1e-9."""
    vertices, faces = bunny()
    before = surface_measures(vertices, faces)
    assert before.mean_edge is not None
    noisy = vertices + np.random.default_rng(20261).normal(scale=before.mean_edge / 5, size=vertices.shape)
    rough = surface_measures(noisy, faces)
    mesh = after_recipe("smooth_implicit", noisy, faces).current_mesh()
    smooth = surface_measures(mesh.vertex_matrix(), mesh.face_matrix())
    assert smooth.roughness is not None
    assert rough.roughness is not None
    assert smooth.roughness < rough.roughness / 2
    assert smooth.volume == pytest.approx(rough.volume, rel=1e-9)


def test_clean_range_map_leaves_clean_borders_and_whole_pieces() -> None:
    """Small pieces and non-manifold places of the face's range map are gone; without noise, every vertex left has its place."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(SAMPLES / "rangemaps/face000.ply"))
    vertices, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
    before = surface_measures(vertices, faces)
    mesh = after_recipe("clean_range_map", vertices, faces).current_mesh()
    after = surface_measures(mesh.vertex_matrix(), mesh.face_matrix())
    assert after.components == 3
    assert after.components < before.components
    assert (after.non_manifold_edges, after.non_manifold_vertices, after.unreferenced_vertices) == (0, 0, 0)
    assert after.border_edges < before.border_edges
    assert {tuple(p) for p in mesh.vertex_matrix().tolist()} <= {tuple(p) for p in vertices.tolist()}


@pytest.mark.slow
def test_clean_range_map_smooths_as_much_as_there_is_noise() -> None:
    """Of noise of 0.2 edges on hills less than half is left."""
    vertices, faces = grid(60, 60)
    vertices[:, 2] = 4.0 * np.sin(vertices[:, 0] / 9.0) * np.cos(vertices[:, 1] / 11.0)
    heights = np.random.default_rng(7).normal(scale=0.2, size=len(vertices))
    rough = vertices + heights[:, None] * [0.0, 0.0, 1.0]
    places = after_recipe("clean_range_map", rough, faces).current_mesh().vertex_matrix()
    left = places[:, 2] - 4.0 * np.sin(places[:, 0] / 9.0) * np.cos(places[:, 1] / 11.0)
    assert np.sqrt(np.mean(left**2)) < 0.5 * 0.2

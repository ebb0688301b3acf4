"""The recipes of many steps, each from a small mesh with everything wrong that it is there to mend to the result it promises."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from pymeshfair import MeshSet, Recipe
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.inspection.surface_measures import SurfaceMeasures, surface_measures
from tests.meshes import Floats, Ints, Mesh, cube, grid, icosphere, noisy

#: the vertex of the spike
TIP = 300


def ball_with_faults(subdivisions: int = 4) -> Mesh:
    """A ball of radius 1 with a hole, a spike to thrice the radius, a face twice, and a small ball that floats beside it."""
    vertices, faces = icosphere(subdivisions)
    vertices[TIP] *= 3.0
    middles = vertices[faces].mean(axis=1)
    faces = faces[middles[:, 2] < 0.97]
    bit, more = icosphere(1)
    return (
        np.concatenate([vertices, 0.03 * bit + [2.0, 0.0, 0.0]]),
        np.concatenate([faces, faces[:1], more + np.int32(len(vertices))]),
    )


def after(name: str, vertices: Floats, faces: Ints | None = None) -> tuple[MeshSet, SurfaceMeasures]:
    """A mesh set whose current mesh has gone through a shipped recipe, and its measures."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices) if faces is None else pymeshlab.Mesh(vertices, faces))
    Recipe.load(name).apply(meshes)
    mesh = meshes.current_mesh()
    return meshes, surface_measures(mesh.vertex_matrix(), mesh.face_matrix())


@pytest.mark.parametrize("name", ["prepare_for_print", "prepare_for_simulation"])
def test_a_ball_with_faults_comes_out_watertight_with_its_volume(name: str) -> None:
    """One closed, oriented piece without the spike; the volume is that of the ball within the polygon's share of 1 %."""
    vertices, faces = ball_with_faults()
    if name == "prepare_for_simulation":  # which does not look for spikes
        vertices[TIP] /= 3.0
    _, found = after(name, vertices, faces)
    assert (found.components, found.closed, found.oriented, found.genus) == (1, True, True, 0)
    assert (found.non_manifold_edges, found.non_manifold_vertices, found.degenerate_faces) == (0, 0, 0)
    assert found.volume == pytest.approx(4.0 / 3.0 * np.pi, rel=0.01)


@pytest.mark.parametrize("name", ["prepare_for_print", "prepare_for_simulation"])
def test_faces_that_are_turned_over_do_not_keep_a_hole_from_being_closed_smoothly(name: str) -> None:
    """A ball with a hole, and every tenth face turned over, gets its cap back; a flat lid would cost 2.8 % of the volume."""
    vertices, faces = icosphere(4)
    faces = faces[vertices[faces].mean(axis=1)[:, 2] < 0.8].copy()
    faces[::10] = faces[::10, ::-1]
    _, found = after(name, vertices, faces)
    assert (found.closed, found.oriented) == (True, True)
    assert found.volume == pytest.approx(4.0 / 3.0 * np.pi, rel=0.01)


def test_an_object_inside_out_is_turned_and_an_open_one_closed_for_printing() -> None:
    """Half a ball whose faces look inwards gets a base and a positive volume of 2 pi / 3."""
    vertices, faces = icosphere(4)
    half = faces[vertices[faces].mean(axis=1)[:, 2] > 0.0][:, ::-1]
    _, found = after("prepare_for_print", vertices, np.ascontiguousarray(half))
    assert found.closed
    assert found.volume == pytest.approx(2.0 / 3.0 * np.pi, rel=0.03)  # the rim is a zigzag of half an edge


def test_triangles_for_simulation_are_good_and_edges_of_a_box_stay() -> None:
    """A box of slivers gets even triangles; its corners and its volume of 4 stay within a hundredth."""
    vertices, faces = cube()
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices * [4.0, 1.0, 1.0], faces))
    recipe = Recipe.load("prepare_for_simulation")
    recipe.set(edge="0.2")
    recipe.apply(meshes)
    mesh = meshes.current_mesh()
    found = surface_measures(mesh.vertex_matrix(), mesh.face_matrix())
    assert found.triangle_quality is not None
    assert found.triangle_quality > 0.85
    assert found.volume == pytest.approx(4.0, rel=0.01)
    np.testing.assert_allclose(np.ptp(mesh.vertex_matrix(), axis=0), [4.0, 1.0, 1.0], rtol=0.01)


def test_a_cloud_of_half_a_ball_becomes_half_a_ball() -> None:
    """Points on half a ball and ten strays: the mesh is near the ball everywhere, its balloon gone, in one open piece."""
    random = np.random.default_rng(3)
    points = random.normal(size=(12000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points = points[points[:, 2] > 0.0]
    strays = random.uniform([-4.0, -4.0, 2.0], [4.0, 4.0, 10.0], size=(10, 3))
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.concatenate([points, strays])))
    recipe = Recipe.load("cloud_to_mesh")
    recipe.set(depth="6")
    recipe.apply(meshes)
    mesh = meshes.current_mesh()
    found = surface_measures(mesh.vertex_matrix(), mesh.face_matrix())
    assert (found.components, found.closed) == (1, False)
    spacing = 1.2 * np.sqrt(2.0 * np.pi / len(points))
    away = np.abs(np.linalg.norm(mesh.vertex_matrix(), axis=1) - 1.0)
    assert away.max() < 6.0 * spacing  # beyond that the balloon is cut
    assert np.median(away) < 0.1 * spacing
    assert found.area == pytest.approx(2.0 * np.pi, rel=0.15)  # and the rim that the cut leaves, of some spacings
    assert mesh.vertex_matrix()[:, 2].min() > -0.3


def test_a_rough_cloud_makes_no_surface_where_nothing_was_measured() -> None:
    """Points on half a ball with noise of half a spacing: under 1 % of the area lies over 3 spacings from the half ball."""
    random = np.random.default_rng(3)
    points = random.normal(size=(6000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points = points[points[:, 2] > 0.0]
    spacing = 1.2 * np.sqrt(2.0 * np.pi / len(points))
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points + random.normal(scale=0.5 * spacing, size=points.shape)))
    recipe = Recipe.load("cloud_to_mesh")
    recipe.set(depth="6")
    recipe.apply(meshes)
    corners = meshes.current_mesh().vertex_matrix()[meshes.current_mesh().face_matrix()]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    middles = corners.mean(axis=1)
    beside = np.hypot(np.hypot(middles[:, 0], middles[:, 1]) - 1.0, middles[:, 2])  # from the rim
    away = np.where(middles[:, 2] > 0.0, np.abs(np.linalg.norm(middles, axis=1) - 1.0), beside)
    assert areas[away > 3.0 * spacing].sum() < 0.01 * areas.sum()


def test_what_is_ready_to_be_registered_has_not_moved() -> None:
    """A rough sheet with a floating piece loses the piece and two rings at its border; every vertex left has its place."""
    vertices, faces = noisy(grid(20, 20), 0.05)
    piece = 0.2 * grid(3, 3)[0] + [30.0, 0.0, 0.0]
    both = np.concatenate([vertices, piece])
    meshes, found = after("register_ready", both, np.concatenate([faces, grid(3, 3)[1] + np.int32(len(vertices))]))
    left = meshes.current_mesh().vertex_matrix()
    assert {tuple(p) for p in left.tolist()} <= {tuple(p) for p in vertices.tolist()}
    assert (found.components, found.border_edges) == (1, 4 * 16)
    limit = Recipe.load("register_ready").script.guards.max_displacement
    assert str(limit) == "0.2edge"


@pytest.mark.slow
def test_a_textured_scan_is_cleaned_and_keeps_its_texture() -> None:
    """A ball with faults, noise and texture coordinates: the spike, the piece and the hole are gone, the coordinates are not."""
    vertices, faces = ball_with_faults(3)
    faces = np.unique(faces, axis=0)
    level = 0.15 * mean_edge_length(*icosphere(3))
    vertices = vertices + np.random.default_rng(2).normal(scale=level, size=vertices.shape)
    corners = np.column_stack([np.arctan2(vertices[:, 1], vertices[:, 0]), vertices[:, 2]])[faces.ravel()]
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces, w_tex_coords_matrix=corners))
    Recipe.load("clean_photogrammetry").apply(meshes)
    mesh = meshes.current_mesh()
    found = surface_measures(mesh.vertex_matrix(), mesh.face_matrix())
    assert (found.components, found.closed) == (1, True)
    assert mesh.has_wedge_tex_coord()
    radii = np.linalg.norm(mesh.vertex_matrix(), axis=1)
    assert radii.max() < 1.1
    assert np.median(np.abs(radii - 1.0)) < 0.6745 * level / 2  # of the noise it is 0.6745 of the level

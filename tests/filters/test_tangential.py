"""Tangential smoothing: better triangles, the same surface, nothing folded."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.fairing.tangential import tangential_smoothing
from pymeshfair.filters.geometry import WalkableSurface, face_normals, mean_edge_length
from pymeshfair.filters.inspection import sharp_edges
from pymeshfair.filters.inspection.surface_measures import surface_measures
from pymeshfair.filters.topology import border_vertices
from tests.meshes import AWKWARD, Floats, Ints, Mesh, grid, icosphere, irregular_grid, rotation


def uneven_sphere(subdivisions: int) -> Mesh:
    """A sphere whose vertices have slid along it by a tenth of an edge or two."""
    vertices, faces = icosphere(subdivisions)
    edge = mean_edge_length(vertices, faces)
    slid = vertices + 0.2 * edge * np.random.default_rng(0).normal(size=vertices.shape)
    return slid / np.linalg.norm(slid, axis=1, keepdims=True), faces


def quality(vertices: Floats, faces: Ints) -> float:
    """The mean triangle quality, 1 if all are equilateral."""
    found = surface_measures(vertices, faces).triangle_quality
    assert found is not None
    return found


def hausdorff(from_mesh: Mesh, to_mesh: Mesh) -> float:
    """MeshLab's largest distance from samples of vertices, edges and faces of one mesh to another."""
    meshes = pymeshlab.MeshSet()
    for vertices, faces in (from_mesh, to_mesh):
        meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    found = meshes.get_hausdorff_distance(
        sampledmesh=0,
        targetmesh=1,
        samplevert=True,
        sampleedge=True,
        sampleface=True,
        samplenum=3 * len(from_mesh[0]),
        maxdist=pymeshlab.PercentageValue(50),
    )
    return float(found["max"])


@pytest.mark.slow
def test_better_triangles_on_the_same_smooth_surface() -> None:
    """On a fine uneven sphere the quality rises by 10 % and more, and nothing is 1 % of an edge away from the input."""
    vertices, faces = uneven_sphere(6)
    result = tangential_smoothing(vertices, faces, iterations=2)[0]
    assert quality(result, faces) > 1.1 * quality(vertices, faces)
    assert hausdorff((result, faces), (vertices, faces)) < 0.01 * mean_edge_length(vertices, faces)


def test_a_flat_mesh_stays_flat_and_gets_near_the_regular_one() -> None:
    """In a plane there is no surface to lose: the irregular grid comes close to the quality of the regular one, 0.816."""
    vertices, faces = irregular_grid(20, 20)
    result = tangential_smoothing(vertices, faces, iterations=10)[0]
    assert np.abs(result[:, 2]).max() == 0.0
    assert quality(*grid(20, 20)) == pytest.approx(np.sqrt(2 / 3))
    assert quality(result, faces) > 0.95 * np.sqrt(2 / 3)


def test_a_regular_mesh_has_nothing_to_gain() -> None:
    """Where every vertex is the mean of its neighbours already, none moves."""
    vertices, faces = grid(10, 10)
    assert np.abs(tangential_smoothing(vertices, faces)[0] - vertices).max() < 1e-12


@pytest.mark.parametrize("share", [0.0, 0.02, 0.2])
def test_the_surface_is_left_by_no_more_than_allowed(share: float) -> None:
    """On a coarse sphere the middles of triangles and edges stay as close to the input as was said."""
    vertices, faces = uneven_sphere(3)
    allowed = share * mean_edge_length(vertices, faces)
    result = tangential_smoothing(vertices, faces, max_deviation=allowed)[0]
    surface = WalkableSurface.of(vertices, faces)
    centres = result[faces].mean(axis=1)
    _, _, far = surface.closest(centres, np.arange(len(faces), dtype=np.int32))
    assert far.max() <= allowed + 1e-14


def test_a_sharp_edge_stays_straight() -> None:
    """At the fold of a sheet by a right angle the middles of triangles stay within a fifth of what others may leave it."""
    vertices, faces = irregular_grid(17, 17, amount=0.4)
    flat = vertices.copy()
    flat[np.abs(flat[:, 0] - 8.0) < 0.5, 0] = 8.0
    over = np.maximum(flat[:, 0] - 8.0, 0.0)
    folded = np.column_stack([flat[:, 0] - over, flat[:, 1], over])
    surface, allowed = WalkableSurface.of(folded, faces), 0.05 * mean_edge_length(folded, faces)
    for result, cells in (
        (tangential_smoothing(folded, faces, iterations=10)[0], faces),
        tangential_smoothing(folded, faces, flip_edges=True),
    ):
        _, _, far = surface.closest(result[cells].mean(axis=1), np.arange(len(faces), dtype=np.int32))
        assert 0.0 < far.max() <= 0.2 * allowed + 1e-14


def test_edges_of_noise_hold_no_triangle() -> None:
    """Four in five vertices of a noisy sheet are at sharp edges; its triangles leave it as far as those of a smooth one."""
    flat, faces = irregular_grid(25, 25, amount=0.4)
    edge = mean_edge_length(flat, faces)
    noisy = flat + np.random.default_rng(3).normal(size=flat.shape) * [0.0, 0.0, 0.3 * edge]
    assert len(np.unique(sharp_edges(noisy, faces).pairs)) > 0.8 * len(noisy)
    result = tangential_smoothing(noisy, faces, iterations=10, max_deviation=0.05 * edge)[0]
    _, _, far = WalkableSurface.of(noisy, faces).closest(result[faces].mean(axis=1), np.arange(len(faces), dtype=np.int32))
    assert np.mean(far > 0.2 * 0.05 * edge) > 0.5


def test_no_triangle_folds() -> None:
    """Every triangle looks the same way, up to 75 degrees a step, whatever the iterations."""
    vertices, faces = irregular_grid(15, 15, amount=0.49)
    result = tangential_smoothing(vertices, faces, weight=1e-4, iterations=10)[0]
    before, after = face_normals(vertices, faces), face_normals(result, faces)
    assert (np.einsum("ij,ij->i", before, after) > 0.0)[before[:, 2] > 0.0].all()


def test_held_and_border_vertices_keep_every_bit() -> None:
    """Vertices that may not move, and those of the border, are the same to the bit; others move."""
    vertices, faces = irregular_grid(12, 12)
    movable = vertices[:, 0] > 5.0
    result = tangential_smoothing(vertices, faces, movable=movable)[0]
    held = ~movable | border_vertices(faces, len(vertices))
    assert np.array_equal(result[held], vertices[held])
    assert (result[~held] != vertices[~held]).any(axis=1).mean() > 0.9


def test_the_result_turns_and_grows_with_the_mesh() -> None:
    """Rotation and scale commute with it, but where rounding decides whether a step is halved: nowhere here."""
    # A step is solved for to 1e-6.
    vertices, faces = uneven_sphere(3)
    plain = tangential_smoothing(vertices, faces, max_deviation=1.0)[0]
    turn = rotation(3)
    assert np.abs(tangential_smoothing(vertices @ turn.T, faces, max_deviation=1.0)[0] - plain @ turn.T).max() < 1e-6
    assert np.abs(tangential_smoothing(1e12 * vertices, faces, max_deviation=1e12)[0] - 1e12 * plain).max() < 1e-6 * 1e12


def test_closest_points_against_every_triangle() -> None:
    """A walk from a near face ends at the closest point of all triangles, found by sampling each finely."""
    vertices, faces = icosphere(2)
    rng = np.random.default_rng(0)
    start = rng.integers(len(faces), size=50).astype(np.int32)
    queries = vertices[faces[start]].mean(axis=1) * rng.uniform(0.9, 1.2, (50, 1)) + 0.05 * rng.normal(size=(50, 3))
    found, at, distance = WalkableSurface.of(vertices, faces).closest(queries, start)
    u, v = np.meshgrid(np.linspace(0, 1, 41), np.linspace(0, 1, 41))
    u, v = u[u + v <= 1 + 1e-9], v[u + v <= 1 + 1e-9]
    weights = np.column_stack([1 - u - v, u, v])
    samples = np.einsum("sk,fkc->fsc", weights, vertices[faces]).reshape(-1, 3)
    nearest = np.array([np.linalg.norm(samples - q, axis=1).min() for q in queries])
    # The grid of samples is 1 / 40 of an edge of 0.3 apart.
    assert (distance <= nearest + 1e-12).all()
    assert (distance >= nearest - 0.01).all()
    assert np.abs(np.linalg.norm(queries - found, axis=1) - distance).max() < 1e-12
    normals = face_normals(vertices, faces)[at]
    assert np.abs(np.einsum("ij,ij->i", found - vertices[faces[at, 0]], normals)).max() < 1e-12


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_end_finite(name: str) -> None:
    """Whatever the mesh, coordinates stay finite."""
    vertices, faces = AWKWARD[name]()
    assert np.isfinite(tangential_smoothing(vertices, faces, iterations=2)[0]).all()


def test_where_nothing_may_move_progress_ends_at_one() -> None:
    """A caller is told that the work is done."""
    vertices, faces = grid(4, 4)
    told: list[float] = []
    tangential_smoothing(vertices, faces, movable=np.zeros(len(vertices), dtype=np.bool_), progress=told.append)
    assert told == [1.0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"weight": 0.0}, "weight is 0.0: it must be"),
        ({"iterations": -1}, "iterations is -1"),
        ({"max_deviation": -1.0}, "max_deviation is -1.0: it must be"),
    ],
)
def test_wrong_arguments_are_named(arguments: dict[str, float], message: str) -> None:
    """The message says which argument is wrong and what came."""
    with pytest.raises(FilterInputError, match=message):
        tangential_smoothing(*grid(4, 4), **arguments)[0]  # type: ignore[arg-type]

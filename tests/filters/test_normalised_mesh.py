"""The entrance of every filter of vertices."""

import numpy as np
import pymeshlab
import pytest

from pymeshfair import MeshSet
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.diffusion import taubin_fairing
from pymeshfair.filters.inspection.surface_measures import surface_measures
from pymeshfair.filters.mesh import check_mesh, normalised_mesh
from tests.meshes import grid, icosphere, renumbered

STRAYS = [np.array([1e9, 0.0, 0.0]), np.array([0.0, -1e16, 0.0]), np.array([1e300, 1e300, 0.0]), np.zeros(3)]


@pytest.mark.parametrize("stray", STRAYS, ids=str)
@pytest.mark.parametrize("place", [0, 17, 42])
def test_a_vertex_that_no_face_uses_has_no_point(stray: np.ndarray, place: int) -> None:
    """Wherever it lies and whatever its number, the points, faces and scale are those of the mesh without it, bit for bit."""
    vertices, faces = icosphere(1)
    alone = normalised_mesh(vertices, faces)
    more = np.insert(vertices, place, stray, axis=0)
    mesh = normalised_mesh(more, np.where(faces >= place, faces + 1, faces).astype(np.int32))
    assert np.array_equal(mesh.points, alone.points)
    assert np.array_equal(mesh.cells, alone.cells)
    assert mesh.scale == alone.scale
    moved = mesh.restored(mesh.points + 0.25)
    assert np.array_equal(np.delete(moved, place, axis=0), alone.restored(alone.points + 0.25))
    assert np.array_equal(moved[place], stray)


def test_a_face_that_names_a_vertex_twice_uses_none() -> None:
    """A vertex that only a collapsed triangle names has no point, and the triangle is left out."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1e9, 0, 0]], dtype=np.float64)
    mesh = normalised_mesh(vertices, np.array([[0, 1, 2], [0, 0, 3]], dtype=np.int32))
    assert mesh.used.tolist() == [0, 1, 2]
    assert mesh.cells.tolist() == [[0, 1, 2]]


def test_the_points_are_the_definition() -> None:
    """Point k is (vertices[order[k]] - middle) * scale, about the origin and between 1/4 and 1 long."""
    vertices = np.random.default_rng(3).normal(size=(50, 3)) * 1e5 + 4e6
    edges = np.array([[i, i + 2] for i in range(0, 48, 2)], dtype=np.int32)
    mesh = normalised_mesh(vertices, edges)
    places = np.random.default_rng(4).permutation(len(mesh)).astype(np.int32)
    renumbered = mesh.in_order(places)
    assert np.array_equal(renumbered.points, (vertices[renumbered.used] - renumbered.middle) * renumbered.scale)
    assert np.array_equal(renumbered.used[renumbered.cells], edges)
    extent = np.ptp(renumbered.points, axis=0).max()
    assert 0.25 <= extent <= 1.0
    assert np.abs(renumbered.points).max() <= 0.5


def test_what_does_not_move_keeps_every_bit() -> None:
    """Coordinates of points that stay are those of the input, negative zeros included; the others move by the displacement."""
    vertices, faces = icosphere(1)
    vertices[0] = [-0.0, 0.1, 1.0]
    mesh = normalised_mesh(vertices, faces)
    after = mesh.points.copy()
    after[5] += mesh.scale
    moved = mesh.restored(after)
    kept = np.arange(len(vertices)) != 5
    assert moved[kept].tobytes() == vertices[kept].tobytes()
    # The sum and the difference of a point round by half a unit in the last place of 1 each.
    assert np.abs(moved[5] - vertices[5] - 1.0).max() <= 2.3e-16 / mesh.scale


def test_movable_belongs_to_every_vertex() -> None:
    """A mask of the wrong length is refused; one of the right length is carried to the points."""
    vertices, faces = icosphere(0)
    with pytest.raises(FilterInputError, match="boolean array of 12 values"):
        normalised_mesh(vertices, faces, np.ones(11, dtype=np.bool_))
    mask = np.arange(13) % 2 == 0
    mesh = normalised_mesh(np.concatenate([[[9.0, 9.0, 9.0]], vertices]), faces + np.int32(1), mask)
    assert mesh.movable is not None
    assert mesh.movable.tolist() == mask[1:].tolist()


@pytest.mark.parametrize("distance", [1e9, 1e16, 1e200])
def test_a_stray_vertex_changes_no_measure_but_its_own(distance: float) -> None:
    """Area, volume, edges and angles are those of the mesh alone; the diagonal is that of all vertices."""
    vertices, faces = icosphere(2)
    alone = surface_measures(vertices, faces)
    more = surface_measures(np.concatenate([vertices, [[distance, 0.0, 0.0]]]), faces)
    own = ("vertices", "unreferenced_vertices", "diagonal")
    assert {k: v for k, v in vars(more).items() if k not in own} == {k: v for k, v in vars(alone).items() if k not in own}
    assert more.unreferenced_vertices == 1
    assert more.diagonal == pytest.approx(np.hypot(distance + 1.0, np.sqrt(8.0)), rel=1e-12)


@pytest.mark.parametrize("distance", [1e9, 1e16, float(np.finfo(np.float32).max), 1e300])
def test_a_far_piece_is_refused_before_the_rest_loses_its_digits(distance: float) -> None:
    """The far vertex of a mesh or of a cloud is named; at 1e7 it is smoothed, as is a thin needle, with half of the digits."""
    vertices, faces = icosphere(2)
    far = np.concatenate([vertices, [[distance, 0.0, 0.0]]])
    spiked = np.concatenate([faces, [[0, 1, len(vertices)]]]).astype(np.int32)
    more = np.concatenate([faces, faces + len(vertices)]).astype(np.int32)
    for cells in (spiked, np.empty((0, 3), np.int32), spiked[:, :2]):
        if cells.shape[1] == 2:
            cells = np.concatenate([cells, [[0, len(vertices)]]]).astype(np.int32)
        with pytest.raises(
            FilterInputError, match=r"^vertex 162 at \[.*, 0\.0, 0\.0\] is so far from the others .*: remove it first"
        ):
            normalised_mesh(far, cells).check_far()
    with pytest.raises(FilterInputError, match="is so far from the others"):
        normalised_mesh(np.concatenate([vertices, 2.0 * vertices + distance]), more).check_far()
    near = np.concatenate([vertices, 2.0 * vertices + 1e7])
    for allowed, cells in ((near, more), (vertices * [1.0, 1e-12, 1e-12], faces), (vertices + 1e12, faces), (far, faces)):
        normalised_mesh(allowed, cells).check_far()
    smoothed = taubin_fairing(near, more)[: len(vertices)]
    np.testing.assert_allclose(smoothed, taubin_fairing(vertices, faces), rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    "name", ["apply_coord_taubin_fairing", "apply_coord_implicit_fairing", "apply_coord_bilateral_projection_of_points"]
)
def test_filters_that_move_vertices_name_the_far_one(name: str) -> None:
    """So it is with automatic values, too, where a point at the largest float marks what a scanner did not see."""
    vertices, faces = icosphere(2)
    far = np.concatenate([vertices, [[float(np.finfo(np.float32).max), 0.0, 0.0]]])
    meshes = MeshSet()
    cells = np.empty((0, 3)) if name.endswith("points") else np.concatenate([faces, [[0, 1, 162]]])
    meshes.add_mesh(pymeshlab.Mesh(far, cells.astype(np.int32)))
    with pytest.raises(pymeshlab.PyMeshLabException, match=r"vertex 162 at .* is so far from the others"):
        meshes.apply_filter(name)


def test_points_by_place_lie_near_their_neighbours() -> None:
    """Of a grid in random order: a permutation, in which the ends of an edge are a few rows apart, where they were anywhere."""
    side = 100
    vertices, faces, _ = renumbered(grid(side, side))
    mesh = normalised_mesh(*check_mesh(vertices, faces)).by_place()
    assert mesh.order is not None
    assert sorted(mesh.order.tolist()) == list(range(len(vertices)))
    assert np.abs(np.diff(mesh.cells.astype(np.int64), axis=1)).max() < 8 * side
    assert sorted(map(sorted, mesh.order[mesh.cells].tolist())) == sorted(map(sorted, faces.tolist()))


def test_a_few_far_points_do_not_spoil_the_order_by_place() -> None:
    """One vertex a million times as far away changes nothing for the others."""
    vertices, faces, _ = renumbered(grid(100, 100))
    far = np.concatenate([vertices, [[1e6, 0.0, 0.0]]])
    more = np.concatenate([faces, [[*faces[0, :2], len(vertices)]]])
    mesh = normalised_mesh(*check_mesh(far, more)).by_place()
    assert np.quantile(np.abs(np.diff(mesh.cells.astype(np.int64), axis=1)), 0.999) < 800

"""Edge flips: better triangles on the same vertices, near the same surface, in the same topology."""

from __future__ import annotations

import igl
import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.compilation import allowed_threads, set_threads
from pymeshfair.filters.fairing.tangential import flip_towards_quality, tangential_smoothing
from pymeshfair.filters.geometry import WalkableSurface, mean_edge_length
from pymeshfair.filters.inspection.surface_measures import surface_measures
from pymeshfair.filters.topology import border_edges, edges, proper_faces
from tests.filters.test_tangential import hausdorff, quality, uneven_sphere
from tests.meshes import AWKWARD, Bools, Floats, Ints, Mesh, cube, grid, irregular_grid, rotation, sample

#: what no flip changes
TOPOLOGY = (
    "vertices",
    "faces",
    "edges",
    "unreferenced_vertices",
    "border_edges",
    "non_manifold_edges",
    "non_manifold_vertices",
    "components",
    "closed",
    "oriented",
    "euler_characteristic",
    "genus",
)


def folded_strip(angle: float) -> Mesh:
    """Two triangles at a long edge from which they bend by an angle, in degrees; the other diagonal is the better one if 0."""
    turn = np.radians(angle)
    points = np.array([[-1.0, 0, 0], [1, 0, 0], [0, 0.5, 0], [0, -0.5 * np.cos(turn), 0.5 * np.sin(turn)]])
    return points, np.array([[0, 1, 2], [1, 0, 3]], dtype=np.int32)


def wrong_diagonals() -> Mesh:
    """A bumpy sheared grid, all of whose cells are cut along their longer diagonals."""
    vertices, faces = irregular_grid(30, 30, amount=0.2)
    vertices = vertices + [0.0, 0.0, 1.0] * np.sin(vertices @ [0.3, 0.2, 0.0])[:, None]
    shear = np.array([[1.0, 0.0, 0.0], [0.6, 1.0, 0.0], [0.0, 0.0, 1.0]])
    longer, shorter = vertices @ shear, vertices @ (shear * [[1, 1, 1], [-1, 1, 1], [1, 1, 1]])
    worse = longer if quality(longer, faces) < quality(shorter, faces) else shorter
    return worse, faces


def flip_edges(vertices: Floats, faces: Ints, *, allowed: float | None = None, may: Bools | None = None) -> Ints:
    """The triangles after all flips that leave them near themselves, by default within 5 % of the mean edge."""
    surface = WalkableSurface.of(vertices, faces)
    near = np.full(len(vertices), 0.05 * mean_edge_length(vertices, faces) if allowed is None else allowed)
    free = np.ones(len(vertices), dtype=np.bool_) if may is None else may
    return flip_towards_quality(vertices, faces, free, surface, surface.first_faces(), near)[0]


def qualities(vertices: Floats, faces: Ints) -> Floats:
    """(m,) the quality of each triangle, from its edges and Heron's area."""
    p = vertices[faces]
    lengths = np.linalg.norm(p - np.roll(p, -1, axis=1), axis=2)
    half = lengths.sum(axis=1) / 2
    area = np.sqrt(np.maximum(half * (half - lengths[:, 0]) * (half - lengths[:, 1]) * (half - lengths[:, 2]), 0.0))
    return np.asarray(lengths.min(axis=1) * 4 * area / (np.sqrt(3) * lengths.prod(axis=1)))


def without_loose_vertices(mesh: Mesh) -> Mesh:
    """The mesh without vertices that no triangle uses, which are no part of the surface."""
    used, faces = np.unique(mesh[1], return_inverse=True)
    return mesh[0][used], faces.reshape(mesh[1].shape).astype(np.int32)


def directed(faces: Ints) -> set[tuple[int, int]]:
    """The directed edges of the triangles."""
    return {(int(a), int(b)) for face in faces for a, b in zip(face, np.roll(face, -1), strict=True)}


def test_the_shorter_diagonal_of_a_flat_rhombus_is_taken() -> None:
    """Of a rhombus cut along its long diagonal the short one is the better, and stays; corners run on the same way round."""
    vertices, faces = folded_strip(0.0)
    flipped = flip_edges(vertices, faces)
    assert {frozenset(face) for face in flipped.tolist()} == {frozenset((0, 3, 2)), frozenset((3, 1, 2))}
    rim = {(0, 3), (3, 1), (1, 2), (2, 0)}
    assert rim <= directed(flipped)
    assert np.array_equal(flip_edges(vertices, flipped), flipped)


def test_a_sharp_edge_is_kept_by_the_deviation() -> None:
    """The middles of the two diagonals of a bent rhombus are 0.25 sin(angle / 2) or so apart: allowed or not, as said."""
    vertices, faces = folded_strip(40.0)
    apart = float(np.linalg.norm(vertices[2] + vertices[3]) / 2)
    assert np.array_equal(flip_edges(vertices, faces, allowed=0.9 * apart), faces)
    assert not np.array_equal(flip_edges(vertices, faces, allowed=1.1 * apart), faces)


def test_flips_keep_the_edges_of_a_box() -> None:
    """The middles of edges and triangles stay within a fifth of the allowed distance of a box whose edges are sharp."""
    vertices, faces = cube(3)
    sides = np.array([1.0, 2.0, 3.0])
    vertices = vertices * sides
    allowed = 0.5 * mean_edge_length(vertices, faces)
    result, cells = tangential_smoothing(vertices, faces, flip_edges=True, max_deviation=allowed, iterations=5)
    assert (np.sort(cells, axis=1) != np.sort(faces, axis=1)).any()
    for middles in (result[edges(cells)].mean(axis=1), result[cells].mean(axis=1)):
        assert np.minimum(middles, sides - middles).min(axis=1).max() <= 0.2 * allowed + 1e-12


def test_an_edge_that_is_there_is_not_made_again() -> None:
    """In a flat tetrahedron whose apex lies in the base all pairs of vertices are joined, so nothing can be flipped."""
    vertices = np.array([[0.0, 0, 0], [4, 0, 0], [2, 0.5, 0], [2, 0.2, 0]])
    faces = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3]], dtype=np.int32)
    assert np.array_equal(flip_edges(vertices, faces, allowed=10.0), faces)


def test_a_regular_grid_stays() -> None:
    """The two diagonals of a square are alike, and a tie is not a gain."""
    vertices, faces = grid(10, 10)
    assert np.array_equal(flip_edges(vertices, faces), faces)


def test_neither_mean_nor_lowest_quality_falls() -> None:
    """Of a sheared grid, cut along the longer diagonals, the mean quality rises much, and the lowest does not fall."""
    vertices, faces = wrong_diagonals()
    before, after = qualities(vertices, faces), qualities(vertices, flip_edges(vertices, faces, allowed=1.0))
    assert after.mean() > 1.2 * before.mean()
    assert after.min() >= before.min() * (1 - 1e-12)


@pytest.mark.parametrize(
    "mesh", [wrong_diagonals(), uneven_sphere(3), sample("rangemaps/face000.ply")], ids=["grid", "sphere", "face"]
)
def test_topology_and_border_stay(mesh: Mesh) -> None:
    """Counts, manifoldness and orientation are as before, and so is every border edge."""
    vertices, faces = mesh
    flipped = flip_edges(vertices, faces)
    assert not np.array_equal(flipped, faces)
    before, after = surface_measures(vertices, faces), surface_measures(vertices, flipped)
    assert {name: getattr(after, name) for name in TOPOLOGY} == {name: getattr(before, name) for name in TOPOLOGY}
    assert np.array_equal(border_edges(flipped), border_edges(faces))


@pytest.mark.parametrize("share", [0.0, 0.02, 0.1])
def test_the_surface_is_left_by_no_more_than_allowed(share: float) -> None:
    """The middles and quarters of edges, and the middles of triangles, are as near the input as was said, by libigl's measure."""
    vertices, faces = wrong_diagonals()
    allowed = share * mean_edge_length(vertices, faces)
    p = vertices[flip_edges(vertices, faces, allowed=allowed)]
    samples = [p.mean(axis=1)] + [(1 - t) * p + t * np.roll(p, -1, axis=1) for t in (0.25, 0.5, 0.75)]
    points = np.concatenate([part.reshape(-1, 3) for part in samples])
    squares = igl.point_mesh_squared_distance(points, vertices, faces.astype(np.int64))[0]
    assert np.sqrt(squares.max()) <= allowed + 1e-12


def test_only_between_vertices_that_may_change() -> None:
    """Triangles with a held vertex stay in their rows, others change."""
    vertices, faces = wrong_diagonals()
    movable = vertices[:, 0] > np.median(vertices[:, 0])
    flipped = flip_edges(vertices, faces, allowed=1.0, may=movable)
    changed = (flipped != faces).any(axis=1)
    assert changed.any()
    assert movable[faces[changed]].all()
    assert movable[flipped[changed]].all()


def test_size_and_place_make_no_difference() -> None:
    """The same edges are flipped on a mesh that is turned, moved and a trillion times as large or as small."""
    vertices, faces = wrong_diagonals()
    plain = flip_edges(vertices, faces)
    for size in (1e12, 1e-12):
        assert np.array_equal(flip_edges(size * (vertices @ rotation(3).T + 5.0), faces), plain)


def test_the_same_bits_for_any_number_of_threads() -> None:
    """Flips are made in the order of the faces, whatever the threads; twice the same."""
    vertices, faces = wrong_diagonals()
    allowed, found = allowed_threads(), []
    for threads in (1, allowed):
        set_threads(threads)
        try:
            found.append(tangential_smoothing(vertices, faces, flip_edges=True))
        finally:
            set_threads(allowed)
    assert found[0][0].tobytes() == found[1][0].tobytes()
    assert np.array_equal(found[0][1], found[1][1])


def test_a_range_map_gains_more_than_a_tenth() -> None:
    """On a part of a range map two iterations raise the mean quality by 12 % and more, within a tenth of an edge of the input."""
    vertices, faces = sample("rangemaps/face000.ply")
    mesh = without_loose_vertices((vertices, faces[: len(faces) // 8]))
    result = tangential_smoothing(*mesh, iterations=2, flip_edges=True)
    assert quality(*result) > 1.12 * quality(*mesh)
    assert hausdorff(result, mesh) < 0.1 * mean_edge_length(*mesh)
    before, after = surface_measures(*mesh), surface_measures(*result)
    assert {name: getattr(after, name) for name in TOPOLOGY} == {name: getattr(before, name) for name in TOPOLOGY}
    assert np.array_equal(border_edges(result[1]), border_edges(mesh[1]))


def test_better_than_smoothing_alone() -> None:
    """Flips and smoothing together give better triangles than either."""
    vertices, faces = wrong_diagonals()
    both = quality(*tangential_smoothing(vertices, faces, flip_edges=True))
    assert both > 1.1 * quality(tangential_smoothing(vertices, faces)[0], faces)
    assert both > 1.01 * quality(vertices, flip_edges(vertices, faces))


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_end_valid(name: str) -> None:
    """Whatever the mesh, no triangle names a vertex twice that did not, nor an edge more faces than before."""
    vertices, faces = AWKWARD[name]()
    moved, flipped = tangential_smoothing(vertices, faces, iterations=2, flip_edges=True)
    assert np.isfinite(moved).all()
    proper = faces[proper_faces(faces)]
    before, after = surface_measures(vertices, proper), surface_measures(vertices, flip_edges(vertices, proper))
    assert after.degenerate_faces <= before.degenerate_faces
    assert {n: getattr(after, n) for n in TOPOLOGY} == {n: getattr(before, n) for n in TOPOLOGY}
    assert flipped.shape == faces.shape


def test_a_wrong_deviation_is_named() -> None:
    """The message says what came."""
    with pytest.raises(FilterInputError, match=r"max_deviation is -1.0: it must be"):
        tangential_smoothing(*grid(3, 3), max_deviation=-1.0, flip_edges=True)

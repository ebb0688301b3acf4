"""Refinement of a triangulated hole: size, shape and the edges that must be kept."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pymeshfair.filters.execution import ignore_progress
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.holes import refinement
from pymeshfair.filters.holes.closing import Patches
from pymeshfair.filters.holes.refinement import MOST_VERTICES, SLOPE, ForbiddenEdges, Patch, growing, uniform_width
from pymeshfair.filters.holes.triangulation import VertexPairs, triangulate_rim, vertex_pairs
from pymeshfair.filters.topology import border_edges, boundary_loops, edges, face_adjacency, non_manifold_edges
from tests.meshes import area, icosphere, rotation

Floats = NDArray[np.float64]


def disc(corners: int, wave: float = 0.0) -> Patch:
    """A rim of sides about 1 long about the z axis, triangulated; with a wave that is not flat."""
    angle = 2 * np.pi * np.arange(corners) / corners
    radius = corners / (2 * np.pi) * (1.0 + 0.1 * np.cos(2 * angle) + 0.02 * np.sin(5 * angle))
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), wave * np.sin(2 * angle + 0.2)])
    lengths = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    triangles = triangulate_rim(points, points * 1.1, vertex_pairs(corners))
    assert triangles is not None
    return Patch(points, (lengths + np.roll(lengths, -1)) / 2, triangles, corners)


def refined_patch(patch: Patch, pairs: VertexPairs | None = None, uniform: float = np.inf) -> Patch:
    """The patch refined, with some pairs of vertices of its rim joined outside of it already."""
    none = np.zeros(patch.n_rim, dtype=np.bool_)
    forbidden = ForbiddenEdges(pairs or vertex_pairs(patch.n_rim), none, none)
    return refinement.refined_patch(patch, forbidden=forbidden, uniform=uniform)


def opposite_angles(patch: Patch) -> Floats:
    """The sum of the two angles opposite every edge inside the patch."""
    pairs, shared = face_adjacency(patch.triangles)
    total = np.zeros(len(pairs))
    for side in range(2):
        corners = patch.triangles[pairs[:, side]]
        apex = corners.sum(axis=1) - shared.sum(axis=1)
        u, v = (patch.points[shared[:, k]] - patch.points[apex] for k in range(2))
        total += np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1))
    return total


@pytest.mark.parametrize("corners", [4, 9, 40, 120])
def test_a_flat_patch_stays_what_it_covers(corners: int) -> None:
    """Splits and flips in the plane keep the area, every triangle's orientation, the rim, and make a manifold disc."""
    before = disc(corners)
    after = refined_patch(before)
    assert np.array_equal(after.points[:corners], before.points)
    # Sums of up to some thousand areas of the order of 1.
    assert area(after.points, after.triangles) == pytest.approx(area(before.points, before.triangles), rel=1e-11)
    a, b, c = (after.points[after.triangles[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
    assert len(non_manifold_edges(after.triangles)) == 0
    rim = np.sort(np.column_stack([np.arange(corners), (np.arange(corners) + 1) % corners]), axis=1)
    assert set(map(tuple, border_edges(after.triangles).tolist())) == set(map(tuple, rim.tolist()))
    assert len(after.points) - len(edges(after.triangles)) + len(after.triangles) == 1


@pytest.mark.parametrize("corners", [9, 40, 120])
def test_a_flat_patch_is_delaunay_where_rim_vertices_are_not_joined(corners: int) -> None:
    """No edge in the plane has opposite angles of more than pi, unless its flip would join two vertices of the rim."""
    patch = refined_patch(disc(corners))
    pairs, shared = face_adjacency(patch.triangles)
    apexes = patch.triangles[pairs].sum(axis=2) - shared.sum(axis=1)[:, None]
    bad = opposite_angles(patch) > np.pi + 2e-7
    assert (apexes[bad] < corners).all()


@pytest.mark.parametrize("wave", [0.0, 3.0])
def test_a_large_patch_is_as_dense_as_its_rim(wave: float) -> None:
    """Inside, edges are as long as at the rim within the spread that centroid splits leave, at one level or curved."""
    patch = refined_patch(disc(120, wave))
    mean = mean_edge_length(patch.points, patch.triangles)
    # A triangle is kept when one corner is nearer to the centroid than 1 / sqrt(2) of the size: equilateral ones with sides
    # under 1.22, and halves of those.
    assert 0.61 < mean / patch.sizes[:120].mean() < 1.22


def test_density_is_that_of_lengths() -> None:
    """With half the lengths there are about four times as many triangles."""
    patch = disc(80)
    counts = [len(refined_patch(patch._replace(sizes=share * patch.sizes)).triangles) for share in (1.0, 0.5)]
    assert 3.0 < counts[1] / counts[0] < 5.0


def test_no_edge_joins_two_vertices_of_the_rim() -> None:
    """In a narrow hole as in a wide one, every new face has a vertex that can be moved."""
    for corners in (4, 6, 30):
        patch = refined_patch(disc(corners))
        assert (patch.triangles >= corners).any(axis=1).all()
        inner = edges(patch.triangles)
        assert ((inner < corners).all(axis=1)).sum() == corners


def test_a_crack_gets_no_vertices() -> None:
    """Between two sides that are near each other compared with their edges there is no room for any."""
    x = np.arange(8.0)
    points = np.concatenate([np.column_stack([x, 0 * x, 0 * x]), np.column_stack([x[::-1] + 0.02, 0 * x + 0.05, 0 * x])])
    triangles = triangulate_rim(points, points + np.array([0.0, 0.0, -1.0]), vertex_pairs(16))
    assert triangles is not None
    assert len(refined_patch(Patch(points, np.full(16, 1.0), triangles, 16)).points) == 16


@pytest.mark.parametrize(("depth", "added"), [(0.1, 0), (0.49, 0), (0.51, 1), (1.0, 1)])
def test_an_edge_beside_one_low_triangle_is_in_a_crack(depth: float, added: int) -> None:
    """Between triangles of heights 1.2 and `depth` an edge is split if both are at least a quarter of the target length 2."""
    points = np.array([[0.0, 0, 0], [1, -depth, 0], [2, 0, 0], [1, 1.2, 0]])
    patch = Patch(points, np.full(4, 2.0), np.array([[0, 2, 3], [2, 0, 1]], dtype=np.int32), 4)
    assert len(refined_patch(patch, vertex_pairs(4, [1], [3])).points) == 4 + added


def test_forbidden_pairs_are_not_joined_even_if_they_were() -> None:
    """A diagonal, even in a crack, between vertices that the mesh joins already is split."""
    patch = disc(4)
    i, j = (int(v) for v in edges(patch.triangles)[np.ptp(edges(patch.triangles), axis=1) == 2][0])
    narrow = patch._replace(sizes=np.full(4, 100.0))
    assert (i, j) in set(map(tuple, edges(refined_patch(narrow).triangles).tolist()))
    assert (i, j) not in set(map(tuple, edges(refined_patch(narrow, vertex_pairs(4, [i], [j])).triangles).tolist()))


def test_triangles_do_not_depend_on_place_and_size() -> None:
    """Moved, turned and scaled, a patch gets the same triangles, and the same to the bit when it is done twice."""
    patch = disc(60, 2.0)
    expected = refined_patch(patch)
    turned = patch._replace(points=patch.points @ rotation(2).T * 1e3 + 50.0, sizes=patch.sizes * 1e3)
    assert np.array_equal(refined_patch(turned).triangles, expected.triangles)
    again = refined_patch(patch)
    assert np.array_equal(again.points, expected.points)
    assert np.array_equal(again.triangles, expected.triangles)


def test_a_hole_of_any_size_gets_a_bounded_number_of_vertices() -> None:
    """A band u edges wide and the inside have (k u + k / slope) 2 / sqrt(3) vertices: the width is that of the most of them."""
    side = np.sqrt(3.0) / 2.0
    for corners in (400, 2_000):
        angle = 2 * np.pi * np.arange(corners) / corners
        rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(corners)]) / (2 * np.sin(np.pi / corners))
        fan = np.column_stack([np.zeros(corners - 2), np.arange(1, corners - 1), np.arange(2, corners)]).astype(np.int32)
        width = uniform_width(Patch(rim, np.ones(corners), fan, corners))
        if np.pi * (corners / (2 * np.pi)) ** 2 / side <= MOST_VERTICES:
            assert width == np.inf
        else:
            assert corners * (width + 1 / SLOPE) / side == pytest.approx(MOST_VERTICES)


def test_edges_grow_with_the_distance_from_the_rim() -> None:
    """Twice the width of the band away, in edges of length 1/2 there, edges are 1 + slope width as long; within it they are 1."""
    rim, lengths = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), np.full(3, 0.5)
    points = np.array([[0.5, 0.0, 0.0], [0.0, 1.5, 0.0], [1.0, 3.0, 0.0]])
    np.testing.assert_allclose(growing(lengths, points, rim, 3.0) / lengths, [1.0, 1.0, 1.0 + 3.0 * SLOPE])
    assert (growing(lengths, 100.0 * points, points, np.inf) == lengths).all()


def test_a_graded_patch_has_fewer_vertices_and_the_same_rim() -> None:
    """With a band of two edges a flat disc keeps its area and is coarser in the middle, by as much as edges are to grow."""
    even, graded = refined_patch(disc(120)), refined_patch(disc(120), uniform=2.0)
    assert len(graded.points) < 0.5 * len(even.points)
    assert area(graded.points, graded.triangles) == pytest.approx(area(even.points, even.triangles), rel=1e-11)
    lengths = []
    for patch in (even, graded):
        ends = edges(patch.triangles)
        middle = np.linalg.norm(patch.points[ends].mean(axis=1), axis=1) < 0.3 * 120 / (2 * np.pi)
        lengths.append(np.linalg.norm(patch.points[ends[:, 0]] - patch.points[ends[:, 1]], axis=1)[middle].mean())
    # The middle of the disc is between 0.6 and 1.1 of its radius away from the rim; splitting in halves overshoots by up to 2.
    growth = 1 + SLOPE * (np.array([0.6, 1.1]) * 120 / (2 * np.pi) - 2)
    assert growth[0] / 2 < lengths[1] / lengths[0] < growth[1]
    assert len(non_manifold_edges(graded.triangles)) == 0


def test_a_filling_that_bulges_does_not_outgrow_its_bound() -> None:
    """Drawn out to a cone a hundred times as high as wide, refined triangles are still about as many as the bound allows."""
    vertices, faces = icosphere(3)
    faces = np.ascontiguousarray(faces[vertices[faces].mean(axis=1)[:, 2] < 0.5])
    (rim,) = boundary_loops(vertices, faces)[0]
    patches = Patches(vertices, faces, [rim])
    assert patches.add(rim, [], True, ignore_progress)
    new = patches.gathered()[0]
    patches.move(new + np.column_stack([0.0 * new[:, :2], 200.0 * (1.0 - np.linalg.norm(new[:, :2], axis=1))]))
    patches.refine_again(True, ignore_progress)
    # Splitting at centroids overshoots: where three vertices are wanted in a row there may be up to four.
    assert 0.2 * MOST_VERTICES < len(patches.gathered()[0]) < 2.0 * MOST_VERTICES


@pytest.mark.slow
def test_a_patch_that_was_thrown_out_is_not_split_for_ever() -> None:
    """Sides of a billionth of what the triangles measure would need 10^19 vertices; it gets at most 300,000, and soon."""
    patch = disc(12)
    refined = refined_patch(patch._replace(sizes=patch.sizes * 1e-9))
    assert 10_000 < len(refined.points) <= 300_000 + patch.n_rim**2  # middles of edges between vertices of the rim

"""Boundary loops: loops of border edges in the direction of the faces that would close them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from numpy.typing import NDArray

from pymeshfair.filters.holes.rims import broken_left_open
from pymeshfair.filters.topology import BoundaryLoop, border_edges, boundary_loops
from tests.filters.test_topology import any_faces
from tests.meshes import Mesh, book, bow_tie, grid, icosphere, moebius_strip, renumbered, tube

Edges = set[tuple[int, int]]


def directed(faces: NDArray[np.int32]) -> list[tuple[int, int]]:
    """The edges of all triangles in their direction."""
    return [(int(face[k]), int(face[(k + 1) % 3])) for face in faces for k in range(3) if len(set(face.tolist())) == 3]


def along(loop: BoundaryLoop) -> list[tuple[int, int]]:
    """The edges of a loop in its direction."""
    return list(zip(loop.vertices.tolist(), np.roll(loop.vertices, -1).tolist(), strict=True))


def without_squares(squares: list[tuple[int, int]], rows: int = 8, columns: int = 8) -> Mesh:
    """A flat grid without the squares in these (row, column)."""
    vertices, faces = grid(rows, columns)
    gone = [row * columns + column for row, column in squares]
    return vertices, np.delete(faces, gone + [rows * columns + square for square in gone], axis=0)


def lengths(mesh: Mesh) -> list[int]:
    """How many edges each loop has."""
    loops, broken = boundary_loops(*mesh)
    assert broken == []
    return [len(loop.vertices) for loop in loops]


def test_a_hole_and_the_outer_border_are_two_loops_against_the_faces() -> None:
    """In a sheet with a hole, either loop goes against the direction of the faces and names the third vertex of each."""
    vertices, faces = without_squares([(3, 3), (3, 4)])
    loops, broken = boundary_loops(vertices, faces)
    assert broken == []
    assert [len(loop.vertices) for loop in loops] == [32, 6]
    triangles = {frozenset(face) for face in faces.tolist()}
    for loop in loops:
        assert {(b, a) for a, b in along(loop)} <= set(directed(faces))
        for (a, b), c in zip(along(loop), loop.opposite.tolist(), strict=True):
            assert frozenset((a, b, c)) in triangles


@pytest.mark.parametrize("kind", [np.int64, np.uint8, np.uint32])
def test_faces_may_be_whole_numbers_of_any_kind(kind: Any) -> None:
    """Also unsigned ones, as trimesh and files have them."""
    vertices, faces = grid(4, 4)
    (found,), (expected,) = (boundary_loops(vertices, np.asarray(cells)).loops for cells in (faces.astype(kind), faces))
    assert np.array_equal(found.vertices, expected.vertices)
    assert found.vertices.dtype == np.int32


def test_a_tube_has_two_loops() -> None:
    """Each end is one."""
    assert lengths(tube(16, 6)) == [16, 16]


def test_holes_that_share_a_vertex_are_loops_of_their_own() -> None:
    """Two squares out of a sheet that touch at a vertex: each loop has 4 edges and meets the vertex once."""
    loops, _ = boundary_loops(*without_squares([(2, 2), (3, 3)]))
    small = [loop.vertices.tolist() for loop in loops if len(loop.vertices) == 4]
    assert len(small) == 2
    assert set(small[0]) & set(small[1]) == {3 * 9 + 3}


def test_holes_that_share_several_vertices_are_loops_of_their_own() -> None:
    """A ring of eight squares that touch at vertices: eight loops of 4 edges, not one around all of them and one inside."""
    ring = [(1, 3), (2, 2), (3, 1), (4, 2), (5, 3), (4, 4), (3, 5), (2, 4)]
    assert lengths(without_squares(ring)) == [32] + [4] * 8


def test_three_holes_at_one_vertex() -> None:
    """Every second triangle of the six round a vertex taken away: three loops of 3 edges."""
    vertices, faces = icosphere(2)
    hub = 30
    around = np.flatnonzero((faces == hub).any(axis=1))
    assert len(around) == 6
    direction = vertices[faces[around]].mean(axis=1) - vertices[hub]
    x = direction[0]
    y = np.cross(vertices[hub], x)
    order = np.argsort(np.arctan2(direction @ y, direction @ x))
    assert lengths((vertices, np.delete(faces, around[order[::2]], axis=0))) == [3, 3, 3]


def test_a_part_attached_by_one_vertex_belongs_to_the_loop() -> None:
    """Two triangles that share a vertex have one loop of 6 edges, which meets it twice."""
    (loop,), broken = boundary_loops(*bow_tie())
    assert broken == []
    assert sorted(loop.vertices.tolist()) == [0, 0, 1, 2, 3, 4]


def test_a_border_without_an_orientation_is_broken() -> None:
    """A Moebius strip has no loop, and the message for its hole says what to do."""
    loops, (broken,) = boundary_loops(*moebius_strip())
    assert loops == []
    assert broken.reason == "orientation"
    assert "orient them first" in broken_left_open(broken).message


def test_a_border_at_a_non_manifold_edge_is_broken_and_others_are_not() -> None:
    """Three pages of a book are broken as one; the loops of a tube in the same mesh are found."""
    pages, tube_mesh = book(3), tube(8, 2)
    faces = np.concatenate([pages[1], tube_mesh[1] + len(pages[0])])
    loops, (broken,) = boundary_loops(np.concatenate([pages[0], tube_mesh[0]]), faces)
    assert broken.reason == "non_manifold"
    assert broken.vertices.tolist() == list(range(5))
    assert broken.vertex == 0
    assert [len(loop.vertices) for loop in loops] == [8, 8]


@given(any_faces())
def test_every_border_edge_is_on_one_loop_or_broken(drawn: tuple[NDArray[np.int32], int]) -> None:
    """Of any faces at all: loops are loops of border edges against their faces, share none, and the rest is broken."""
    faces, n = drawn
    vertices = np.random.default_rng(0).normal(size=(n, 3))
    loops, broken = boundary_loops(vertices, faces)
    border = {(int(a), int(b)) for a, b in border_edges(faces)}
    met = [(min(edge), max(edge)) for loop in loops for edge in along(loop)]
    assert len(met) == len(set(met))
    assert set(met) <= border
    assert {(b, a) for loop in loops for a, b in along(loop)} <= set(directed(faces))
    left = {int(v) for part in broken for v in part.vertices}
    assert all(a in left and b in left for a, b in border - set(met))


def test_loops_do_not_depend_on_the_numbering() -> None:
    """With vertices and faces in another order the same edges make the same loops."""
    mesh = without_squares([(1, 3), (2, 2), (3, 1), (5, 5), (5, 6)])
    vertices, faces, order = renumbered(mesh)
    loops = {frozenset(along(loop)) for loop in boundary_loops(*mesh)[0]}
    again = {frozenset((int(order[a]), int(order[b])) for a, b in along(loop)) for loop in boundary_loops(vertices, faces)[0]}
    assert loops == again

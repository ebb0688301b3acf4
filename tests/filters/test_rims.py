"""Rims: the loops of a border in the direction of the faces that would close it."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from numpy.typing import NDArray

from pymeshfair.filters.holes.rims import Rim, find_rims
from pymeshfair.filters.topology import border_edges
from tests.filters.test_topology import any_faces
from tests.meshes import Mesh, book, bow_tie, grid, icosphere, moebius_strip, renumbered, tube

Edges = set[tuple[int, int]]


def directed(faces: NDArray[np.int32]) -> list[tuple[int, int]]:
    """The edges of all triangles in their direction."""
    return [(int(face[k]), int(face[(k + 1) % 3])) for face in faces for k in range(3) if len(set(face.tolist())) == 3]


def along(rim: Rim) -> list[tuple[int, int]]:
    """The edges of a rim in its direction."""
    return list(zip(rim.vertices.tolist(), np.roll(rim.vertices, -1).tolist(), strict=True))


def without_squares(squares: list[tuple[int, int]], rows: int = 8, columns: int = 8) -> Mesh:
    """A flat grid without the squares in these (row, column)."""
    vertices, faces = grid(rows, columns)
    gone = [row * columns + column for row, column in squares]
    return vertices, np.delete(faces, gone + [rows * columns + square for square in gone], axis=0)


def lengths(mesh: Mesh) -> list[int]:
    """How many edges each rim has."""
    rims, refused = find_rims(*mesh)
    assert refused == []
    return [len(rim.vertices) for rim in rims]


def test_a_hole_and_the_outer_border_are_two_rims_against_the_faces() -> None:
    """In a sheet with a hole, either rim goes against the direction of the faces and names the third vertex of each."""
    vertices, faces = without_squares([(3, 3), (3, 4)])
    rims, refused = find_rims(vertices, faces)
    assert refused == []
    assert [len(rim.vertices) for rim in rims] == [32, 6]
    corners = {frozenset(face) for face in faces.tolist()}
    for rim in rims:
        assert {(b, a) for a, b in along(rim)} <= set(directed(faces))
        for (a, b), c in zip(along(rim), rim.opposite.tolist(), strict=True):
            assert frozenset((a, b, c)) in corners


def test_a_tube_has_two_rims() -> None:
    """Each end is one."""
    assert lengths(tube(16, 6)) == [16, 16]


def test_holes_that_share_a_vertex_are_rims_of_their_own() -> None:
    """Two squares out of a sheet that touch in a corner: each rim has 4 edges and meets the vertex once."""
    rims, _ = find_rims(*without_squares([(2, 2), (3, 3)]))
    small = [rim.vertices.tolist() for rim in rims if len(rim.vertices) == 4]
    assert len(small) == 2
    assert set(small[0]) & set(small[1]) == {3 * 9 + 3}


def test_holes_that_share_several_vertices_are_rims_of_their_own() -> None:
    """A ring of eight squares that touch in corners: eight rims of 4 edges, not one around all of them and one inside."""
    ring = [(1, 3), (2, 2), (3, 1), (4, 2), (5, 3), (4, 4), (3, 5), (2, 4)]
    assert lengths(without_squares(ring)) == [32] + [4] * 8


def test_three_holes_at_one_vertex() -> None:
    """Every second triangle of the six round a vertex taken away: three rims of 3 edges."""
    vertices, faces = icosphere(2)
    hub = 30
    around = np.flatnonzero((faces == hub).any(axis=1))
    assert len(around) == 6
    direction = vertices[faces[around]].mean(axis=1) - vertices[hub]
    x = direction[0]
    y = np.cross(vertices[hub], x)
    order = np.argsort(np.arctan2(direction @ y, direction @ x))
    assert lengths((vertices, np.delete(faces, around[order[::2]], axis=0))) == [3, 3, 3]


def test_a_part_that_hangs_on_one_vertex_belongs_to_the_rim() -> None:
    """Two triangles that share a vertex have one rim of 6 edges, which meets it twice."""
    (rim,), refused = find_rims(*bow_tie())
    assert refused == []
    assert sorted(rim.vertices.tolist()) == [0, 0, 1, 2, 3, 4]


def test_a_border_without_an_orientation_is_refused() -> None:
    """A Moebius strip has no rim, and the message says what to do."""
    rims, (refused,) = find_rims(*moebius_strip())
    assert rims == []
    assert refused.reason == "orientation"
    assert "orient them first" in refused.message


def test_a_border_at_a_non_manifold_edge_is_refused_and_others_are_not() -> None:
    """Three pages of a book are refused as one; the rims of a tube in the same mesh are found."""
    pages, tube_mesh = book(3), tube(8, 2)
    faces = np.concatenate([pages[1], tube_mesh[1] + len(pages[0])])
    rims, (refused,) = find_rims(np.concatenate([pages[0], tube_mesh[0]]), faces)
    assert refused.reason == "non_manifold"
    assert refused.vertices.tolist() == list(range(5))
    assert [len(rim.vertices) for rim in rims] == [8, 8]


@given(any_faces())
def test_every_border_edge_is_on_one_rim_or_refused(drawn: tuple[NDArray[np.int32], int]) -> None:
    """Of any faces at all: rims are loops of border edges against their faces, share none, and the rest is refused."""
    faces, n = drawn
    vertices = np.random.default_rng(0).normal(size=(n, 3))
    rims, refused = find_rims(vertices, faces)
    border = {(int(a), int(b)) for a, b in border_edges(faces)}
    met = [(min(edge), max(edge)) for rim in rims for edge in along(rim)]
    assert len(met) == len(set(met))
    assert set(met) <= border
    assert {(b, a) for rim in rims for a, b in along(rim)} <= set(directed(faces))
    left = {int(v) for part in refused for v in part.vertices}
    assert all(a in left and b in left for a, b in border - set(met))


def test_rims_do_not_depend_on_the_numbering() -> None:
    """With vertices and faces in another order the same edges make the same loops."""
    mesh = without_squares([(1, 3), (2, 2), (3, 1), (5, 5), (5, 6)])
    vertices, faces, order = renumbered(mesh)
    rims = {frozenset(along(rim)) for rim in find_rims(*mesh)[0]}
    again = {frozenset((int(order[a]), int(order[b])) for a, b in along(rim)) for rim in find_rims(vertices, faces)[0]}
    assert rims == again

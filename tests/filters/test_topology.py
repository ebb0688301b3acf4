"""Edges, one-rings, borders and components, against definitions written out in plain Python."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pymeshfair.filters import topology
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.mesh import check_mesh
from tests.meshes import AWKWARD, Mesh, bow_tie, grid, icosphere, moebius_strip, single_triangle, torus, tube, two_spheres


@st.composite
def any_faces(draw: st.DrawFn) -> tuple[NDArray[np.int32], int]:
    """Any triples of up to nine vertices: non-manifold, repeated, with a vertex named twice."""
    n = draw(st.integers(1, 9))
    triple = st.tuples(*[st.integers(0, n - 1)] * 3)
    return np.array(draw(st.lists(triple, max_size=14)), dtype=np.int32).reshape(-1, 3), n


def plain_edges(faces: NDArray[np.int32]) -> Counter[tuple[int, int]]:
    """Every edge and its number of faces, by the definition."""
    counts: Counter[tuple[int, int]] = Counter()
    for a, b, c in faces.tolist():
        if len({a, b, c}) == 3:
            counts.update((min(pair), max(pair)) for pair in ((a, b), (b, c), (c, a)))
    return counts


def as_pairs(array: NDArray[Any]) -> list[tuple[int, int]]:
    """The rows as tuples of plain numbers."""
    return [(int(a), int(b)) for a, b in array]


@given(any_faces())
def test_edges_are_those_of_the_definition(drawn: tuple[NDArray[np.int32], int]) -> None:
    """Edges, their face counts, borders and non-manifold edges of any faces at all, each in ascending order."""
    faces, n = drawn
    expected = sorted(plain_edges(faces).items())
    pairs, counts = topology.edge_face_counts(faces)
    assert list(zip(as_pairs(pairs), counts.tolist(), strict=True)) == expected
    assert as_pairs(topology.edges(faces)) == [edge for edge, _ in expected]
    assert as_pairs(topology.border_edges(faces)) == [edge for edge, k in expected if k == 1]
    assert as_pairs(topology.non_manifold_edges(faces)) == [edge for edge, k in expected if k > 2]
    on_border = {i for edge, k in expected if k == 1 for i in edge}
    assert topology.border_vertices(faces, n).tolist() == [i in on_border for i in range(n)]
    used = {i for edge, _ in expected for i in edge}
    assert topology.referenced_vertices(faces, n).tolist() == [i in used for i in range(n)]


@given(any_faces())
def test_one_rings_are_those_of_the_definition(drawn: tuple[NDArray[np.int32], int]) -> None:
    """Every one-ring ascending, each neighbour once and with the number of its faces, whatever the faces."""
    faces, n = drawn
    expected: dict[int, dict[int, int]] = defaultdict(dict)
    for (a, b), count in plain_edges(faces).items():
        expected[a][b] = expected[b][a] = count
    rings = topology.one_rings(faces, n)
    for i in range(n):
        span = slice(rings.offsets[i], rings.offsets[i + 1])
        assert rings.neighbours[span].tolist() == sorted(expected[i])
        assert rings.face_counts[span].tolist() == [expected[i][j] for j in sorted(expected[i])]


@given(any_faces())
def test_faces_are_adjacent_across_edges_with_two_of_them(drawn: tuple[NDArray[np.int32], int]) -> None:
    """Face adjacency lists exactly the edges with two faces, in ascending order, each with its two faces."""
    faces, _ = drawn
    at_edge = defaultdict(list)
    for f, (a, b, c) in enumerate(faces.tolist()):
        if len({a, b, c}) == 3:
            for pair in ((a, b), (b, c), (c, a)):
                at_edge[tuple(sorted(pair))].append(f)
    pairs, shared = topology.face_adjacency(faces)
    expected = sorted((edge, tuple(both)) for edge, both in at_edge.items() if len(both) == 2)
    assert list(zip(as_pairs(shared), as_pairs(pairs), strict=True)) == expected


@given(any_faces())
def test_components_are_those_of_the_definition(drawn: tuple[NDArray[np.int32], int]) -> None:
    """Two vertices have the same label if and only if a path of edges joins them; labels count from the lowest vertex up."""
    faces, n = drawn
    reach = np.eye(n, dtype=bool)
    for a, b in plain_edges(faces):
        reach[a, b] = reach[b, a] = True
    for _ in range(n):
        reach = reach @ reach
    labels, count = topology.connected_components(faces, n)
    used = topology.referenced_vertices(faces, n)
    assert (labels >= 0).tolist() == used.tolist()
    assert (labels[:, None] == labels)[np.ix_(used, used)].tolist() == reach[np.ix_(used, used)].tolist()
    _, first = np.unique(labels[used], return_index=True)
    assert (np.diff(first) > 0).all()
    assert count == len(first)


@pytest.mark.parametrize(
    ("mesh", "characteristic", "borders", "components"),
    [
        (icosphere(2), 2, 0, 1),
        (torus(), 0, 0, 1),
        (two_spheres(), 4, 0, 2),
        (grid(), 1, 34, 1),
        (tube(), 0, 32, 1),
        (moebius_strip(), 0, 24, 1),
        (single_triangle(), 1, 3, 1),
        (bow_tie(), 1, 6, 1),
    ],
    ids=["sphere", "torus", "two spheres", "grid", "tube", "moebius strip", "triangle", "bow tie"],
)
def test_numbers_of_known_surfaces(mesh: Mesh, characteristic: int, borders: int, components: int) -> None:
    """Euler characteristic, border edges and components of surfaces for which they are known."""
    vertices, faces = mesh
    assert len(vertices) - len(topology.edges(faces)) + len(faces) == characteristic
    assert len(topology.border_edges(faces)) == borders
    assert topology.connected_components(faces, len(vertices))[1] == components


def test_mean_edge_length_counts_every_edge_once() -> None:
    """The triangle of sides 3, 4, 5 has mean 4, two of them side by side too; an edge from a vertex to itself does not count."""
    vertices, faces = single_triangle()
    assert mean_edge_length(vertices, faces) == 4.0
    mirrored = np.concatenate([vertices, [[3.0, 4.0, 0.0]]])
    both = np.array([[0, 1, 2], [1, 3, 2]])
    assert mean_edge_length(mirrored, both) == pytest.approx((3 + 4 + 5 + 3 + 4) / 5, rel=1e-15)
    assert mean_edge_length(vertices, np.array([[0, 1]], dtype=np.int32)) == 3.0
    assert mean_edge_length(vertices, np.array([[0, 1], [1, 1], [1, 0], [2, 0], [0, 1]], dtype=np.int32)) == 3.5
    assert mean_edge_length(vertices, faces[:0]) == 0.0


def test_a_hub_of_many_triangles_is_sorted_in_order() -> None:
    """The one-ring of a hub with 3,000 neighbours in random order, which takes the long way of sorting, is ascending."""
    n = 3000
    rim = np.random.default_rng(3).permutation(n).astype(np.int32) + 1
    faces = np.column_stack([np.zeros(n, dtype=np.int32), rim, np.roll(rim, 1)])
    rings = topology.one_rings(faces, n + 1)
    assert rings.neighbours[:n].tolist() == list(range(1, n + 1))
    assert set(rings.face_counts[:n].tolist()) == {2}


def test_edges_are_cells_too() -> None:
    """A closed polyline of five vertices gives every vertex its two neighbours."""
    polygon = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 0]])
    rings = topology.one_rings(polygon, 6)
    assert rings.neighbours.reshape(5, 2).tolist() == [[1, 4], [0, 2], [1, 3], [2, 4], [0, 3]]
    assert np.diff(rings.offsets).tolist() == [2, 2, 2, 2, 2, 0]


@given(any_faces())
def test_rings_along_the_border_are_those_of_the_border_edges(drawn: tuple[NDArray[np.int32], int]) -> None:
    """What is left of the one-rings is what the border edges alone give, whatever the faces."""
    faces, n = drawn
    got, expected = topology.one_rings(faces, n).along_border(), topology.one_rings(topology.border_edges(faces), n)
    assert np.array_equal(got.offsets, expected.offsets)
    assert np.array_equal(got.neighbours, expected.neighbours)
    assert np.array_equal(got.face_counts, expected.face_counts)


def test_check_mesh_converts_and_does_not_copy() -> None:
    """Any real and integer types and memory orders become float64 and int32 in C order; what is so already is not copied."""
    vertices, faces = icosphere(1)
    same_vertices, same_faces = check_mesh(vertices, faces)
    assert same_vertices is vertices
    assert same_faces is faces
    other = check_mesh(np.asfortranarray(vertices, dtype=np.float32), np.asfortranarray(faces, dtype=np.uint64))
    assert [a.dtype for a in other] == [np.float64, np.int32]
    assert all(a.flags.c_contiguous for a in other)
    assert check_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])[0].dtype == np.float64
    empty = check_mesh([], [])
    assert [a.shape for a in empty] == [(0, 3), (0, 3)]


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ([[0, 0, 0], [np.nan, 1, 0], [1, 0, np.inf]], [[0, 1, 2]], r"vertex 1 is \[nan, 1.0, 0.0\]: 2 of 3 vertices"),
        ([[0, 0], [1, 1]], [[0, 1, 1]], r"vertices must be an \(n, 3\) array of real numbers, got shape \(2, 2\)"),
        ([["a", "b", "c"]], [[0, 0, 0]], "array of real numbers"),
        ([[0, 0, 0j]], [[0, 0, 0]], "array of real numbers"),
        ([[0, 0, 0]] * 3, [[0, 1, 2], [0, 1, 3], [-1, 0, 1]], r"face 1 is \[0, 1, 3\], but .* 0 to 2 \(2 such faces of 3\)"),
        ([[0, 0, 0]] * 4, [[0, 1, 2, 3]], r"faces must be an \(m, 3\) array of whole numbers, got shape \(1, 4\)"),
        ([[0, 0, 0]] * 3, [[0.0, 1.0, 2.0]], "whole numbers, got shape"),
        ([], [[0, 1, 2]], r"face 0 is \[0, 1, 2\]"),
        ([[0, 0, 0]] * 3, [[0, 1, 2**32]], "face 0 is"),
    ],
)  # fmt: skip
def test_check_mesh_refuses_what_is_no_mesh(vertices: Any, faces: Any, message: str) -> None:
    """The error names the first vertex or face that is wrong, how many there are, and what is allowed."""
    with pytest.raises(FilterInputError, match=message):
        check_mesh(np.array(vertices), np.array(faces))


@pytest.mark.parametrize("name", AWKWARD)
def test_every_awkward_mesh_has_a_topology(name: str) -> None:
    """Rings, edges, adjacency and components of every awkward mesh agree with each other on the number of edges."""
    vertices, faces = AWKWARD[name]()
    pairs, counts = topology.edge_face_counts(faces)
    rings = topology.one_rings(faces, len(vertices))
    assert len(rings.neighbours) == 2 * len(pairs)
    assert len(topology.face_adjacency(faces)[0]) == (counts == 2).sum()
    labels, _ = topology.connected_components(faces, len(vertices))
    assert (labels[pairs[:, 0]] == labels[pairs[:, 1]]).all()


@given(any_faces())
def test_the_faces_at_every_vertex_are_those_of_the_definition(drawn: tuple[NDArray[np.int32], int]) -> None:
    """Each row is a face in ascending order and its other two vertices in its direction; `ring_ends` are the rows without it."""
    faces, n = drawn
    rows = defaultdict(list)
    for f, face in enumerate(faces.tolist()):
        if len(set(face)) == 3:
            for k in range(3):
                rows[face[k]].append([f, face[(k + 1) % 3], face[(k + 2) % 3]])
    found = topology.vertex_faces(faces, n)
    offsets, ends = topology.ring_ends(faces, n)
    for i in range(n):
        assert found.rows[found.offsets[i] : found.offsets[i + 1]].tolist() == rows[i]
        assert ends[offsets[i] : offsets[i + 1]].reshape(-1, 2).tolist() == [row[1:] for row in rows[i]]
    assert topology.proper_faces(faces).tolist() == [len(set(face)) == 3 for face in faces.tolist()]


@given(any_faces(), st.integers(1, 3), st.integers(0, 2**9 - 1))
def test_a_submesh_is_that_of_the_definition(drawn: tuple[NDArray[np.int32], int], rings: int, marks: int) -> None:
    """The proper faces at the free vertices and at all rings but the last; vertices at borders of these rings are not free."""
    faces, n = drawn
    free = np.array([bool(marks >> i & 1) for i in range(n)])
    inside = set(np.flatnonzero(free).tolist())
    proper = [face for face in faces.tolist() if len(set(face)) == 3]
    for _ in range(rings - 1):
        inside |= {v for face in proper if inside & set(face) for v in face}
    near = [face for face in proper if inside & set(face)]
    counts = plain_edges(np.array(near, dtype=np.int32).reshape(-1, 3))
    border = {v for edge, count in counts.items() if count == 1 and inside & set(edge) for v in edge}
    points = np.arange(3.0 * n).reshape(n, 3)
    part = topology.submesh_around(points, faces, free, rings)
    assert part.vertices.tolist() == sorted({v for face in near for v in face})
    assert part.vertices[part.faces].tolist() == near
    np.testing.assert_array_equal(part.points, points[part.vertices])
    assert part.border.tolist() == [v in border for v in part.vertices.tolist()]
    assert part.free.tolist() == [bool(free[v]) and v not in border for v in part.vertices.tolist()]

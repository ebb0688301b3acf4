"""Edge flips in tables of faces and of the faces across their edges, against tables built anew."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from hypothesis import given
from numpy.typing import NDArray

from pymeshfair.filters.topology import corner_at, diamond, edges, faces_across, fan_size, flip
from tests.filters.test_topology import any_faces
from tests.meshes import bow_tie, grid, icosphere, wheel


def slow_across(faces: NDArray[np.int32]) -> list[list[int]]:
    """The definition: the other face of an edge with two faces that go along it in opposite directions."""
    at = defaultdict(list)
    for f, face in enumerate(faces.tolist()):
        if len(set(face)) == 3:
            for k in range(3):
                at[frozenset((face[k], face[(k + 1) % 3]))].append((f, k))
    across = [[-1, -1, -1] for _ in faces]
    for pair in at.values():
        if len(pair) == 2:
            (f, j), (g, k) = pair
            if faces[f, j] == faces[g, (k + 1) % 3]:
                across[f][j], across[g][k] = g, f
    return across


@given(any_faces())
def test_faces_across_are_those_of_the_definition(drawn: tuple[NDArray[np.int32], int]) -> None:
    """Of any faces at all, those that meet one other face at an edge coherently know it there, and no others do."""
    faces, _ = drawn
    assert faces_across(faces).tolist() == slow_across(faces)


def test_a_flip_leaves_the_tables_of_the_new_faces() -> None:
    """After each of many flips on a sphere `across` is what it is for these faces, and only the one edge has changed."""
    faces = icosphere(2)[1].copy()
    across = faces_across(faces)
    rng = np.random.default_rng(0)
    done = 0
    while done < 60:
        f, k = int(rng.integers(len(faces))), int(rng.integers(3))
        a, b, c, d = diamond(faces, across, f, k)
        if c == d or fan_size(faces, across, f, (k + 2) % 3, d) < 0:
            continue
        before = set(map(tuple, edges(faces).tolist()))
        flip(faces, across, f, k)
        assert across.tolist() == slow_across(faces)
        assert set(map(tuple, edges(faces).tolist())) == before - {(min(a, b), max(a, b))} | {(min(c, d), max(c, d))}
        done += 1


def test_a_diamond_is_the_edge_and_the_two_vertices_opposite() -> None:
    """Of two triangles that share the edge (0, 2), from either side."""
    faces = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    across = faces_across(faces)
    assert diamond(faces, across, 0, 2) == (2, 0, 1, 3)
    assert diamond(faces, across, 1, 0) == (0, 2, 3, 1)
    assert [corner_at(faces, 1, vertex) for vertex in (0, 2, 3)] == [0, 1, 2]


def test_the_size_of_a_fan() -> None:
    """All spokes of a wheel, from border to border in a grid, one of two triangles of a bow tie; -1 with a neighbour in it."""
    hub = wheel(7)[1]
    k = corner_at(hub, 0, 0)
    assert fan_size(hub, faces_across(hub), 0, k, 99) == 7
    assert fan_size(hub, faces_across(hub), 0, k, 5) == -1
    faces = grid(2, 2)[1]
    for f, vertex, size in (
        (int(np.flatnonzero((faces == v).any(axis=1))[0]), v, n) for v, n in ((0, 2), (1, 3), (4, 6), (2, 1))
    ):
        assert fan_size(faces, faces_across(faces), f, corner_at(faces, f, vertex), 99) == size
    tie = bow_tie()[1]
    assert fan_size(tie, faces_across(tie), 0, corner_at(tie, 0, 0), 99) == 1

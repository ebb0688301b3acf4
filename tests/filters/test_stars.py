"""The triangles round a vertex, in order."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from numpy.typing import NDArray

from pymeshfair.filters import topology
from pymeshfair.filters.topology import CLOSED, IRREGULAR, NO_STAR, OPEN, Stars, ring_ends, stars, vertex_stars
from tests.filters.test_topology import any_faces
from tests.meshes import AWKWARD, book, bow_tie, icosphere, moebius_strip, tube, wheel


def star_of(star: Stars, i: int) -> list[int]:
    """The neighbours of i."""
    return [int(j) for j in star.neighbours[star.offsets[i] : star.offsets[i + 1]]]


def faces_of(faces: NDArray[np.int32], i: int) -> list[set[int]]:
    """The other two vertices of each proper face of i."""
    return [set(f) - {i} for f in faces.tolist() if i in f and len(set(f)) == 3]


@given(any_faces())
def test_a_star_is_a_walk_over_all_its_triangles_and_no_others(drawn: tuple[NDArray[np.int32], int]) -> None:
    """Consecutive neighbours of closed and open stars are exactly the triangles; irregular ones have no such walk of vertices."""
    faces, n = drawn
    star = stars(faces, n)
    for i in range(n):
        triangles = sorted(map(sorted, faces_of(faces, i)))
        ring = star_of(star, i)
        assert len(ring) == len(set(ring))
        assert set(ring) == {j for t in triangles for j in t}
        walk = [sorted(pair) for pair in itertools.pairwise(ring)]
        round_trip = sorted([*walk, sorted([ring[-1], ring[0]])]) if ring else []
        if star.kinds[i] == NO_STAR:
            assert not triangles
        elif star.kinds[i] == OPEN:
            assert sorted(walk) == triangles
            assert ring[0] < ring[-1]
        elif star.kinds[i] == CLOSED:
            assert round_trip == triangles
            assert ring[0] == min(ring)
            assert ring[1] <= ring[-1]
        else:
            assert ring == sorted(ring)
            assert sorted(walk) != triangles
            assert round_trip != triangles


@given(any_faces())
def test_stars_and_rings_agree(drawn: tuple[NDArray[np.int32], int]) -> None:
    """Face counts and border edges found from the stars are those found from the edges, in the given order and in any other."""
    faces, n = drawn
    rings = topology.one_rings(faces, n)
    expected = {
        (i, int(j)): int(c)
        for i in range(n)
        for j, c in zip(
            rings.neighbours[rings.offsets[i] : rings.offsets[i + 1]],
            rings.face_counts[rings.offsets[i] : rings.offsets[i + 1]],
            strict=True,
        )
    }
    for order in (np.arange(n), np.random.default_rng(2).permutation(n)):
        star = stars(np.argsort(order).astype(np.int32)[faces], n, names=order.astype(np.int32))
        counts = star.face_counts()
        found = {
            (int(order[i]), int(order[star.neighbours[k]])): int(counts[k])
            for i in range(n)
            for k in range(star.offsets[i], star.offsets[i + 1])
        }
        assert found == expected
        borders = {tuple(sorted(order[list(edge)].tolist())) for edge in star.border_edges()}
        assert borders == {tuple(edge) for edge in topology.border_edges(faces).tolist()}
        assert len(star.border_edges()) == len(borders)


@pytest.mark.parametrize("name", AWKWARD)
def test_neither_the_order_of_the_faces_nor_that_of_the_vertices_changes_a_star(name: str) -> None:
    """Shuffled and turned faces, and new numbers with the old names, give the same stars, neighbour by neighbour."""
    vertices, faces = AWKWARD[name]()
    n = len(vertices)
    plain = stars(faces, n)
    rng = np.random.default_rng(5)
    shuffled = faces[rng.permutation(len(faces))]
    shuffled[::3] = shuffled[::3, ::-1]
    other = stars(np.roll(shuffled, 1, axis=1), n)
    assert np.array_equal(plain.kinds, other.kinds)
    assert np.array_equal(plain.neighbours, other.neighbours)
    order = rng.permutation(n).astype(np.int32)
    renumbered = stars(np.argsort(order).astype(np.int32)[shuffled], n, names=order)
    for k, i in enumerate(order):
        assert renumbered.kinds[k] == plain.kinds[i]
        assert [int(order[j]) for j in star_of(renumbered, k)] == star_of(plain, int(i))


def test_kinds_of_known_vertices() -> None:
    """Interior vertices are closed, border vertices open, and the middle of a bow tie, a spine and a great hub irregular."""
    assert set(stars(icosphere(2)[1], 162).kinds) == {CLOSED}
    vertices, faces = tube()
    assert ((stars(faces, len(vertices)).kinds == OPEN) == topology.border_vertices(faces, len(vertices))).all()
    assert set(stars(moebius_strip()[1], 24).kinds) == {OPEN}
    assert stars(bow_tie()[1], 6).kinds.tolist() == [IRREGULAR, OPEN, OPEN, OPEN, OPEN, NO_STAR]
    assert stars(book()[1], 5).kinds.tolist() == [IRREGULAR, IRREGULAR, OPEN, OPEN, OPEN]
    assert stars(wheel(64)[1], 65).kinds[0] == CLOSED
    assert stars(wheel(65)[1], 66).kinds[0] == IRREGULAR


def test_walks_stay_inside_the_pairs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels read no entry behind the last: run as Python, where numpy checks indices, on borders in many numberings."""
    for name in ("order_ends", "_walk_round", "_name", "slot_of", "_write_walk", "_chain"):
        monkeypatch.setattr(vertex_stars, name, getattr(vertex_stars, name).py_func)
    monkeypatch.setattr(vertex_stars, "prange", range)
    vertices, faces = tube()
    n, rng = len(vertices), np.random.default_rng(3)
    with np.errstate(over="ignore"):
        for _ in range(10):
            offsets, ends = ring_ends(rng.permutation(n).astype(np.int32)[faces], n)
            kinds, walks = np.empty(n, np.uint8), np.empty(len(ends) // 2, np.int32)
            vertex_stars.order_ends(offsets, ends, None, kinds, walks)
            assert set(kinds) == {CLOSED, OPEN}

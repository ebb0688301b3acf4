"""The triangulation of a rim, against closed forms, an enumeration and the recursion written out."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pymeshfair.filters.holes import triangulation
from pymeshfair.filters.holes.triangulation import VertexPairs, is_pair, triangulate_rim, vertex_pairs
from tests.meshes import area, rotation

Floats = NDArray[np.float64]


def star(corners: int, depth: float = 0.5) -> tuple[Floats, Floats]:
    """A flat star about the origin, every second corner drawn in, with flat faces outside it."""
    angle = 2 * np.pi * np.arange(corners) / corners + 0.1
    radius = np.where(np.arange(corners) % 2, 1.0 - depth, 1.0) * (1.0 + 0.01 * np.cos(7 * angle + 1.0))
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(corners)])
    middles = (points + np.roll(points, -1, axis=0)) / 2
    outward = np.cross(np.roll(points, -1, axis=0) - points, [0.0, 0.0, 1.0])
    return points, middles + outward


def bent(corners: int, seed: int) -> tuple[Floats, Floats]:
    """A round rim with random heights and random faces around it."""
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * np.arange(corners) / corners
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(corners)])
    points = circle + rng.normal(0.0, 0.15, (corners, 3))
    return points, (points + np.roll(points, -1, axis=0)) * 0.8 + rng.normal(0.0, 0.2, (corners, 3))


def nothing(corners: int) -> VertexPairs:
    """No diagonal forbidden."""
    return vertex_pairs(corners)


def polygon_area(points: Floats) -> float:
    """The area of a flat polygon in the plane z = 0, positive if it goes round counter-clockwise."""
    x, y = points[:, 0], points[:, 1]
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def normal(a: Floats, b: Floats, c: Floats) -> Floats:
    """The unit normal of a triangle."""
    cross = np.cross(b - a, c - a)
    return np.asarray(cross / np.linalg.norm(cross))


def by_the_recursion(points: Floats, opposite: Floats) -> frozenset[tuple[int, int, int]]:
    """The dynamic programme as the paper states it, with memoised calls."""
    n = len(points)

    def beyond(i: int, j: int) -> Floats:
        if j == i + 1:
            return normal(points[j], points[i], opposite[i])
        m = best(i, j)[1]
        return normal(points[i], points[m], points[j])

    @functools.cache
    def best(i: int, j: int) -> tuple[tuple[float, float], int]:
        if j == i + 1:
            return (0.0, 0.0), -1
        found: Any = ((np.inf, np.inf), -1)
        for m in range(i + 1, j):
            own = normal(points[i], points[m], points[j])
            parts = best(i, m)[0], best(m, j)[0]
            bends = [1.0 - own @ beyond(i, m), 1.0 - own @ beyond(m, j)]
            if (i, j) == (0, n - 1):
                bends.append(1.0 - own @ normal(points[0], points[n - 1], opposite[n - 1]))
            size = float(np.linalg.norm(np.cross(points[m] - points[i], points[j] - points[i])))
            found = min(found, ((max(parts[0][0], parts[1][0], *bends), parts[0][1] + parts[1][1] + size), m))
        return found  # type: ignore[no-any-return]

    def collected(i: int, j: int) -> set[tuple[int, int, int]]:
        m = best(i, j)[1]
        return set() if m < 0 else {(i, m, j)} | collected(i, m) | collected(m, j)

    return frozenset(collected(0, n - 1))


def as_set(triangles: NDArray[np.int32] | None) -> frozenset[tuple[int, ...]]:
    """The triangles, each from its lowest corner on, in no order."""
    assert triangles is not None
    return frozenset(tuple(np.roll(row, -int(row.argmin())).tolist()) for row in triangles)


@pytest.mark.parametrize("corners", [4, 10, 30, 60])
def test_a_flat_rim_is_covered_once(corners: int) -> None:
    """In a flat sheet the triangles of any simple polygon, convex or not, have its area: none is turned over or outside."""
    points, opposite = star(corners)
    triangles = triangulate_rim(points, opposite, nothing(corners))
    assert triangles is not None
    assert len(triangles) == corners - 2
    # The sum of some sixty products of ordinary numbers.
    assert area(points, triangles) == pytest.approx(polygon_area(points), rel=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_triangles_are_those_of_the_recursion(seed: int) -> None:
    """On random rims the compiled programme finds what the recursion finds that is written as the paper has it."""
    points, opposite = bent(9, seed)
    assert as_set(triangulate_rim(points, opposite, nothing(9))) == by_the_recursion(points, opposite)


@pytest.mark.parametrize("seed", range(6))
def test_of_four_corners_the_less_bent_diagonal_is_chosen(seed: int) -> None:
    """With four corners there are two triangulations; the one with the smaller largest angle is taken."""
    points, opposite = bent(4, seed)
    sides = [normal(points[(i + 1) % 4], points[i], opposite[i]) for i in range(4)]
    worst = []
    for i in (0, 1):
        one = normal(points[i], points[i + 1], points[i + 2])
        two = normal(points[i], points[i + 2], points[(i + 3) % 4])
        pairs = [(one, two), (one, sides[i]), (one, sides[i + 1]), (two, sides[i + 2]), (two, sides[(i + 3) % 4])]
        worst.append(max(1.0 - u @ v for u, v in pairs))
    triangles = as_set(triangulate_rim(points, opposite, nothing(4)))
    assert ((0, 1, 2) in triangles) == (worst[0] < worst[1])


def test_forbidden_diagonals_are_not_used() -> None:
    """Of four corners with one diagonal forbidden the other is taken; with both there is no triangulation."""
    points, opposite = bent(4, 0)
    forbidden = vertex_pairs(4, [0], [2])
    assert as_set(triangulate_rim(points, opposite, forbidden)) == {(0, 1, 3), (1, 2, 3)}
    assert triangulate_rim(points, opposite, forbidden.with_pairs([1], [3])) is None


def test_degenerate_triangles_are_not_used() -> None:
    """A rim with three corners on a line is triangulated without the triangle between them; one all on a line not at all."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    triangles = triangulate_rim(points, points + np.array([0.0, 0.0, 1.0]), nothing(5))
    assert (0, 1, 2) not in as_set(triangles)
    line = points * [1.0, 0.0, 0.0]
    assert triangulate_rim(line, line + np.array([0.0, 0.0, 1.0]), nothing(5)) is None


def test_triangles_do_not_depend_on_place_and_size() -> None:
    """Moved, turned and a million times larger, a rim gets the same triangles."""
    points, opposite = bent(40, 3)
    expected = as_set(triangulate_rim(points, opposite, nothing(40)))
    turn = rotation(1)
    moved = [(p @ turn.T) * 1e6 + 1e6 for p in (points, opposite)]
    assert as_set(triangulate_rim(moved[0], moved[1], nothing(40))) == expected


def test_a_long_rim_is_divided_and_still_covered_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A rim cut into parts by chords keeps its area, and the parts fit: every diagonal has two triangles."""
    points, opposite = star(90, 0.2)
    monkeypatch.setattr(triangulation, "LARGEST_WHOLE", 12)
    triangles = triangulate_rim(points, opposite, nothing(90))
    assert triangles is not None
    assert len(triangles) == 88
    assert area(points, triangles) == pytest.approx(polygon_area(points), rel=1e-12)
    edges = {(int(t[k]), int(t[(k + 1) % 3])) for t in triangles for k in range(3)}
    assert len(edges) == 3 * 88
    assert {(a, b) for a, b in edges if (b, a) not in edges} == {(i, (i + 1) % 90) for i in range(90)}


def test_work_can_be_stopped() -> None:
    """What `progress` raises ends the work."""

    def stop(done: float) -> None:
        raise KeyboardInterrupt

    points, opposite = bent(20, 0)
    with pytest.raises(KeyboardInterrupt):
        triangulate_rim(points, opposite, nothing(20), progress=stop)


def energy(points: Floats, opposite: Floats, triangles: NDArray[np.int32]) -> tuple[float, float]:
    """The largest angle between two triangles or one and the face at its side, as 1 - cos, and the doubled area."""
    owner = {(int(t[k]), int(t[(k + 1) % 3])): t for t in triangles for k in range(3)}
    worst = 0.0
    for (u, v), t in owner.items():
        across = points[owner[v, u]] if (v, u) in owner else np.array([points[v], points[u], opposite[u]])
        worst = max(worst, 1.0 - float(normal(*points[t]) @ normal(*across)))
    return worst, 2 * area(points, triangles)


@pytest.mark.parametrize("seed", range(4))
def test_parts_triangulated_anew_bend_no_more(seed: int) -> None:
    """Around a chord the best triangles replace the given ones, so that the largest angle, or the area at the same, is less."""
    points, opposite = bent(40, seed)
    fan = np.column_stack([np.zeros(38), np.arange(1, 39), np.arange(2, 40)]).astype(np.int32)
    rim = triangulation.RimTriangles(points, opposite, nothing(40), np.empty((38, 3), dtype=np.int32), {})
    rim.enter(range(38), fan)
    triangulation.retriangulate(rim, (20, 0))
    better = rim.triangles
    assert energy(points, opposite, better) < energy(points, opposite, fan)
    # All 38 triangles lie in one window, so nothing is better than what is found for the whole rim at once.
    assert as_set(better) == as_set(triangulate_rim(points, opposite, nothing(40)))


@pytest.mark.parametrize("seed", range(3))
def test_a_long_rim_in_parts_is_nearly_as_good_as_at_once(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """In parts of 30 a bent rim of 90 has at most a tenth more area, and all diagonals have two triangles."""
    points, opposite = bent(90, seed)
    whole = triangulate_rim(points, opposite, nothing(90))
    monkeypatch.setattr(triangulation, "LARGEST_WHOLE", 30)
    parts = triangulate_rim(points, opposite, nothing(90))
    assert whole is not None
    assert parts is not None
    assert area(points, parts) < 1.1 * area(points, whole)
    assert len({(int(t[k]), int(t[(k + 1) % 3])) for t in parts for k in range(3)}) == 3 * 88


def test_a_flat_rim_gets_no_fans() -> None:
    """Where all triangulations are equally good parts are halved: no corner has over two triangles on each of log2(64) levels."""
    angle = 2 * np.pi * np.arange(64) / 64
    points = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(64)])
    triangles = triangulate_rim(points, 1.1 * points, nothing(64))
    assert triangles is not None
    assert np.bincount(triangles.ravel()).max() <= 2 * 6  # 64 = 2^6


def test_pairs_are_a_symmetric_matrix_without_its_zeros() -> None:
    """Joined, restricted and asked one by one, pairs are what a full matrix says."""
    rng = np.random.default_rng(2)
    full = np.zeros((12, 12), dtype=np.bool_)
    pairs = vertex_pairs(12)
    for _ in range(3):
        first, second = rng.integers(0, 12, (2, 5))
        full[first, second] = full[second, first] = True
        pairs = pairs.with_pairs(first, second)
    chosen = rng.permutation(12)[:7].astype(np.int32)
    assert np.array_equal(pairs.among(chosen), full[np.ix_(chosen, chosen)])
    assert all(is_pair(pairs, i, j) == full[i, j] for i in range(12) for j in range(12))

"""Polygons as triangles: fans of convex ones, ears cut off of others [meisters1975]."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..filters.compilation import compiled


def triangulated(
    vertices: NDArray[np.float64], corners: NDArray[np.int64], lengths: NDArray[np.int64]
) -> tuple[NDArray[np.int32], NDArray[np.int32] | None, dict[str, NDArray[Any]]]:
    """Triangles of polygons, k - 2 of a polygon of k corners, in the order of the polygons.

    Args:
        vertices: (n, 3) coordinates.
        corners: (c,) indices of vertices, those of one polygon after those of another.
        lengths: (p,) how many corners each polygon has, at least 3.

    Returns:
        (m, 3) which of the corners those of each triangle are; (m,) the polygon of each, None if all polygons are triangles; and
        the attribute ``polygon`` of the triangles, see `outlines`.
    """
    if not len(lengths) or (lengths == 3).all():
        return np.arange(len(corners), dtype=np.int32).reshape(-1, 3), None, {}
    places = np.empty((int((lengths - 2).sum()), 3), np.int32)
    of_polygon = np.repeat(np.arange(len(lengths), dtype=np.int32), lengths - 2)
    _cut(vertices, corners.astype(np.int64), lengths, np.empty(int(lengths.max()), np.int64), places)
    return places, of_polygon, {"polygon": np.where(lengths[of_polygon] > 3, of_polygon, -1).astype(np.int32)}


class Outlines(NamedTuple):
    """Polygons made of triangles again."""

    #: (c,) which of the 3 m corners of the triangles each corner is, those of one polygon after those of another
    places: NDArray[np.int64]
    lengths: NDArray[np.int64]  # (p,) how many corners each has
    broken: int = 0  # how many polygons are left in triangles, as some of theirs are gone, or they have an edge twice

    @property
    def triangles(self) -> NDArray[np.int64]:
        """(p,) the first triangle of each."""
        return np.asarray(self.places[np.cumsum(self.lengths) - self.lengths] // 3)

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes of a writer about them."""
        return (f"polygons that are not whole are written as triangles ({self.broken:,})",) if self.broken else ()


def outlines(faces: NDArray[np.int32], polygon: NDArray[Any] | None) -> Outlines:
    """The polygons that (m, 3) triangles are parts of, in the order of their first triangles.

    `polygon` has the same number for the triangles of one polygon, -1 for a triangle of its own; it is None if all are.
    """
    m = len(faces)
    if polygon is None or not (polygon >= 0).any():
        return Outlines(np.arange(3 * m), np.full(m, 3))
    own = np.where(polygon >= 0, polygon, int(polygon.max()) + 1 + np.arange(m))
    _, firsts, group = np.unique(own, return_index=True, return_inverse=True)
    first = firsts[group.ravel()]
    members = np.argsort(first, kind="stable")
    counts = np.bincount(first, minlength=m)
    counts = counts[counts > 0]
    places, lengths = np.empty(3 * m, np.int64), np.empty(m, np.int64)
    at, more = np.full(int(faces.max()) + 1, -1, np.int64), np.empty(3 * m, np.int64)
    corners, number = _walk_round(faces.reshape(-1), members, counts, places, lengths, at, more)
    polygons = len(np.unique(polygon)) - bool((polygon < 0).any())
    return Outlines(places[:corners], lengths[:number], polygons - int((lengths[:number] > 3).sum()))


@compiled
def _end(corners: Any, e: int) -> int:
    """The vertex at which a half-edge ends."""
    return int(corners[e + 1 if e % 3 < 2 else e - 2])


@compiled
def _walk_round(corners: Any, members: Any, counts: Any, places: Any, lengths: Any, at: Any, more: Any) -> tuple[int, int]:
    """Fill the places and lengths of `Outlines`; the numbers of both.

    ``at`` has for a vertex the half-edge of a polygon that begins there, ``more`` the next one after each.
    """
    c, p, start = 0, 0, 0
    for count in counts:
        edges = (3 * members[start : start + count]).repeat(3)
        for k in range(3 * count):
            edges[k] += k % 3
        for e in edges:
            more[e] = at[corners[e]]
            at[corners[e]] = e
        size = 0  # of the rim: half-edges that no other triangle of the polygon has the other way round
        for e in edges:
            other = at[_end(corners, e)]
            while other >= 0 and _end(corners, other) != corners[e]:
                other = more[other]
            if other < 0:
                places[c + size] = e
                size += 1
        for e in edges:
            at[corners[e]] = -1
        closed = size == count + 2
        for e in places[c : c + size]:
            closed = closed and at[corners[e]] < 0
            at[corners[e]] = e
        e = places[c]
        for k in range(size):
            more[k] = e
            e = at[_end(corners, e)] if closed else -1
            closed = e >= 0 and (e == places[c]) == (k == size - 1)
        for e in edges:
            at[corners[e]] = -1
        if closed:
            places[c : c + size] = more[:size]
            lengths[p] = size
            c, p = c + size, p + 1
        else:
            places[c : c + 3 * count] = edges
            lengths[p : p + count] = 3
            c, p = c + 3 * count, p + count
        start += count
    return c, p


@compiled
def _turn(points: Any, a: int, b: int, c: int, normal: Any) -> float:
    """Twice the area of a triangle as seen against a normal: below 0 where it turns the other way."""
    ux, uy, uz = (points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2])
    vx, vy, vz = (points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2])
    return float((uy * vz - uz * vy) * normal[0] + (uz * vx - ux * vz) * normal[1] + (ux * vy - uy * vx) * normal[2])


@compiled
def _is_ear(points: Any, corners: Any, left: Any, count: int, k: int, normal: Any) -> bool:
    """Whether no other corner of the rest of a polygon lies in the triangle at its corner k."""
    a, b, c = corners[left[(k + count - 1) % count]], corners[left[k]], corners[left[(k + 1) % count]]
    if _turn(points, a, b, c, normal) <= 0.0:
        return False
    for j in range(count):
        p = corners[left[j]]
        if p != a and p != b and p != c:
            inside = _turn(points, a, b, p, normal) >= 0.0 and _turn(points, b, c, p, normal) >= 0.0
            if inside and _turn(points, c, a, p, normal) >= 0.0:
                return False
    return True


@compiled
def _cut(points: Any, corners: Any, lengths: Any, left: Any, places: Any) -> None:
    start, f = 0, 0
    normal = np.empty(3)
    for length in lengths:
        normal[:] = 0.0
        for k in range(length):  # Newell's normal
            a, b = corners[start + k], corners[start + (k + 1) % length]
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                normal[c] += (points[a, d] - points[b, d]) * (points[a, e] + points[b, e] - 2.0 * points[corners[start], e])
        convex = True
        if length > 3:
            for k in range(length):
                a, b, c = corners[start + k], corners[start + (k + 1) % length], corners[start + (k + 2) % length]
                convex = convex and _turn(points, a, b, c, normal) >= 0.0
        for k in range(length):
            left[k] = start + k
        count = length
        while not convex and count > 3:
            ear = -1
            for k in range(count):
                if _is_ear(points, corners, left, count, k, normal):
                    ear = k
                    break
            if ear < 0:
                break  # it crosses itself: the rest becomes a fan
            places[f, 0], places[f, 1], places[f, 2] = left[(ear + count - 1) % count], left[ear], left[(ear + 1) % count]
            f += 1
            count -= 1
            for k in range(ear, count):
                left[k] = left[k + 1]
        for k in range(1, count - 1):
            places[f, 0], places[f, 1], places[f, 2] = left[0], left[k], left[k + 1]
            f += 1
        start += length

"""Triangulates polygons by fans or ear clipping [meisters1975], and joins triangles into polygons; finds equal rows."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from ..filters.compilation import compiled
from ..filters.mesh import Floats, Ints, Longs, mask_of
from ..filters.topology import proper_faces
from ..mesh_data.mesh_data import Array
from .errors import ContentsError

LARGEST_FACE = 10_000  # the largest number of corners of a face; the time of triangulation grows with the square of this number


def triangulated(vertices: Floats, corners: Longs, lengths: Longs) -> tuple[Ints, Ints | slice, dict[str, Array]]:
    """Triangulates polygons: k - 2 triangles for a polygon of k corners, in the order of the polygons.

    `corners` has the (c,) vertex indices of all polygons in turn, `lengths` the number of corners of each, at least 3. Returns
    (m, 3) indices into `corners`; (m,) the polygon of each triangle; and a dict with the attribute ``polygon`` of the triangles,
    see `outlines`. If all polygons are triangles, the last two are a full slice and an empty dict.
    """
    if not len(lengths) or (lengths == 3).all():
        return np.arange(len(corners), dtype=np.int32).reshape(-1, 3), slice(None), {}
    if lengths.max() > LARGEST_FACE:
        raise ContentsError(f"it has a face of more than {LARGEST_FACE:,} vertices")
    places = np.empty((int((lengths - 2).sum()), 3), np.int32)
    of_polygon = np.repeat(np.arange(len(lengths), dtype=np.int32), lengths - 2)
    _cut(vertices, corners.astype(np.int64), lengths, np.empty(int(lengths.max()), np.int64), places)
    return places, of_polygon, {"polygon": np.where(lengths[of_polygon] > 3, of_polygon, -1).astype(np.int32)}


def edges_of(corners: Longs, lengths: Longs) -> Array:
    """Returns (e, 2) the edges of polylines; `lengths` has the corner count of each."""
    starts = np.delete(np.arange(len(corners)), np.cumsum(lengths)[lengths > 0] - 1)
    return np.stack([corners[starts], corners[starts + 1]], axis=1)


def triangles_of(corners: Longs, lengths: Longs, *, fans: bool) -> Longs:
    """Returns (t, 3) indices into `corners` of the triangles of strips or fans, without degenerate ones."""
    counts = np.maximum(lengths - 2, 0)
    first = np.repeat(np.cumsum(lengths) - lengths, counts)
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    odd = 0 if fans else step % 2
    places = np.stack([first if fans else first + step + odd, first + step + 1 - odd, first + step + 2], axis=1)
    return np.asarray(places[proper_faces(corners[places])])


class Outlines(NamedTuple):
    """Polygons joined from triangles."""

    places: Longs  # (c,) index of each polygon corner among the 3 m triangle corners, polygon by polygon
    lengths: Longs  # (p,) the corner count of each polygon
    triangles: Longs  # (p,) the triangle of the first corner of each polygon
    notes: tuple[str, ...] = ()  # on polygons that stay triangles: some are no disc, have inner vertices or several values


def outlines(faces: Ints, polygon: Array | None, values: Iterable[Array] = ()) -> Outlines:
    """Joins (m, 3) triangles into polygons, in the order of their first triangles.

    `polygon` has one number for all triangles of a polygon, -1 for a single triangle; None means single triangles only. Polygons
    whose triangles differ in an array of `values` (m, ...) stay triangles, since a polygon has the values of its first triangle.
    """
    m = len(faces)
    if polygon is None or not (polygon >= 0).any():
        return Outlines(np.arange(3 * m), np.full(m, 3), np.arange(m))
    number_of_triangle = np.where(polygon >= 0, polygon, int(polygon.max()) + 1 + np.arange(m))
    _, firsts, group = np.unique(number_of_triangle, return_index=True, return_inverse=True)
    first = firsts[group.ravel()]
    bits = np.hstack([np.empty((m, 0), np.uint8), *(np.ascontiguousarray(v).view(np.uint8).reshape(m, -1) for v in values)])
    differs = mask_of(first[(bits != bits[first]).any(axis=1)], m)[first]
    first[differs] = np.flatnonzero(differs)
    members = np.argsort(first, kind="stable")
    counts = np.bincount(first, minlength=m)
    counts = counts[counts > 0]
    places, lengths = np.empty(3 * m, np.int64), np.empty(m, np.int64)
    at, more = np.full(int(faces.max()) + 1, -1, np.int64), np.empty(3 * m, np.int64)
    corners, number = _walk_round(faces.reshape(-1), members, counts, places, lengths, at, more)
    places, lengths = places[:corners], lengths[:number]
    mixed = len(np.unique(polygon[differs]))
    broken = len(np.unique(polygon[polygon >= 0])) - int((lengths > 3).sum()) - mixed
    reasons = (("that are not whole", broken), ("whose triangles have different values", mixed))
    notes = tuple(f"polygons {reason} are written as triangles ({number:,})" for reason, number in reasons if number)
    return Outlines(places, lengths, places[np.cumsum(lengths) - lengths] // 3, notes)


@compiled
def _end(corners: Any, e: int) -> int:
    return int(corners[e + 1 if e % 3 < 2 else e - 2])


@compiled
def _walk_round(corners: Any, members: Any, counts: Any, places: Any, lengths: Any, at: Any, more: Any) -> tuple[int, int]:
    """Fills `places` and `lengths`. `at` has a half-edge from each vertex, `more` the next half-edge from the same vertex."""
    c, p, start = 0, 0, 0
    for count in counts:
        edges = (3 * members[start : start + count]).repeat(3)
        for k in range(3 * count):
            edges[k] += k % 3
        for e in edges:
            more[e] = at[corners[e]]
            at[corners[e]] = e
        size = 0  # number of half-edges on the rim: those without an opposite half-edge in the polygon
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
            more[k] = e  # from here on `more` has the half-edges of the rim in their order
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
    """Returns the dot product of `normal` and (b - a) x (c - a): negative if abc is clockwise, seen from the normal's tip."""
    ux, uy, uz = (points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2])
    vx, vy, vz = (points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2])
    return float((uy * vz - uz * vy) * normal[0] + (uz * vx - ux * vz) * normal[1] + (ux * vy - uy * vx) * normal[2])


@compiled
def _is_ear(points: Any, corners: Any, left: Any, outside: Any, count: int, k: int, normal: Any) -> bool:
    """Whether remaining corner k is convex and its triangle contains no other; those below `outside[k]` were found outside."""
    a, b, c = corners[left[(k + count - 1) % count]], corners[left[k]], corners[left[(k + 1) % count]]
    if _turn(points, a, b, c, normal) <= 0.0:
        return False
    for j in range(np.searchsorted(left[:count], outside[k]), count):
        p, outside[k] = corners[left[j]], left[j]
        if p != a and p != b and p != c:
            inside = _turn(points, a, b, p, normal) >= 0.0 and _turn(points, b, c, p, normal) >= 0.0
            if inside and _turn(points, c, a, p, normal) >= 0.0:
                return False
    return True


@compiled
def _cut(points: Any, corners: Any, lengths: Any, left: Any, places: Any) -> None:
    """Fills `places` with the triangles of polygons: a fan for a convex polygon, otherwise ears, then a fan if no ear is left."""
    start, f = 0, 0
    normal, outside = np.empty(3), np.empty_like(left)  # `outside` of `_is_ear` is kept, so that time is quadratic
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
            left[k], outside[k] = start + k, 0
        count = length
        while not convex and count > 3:
            for ear in range(count):
                if _is_ear(points, corners, left, outside, count, ear, normal):
                    break
            else:
                break  # the polygon crosses itself: its rest becomes a fan
            before, after = (ear + count - 1) % count, (ear + 1) % count
            places[f, 0], places[f, 1], places[f, 2] = left[before], left[ear], left[after]
            outside[before], outside[after] = 0, 0
            f += 1
            count -= 1
            for k in range(ear, count):
                left[k], outside[k] = left[k + 1], outside[k + 1]
        for k in range(1, count - 1):
            places[f, 0], places[f, 1], places[f, 2] = left[0], left[k], left[k + 1]
            f += 1
        start += length


def are_equal(a: Array | None, b: Array | None) -> bool:
    """Whether two arrays have equal numbers and NaN at the same places, or both are None."""
    if a is None or b is None:
        return a is b
    return np.array_equal(a, b, equal_nan=a.dtype.kind == "f")


def numbered(rows: Array) -> tuple[Longs, Longs]:
    """Returns (u,) the first index of each group of equal (n, k) `rows`, and (n,) the group of each row; NaNs are not equal."""
    values = np.ascontiguousarray(rows, np.float64) + 0.0  # -0 becomes 0
    firsts, numbers = np.empty(len(values), np.int64), np.empty(len(values), np.int64)
    size = 1 << max(2 * len(values) - 1, 1).bit_length()
    count = _number(values, values.view(np.uint64), np.full(size, -1, np.int64), firsts, numbers)
    return firsts[:count].copy(), numbers


@compiled
def _number(values: Any, bits: Any, table: Any, firsts: Any, numbers: Any) -> int:
    """Fills `firsts` and `numbers` by a hash table whose size is a power of two; returns the count of groups."""
    count, mask = 0, np.uint64(len(table) - 1)
    for i in range(len(values)):
        key = np.uint64(0)
        for k in range(values.shape[1]):
            key = (key ^ bits[i, k]) * np.uint64(0x9E3779B97F4A7C15)
            key ^= key >> np.uint64(29)
        place = key & mask
        while True:
            number = table[place]
            if number < 0:
                table[place] = numbers[i] = count
                firsts[count] = i
                count += 1
                break
            same = True
            for k in range(values.shape[1]):
                same = same and values[firsts[number], k] == values[i, k]
            if same:
                numbers[i] = number
                break
            place = (place + np.uint64(1)) & mask
    return count

"""Polygons as triangles: fans of convex ones, ears cut off of others [meisters1975]."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..filters.compilation import compiled


def triangulated(
    vertices: NDArray[np.float64], corners: NDArray[np.int64], lengths: NDArray[np.int64]
) -> tuple[NDArray[np.int32], NDArray[np.int32] | None]:
    """Triangles of polygons, k - 2 of a polygon of k corners, in the order of the polygons.

    Args:
        vertices: (n, 3) coordinates.
        corners: (c,) indices of vertices, those of one polygon after those of another.
        lengths: (p,) how many corners each polygon has, at least 3.

    Returns:
        (m, 3) triangles; (m,) the polygon of each, None if all polygons are triangles.
    """
    if not len(lengths) or (lengths == 3).all():
        return np.ascontiguousarray(corners.reshape(-1, 3), np.int32), None
    faces = np.empty((int((lengths - 2).sum()), 3), np.int32)
    of_polygon = np.repeat(np.arange(len(lengths), dtype=np.int32), lengths - 2)
    _cut(vertices, corners.astype(np.int64), lengths, np.empty(int(lengths.max()), np.int64), faces)
    return faces, of_polygon


@compiled
def _turn(points: Any, a: int, b: int, c: int, normal: Any) -> float:
    """Twice the area of a triangle as seen against a normal: below 0 where it turns the other way."""
    ux, uy, uz = (points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2])
    vx, vy, vz = (points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2])
    return float((uy * vz - uz * vy) * normal[0] + (uz * vx - ux * vz) * normal[1] + (ux * vy - uy * vx) * normal[2])


@compiled
def _is_ear(points: Any, left: Any, count: int, k: int, normal: Any) -> bool:
    """Whether no other corner of the rest of a polygon lies in the triangle at its corner k."""
    a, b, c = left[(k + count - 1) % count], left[k], left[(k + 1) % count]
    if _turn(points, a, b, c, normal) <= 0.0:
        return False
    for j in range(count):
        p = left[j]
        if p != a and p != b and p != c:
            inside = _turn(points, a, b, p, normal) >= 0.0 and _turn(points, b, c, p, normal) >= 0.0
            if inside and _turn(points, c, a, p, normal) >= 0.0:
                return False
    return True


@compiled
def _cut(points: Any, corners: Any, lengths: Any, left: Any, faces: Any) -> None:
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
            left[k] = corners[start + k]
        count = length
        while not convex and count > 3:
            ear = -1
            for k in range(count):
                if _is_ear(points, left, count, k, normal):
                    ear = k
                    break
            if ear < 0:
                break  # it crosses itself: what is left becomes a fan
            faces[f, 0], faces[f, 1], faces[f, 2] = left[(ear + count - 1) % count], left[ear], left[(ear + 1) % count]
            f += 1
            count -= 1
            for k in range(ear, count):
                left[k] = left[k + 1]
        for k in range(1, count - 1):
            faces[f, 0], faces[f, 1], faces[f, 2] = left[0], left[k], left[k + 1]
            f += 1
        start += length

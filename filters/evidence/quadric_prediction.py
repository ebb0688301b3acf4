"""Predicts the height of a vertex by a least-squares quadric fitted to its two rings: its neighbours and their neighbours.

In this module `points` are (n, 3) coordinates with edges of about 1, `rings` their one-rings, `normals` (n, 3) unit normals, and
`chosen` the indices of k vertices. The (n,) masks `hidden` and `ignored` exclude vertices from fits and medians.
"""

import math

import numpy as np

from ..compilation import compiled
from ..execution import over_range
from ..mesh import Bools, Floats, Ints, mask_of
from ..quadrics import height_of_quadric, tangents
from ..topology import OneRings, one_rings

# Width s of the weights, in mean distances of the one-ring: the second ring weighs less, since a quadric fits only nearby.
_WIDTH = 1.3
# The largest number of vertices used from two rings, which usually have a dozen to fifty vertices.
_CAPACITY = 1024


def predicted_heights(
    points: Floats, rings: OneRings, normals: Floats, chosen: Ints, hidden: Bools | None = None
) -> tuple[Floats, Floats]:
    """Predicts the heights of vertices along their normals from the surrounding vertices.

    For vertex i with the unit normal n, a polynomial of second degree in the tangential coordinates (a plane or a mean for few
    vertices) is fitted to the heights n . (p_j - p_i) of the vertices j in two rings, with the weights exp(-r^2 / 2 s^2); r is
    the tangential distance, s 1.3 times its mean in the one-ring. The prediction is the value at 0, a height above p_i.

    Returns:
        heights: (k,) in the unit of the points; 0 without a normal or surrounding vertices.
        gains: (k,) the standard deviation of the prediction for independent heights of standard deviation 1.
    """
    fits, excluded = np.zeros((2, len(chosen))), np.zeros(len(points), dtype=np.bool_) if hidden is None else hidden
    over_range(_predict, len(chosen), points, rings, normals, chosen, excluded, fits)
    return fits[0], fits[1]


def height_residuals(points: Floats, rings: OneRings, normals: Floats, hidden: Bools | None = None) -> Floats:
    """Returns (n,) heights / sqrt(1 + gains^2) of `predicted_heights`: independent noise of deviation d gives deviation d."""
    heights, gains = predicted_heights(points, rings, normals, np.arange(len(points), dtype=np.int32), hidden)
    return np.asarray(heights / np.sqrt(1.0 + gains**2))


def put_where_expected(points: Floats, faces: Ints, normals: Floats, chosen: Ints) -> Floats:
    """Returns (n, 3) the points, with the chosen points moved to their predicted heights."""
    hidden = mask_of(chosen, len(points))
    heights, _ = predicted_heights(points, one_rings(faces, len(points)), normals, chosen, hidden)
    result = points.copy()
    result[chosen] += heights[:, None] * normals[chosen]
    return result


def medians_around(values: Floats, rings: OneRings, ignored: Bools, wanted: Bools, none: float) -> tuple[Floats, Floats]:
    """Returns (n,) medians of the values in two rings round the `wanted` vertices, and (n,) median absolute deviations from them.

    `ignored` values do not count. Both results are `none` for vertices that are not `wanted`, and where no value counts.
    """
    middles, spreads = np.full(len(values), none), np.full(len(values), none)
    over_range(_find_medians, len(values), values, rings, ignored, wanted, middles, spreads)
    return middles, spreads


@compiled(nogil=True)
def _predict(
    points: Floats, rings: OneRings, normals: Floats, chosen: Ints, hidden: Bools, fits: Floats, begin: int, end: int
) -> None:
    seen, around = np.full(points.shape[0], -1, dtype=np.int32), np.empty(_CAPACITY, dtype=np.int32)
    samples, work = np.empty((4, _CAPACITY)), np.empty((9, 6))
    for k in range(begin, end):
        i = chosen[k]
        scale = _ring_distance(points, rings, normals, i)
        if scale == 0.0:
            continue
        count = _two_rings(rings, i, hidden, seen, around)
        if _project(points, normals, i, scale, around[:count], samples):
            height, gain = height_of_quadric(samples, count, math.inf, work)
            fits[0, k], fits[1, k] = scale * height, gain


@compiled(nogil=True)
def _find_medians(
    values: Floats, rings: OneRings, ignored: Bools, wanted: Bools, middles: Floats, spreads: Floats, first: int, last: int
) -> None:
    seen, around = np.full(values.shape[0], -1, dtype=np.int32), np.empty(_CAPACITY, dtype=np.int32)
    for i in range(first, last):
        count = _two_rings(rings, i, ignored, seen, around) if wanted[i] else 0
        if count > 0:
            values_around = values[around[:count]]
            middles[i] = np.median(values_around)
            spreads[i] = np.median(np.abs(values_around - middles[i]))


@compiled(nogil=True)
def _two_rings(rings: OneRings, i: int, ignored: Bools, seen: Ints, around: Ints) -> int:
    """Writes the vertices of two rings around i that are not ignored into `around`; returns their count."""
    offsets, neighbours, _ = rings
    count = 0
    seen[i] = i
    for near in range(offsets[i], offsets[i + 1]):
        g = neighbours[near]
        for far in range(offsets[g] - 1, offsets[g + 1]):
            j = g if far < offsets[g] else neighbours[far]
            if seen[j] != i and count < around.shape[0]:
                seen[j] = i
                if not ignored[j]:
                    around[count] = j
                    count += 1
    return count


@compiled(nogil=True)
def _ring_distance(points: Floats, rings: OneRings, normals: Floats, i: int) -> float:
    """Returns the mean tangential distance of the one-ring, which does not depend on the height of i."""
    total, around = 0.0, rings.neighbours[rings.offsets[i] : rings.offsets[i + 1]]
    for j in around:
        x, y, z = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
        h = normals[i, 0] * x + normals[i, 1] * y + normals[i, 2] * z
        total += math.sqrt(max(0.0, x * x + y * y + z * z - h * h))
    return total / len(around) if len(around) > 0 else 0.0


@compiled(nogil=True)
def _project(points: Floats, normals: Floats, i: int, scale: float, around: Ints, samples: Floats) -> bool:
    """Fills `samples` with tangential coordinates, heights and weights around i, in units of `scale`; False without a normal."""
    u, v, h, w = samples[0], samples[1], samples[2], samples[3]
    x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
    ax, ay, az, bx, by, bz = tangents(x, y, z)
    for k, j in enumerate(around):
        dx, dy, dz = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
        dx, dy, dz = dx / scale, dy / scale, dz / scale
        u[k], v[k] = ax * dx + ay * dy + az * dz, bx * dx + by * dy + bz * dz
        h[k] = x * dx + y * dy + z * dz
        w[k] = math.exp(-(u[k] ** 2 + v[k] ** 2) / (2.0 * _WIDTH * _WIDTH))
    return ax != 0.0 or ay != 0.0 or az != 0.0

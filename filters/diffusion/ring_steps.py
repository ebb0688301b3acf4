"""One diffusion step of the operators that need no more than edges: compiled kernels over one-rings.

Each kernel takes the points of one moment and writes those of the next for the listed vertices, all at once as the paper's
equation says: out_i = p_i + step (L p)_i. Vertices that are not listed keep what `out` holds.
"""

import math
from typing import Any

import numpy as np

from ..compilation import compiled, prange
from ..mesh import Floats, Ints, Longs

# Indices are taken as unsigned numbers: for signed ones the compiler adds the test whether they count from the end.
_U: Any = np.uint64


@compiled(parallel=True)
def uniform_step(points: Floats, out: Floats, which: Ints, offsets: Longs, neighbours: Ints, step: float) -> None:
    """Towards the mean of the one-ring."""
    for m in prange(which.shape[0]):
        i = _U(which[m])
        start, stop = _U(offsets[i]), _U(offsets[i + _U(1)])
        x = y = z = 0.0
        for k in range(start, stop):
            j = _U(neighbours[k])
            x += points[j, 0]
            y += points[j, 1]
            z += points[j, 2]
        share = step / np.int64(stop - start)
        out[i, 0] = points[i, 0] + (share * x - step * points[i, 0])
        out[i, 1] = points[i, 1] + (share * y - step * points[i, 1])
        out[i, 2] = points[i, 2] + (share * z - step * points[i, 2])


@compiled(parallel=True)
def weighted_step(
    points: Floats, out: Floats, which: Ints, offsets: Longs, neighbours: Ints, weights: Floats, shares: Floats
) -> None:
    """By the sum of given weights times edges, times the vertex's share, which holds the step and one over the mass."""
    for m in prange(which.shape[0]):
        i = _U(which[m])
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        x = y = z = 0.0
        for k in range(_U(offsets[i]), _U(offsets[i + _U(1)])):
            j = _U(neighbours[k])
            x += weights[k] * (points[j, 0] - px)
            y += weights[k] * (points[j, 1] - py)
            z += weights[k] * (points[j, 2] - pz)
        out[i, 0] = px + shares[i] * x
        out[i, 1] = py + shares[i] * y
        out[i, 2] = pz + shares[i] * z


@compiled(parallel=True)
def length_step(
    points: Floats,
    out: Floats,
    which: Ints,
    offsets: Longs,
    neighbours: Ints,
    step: float,
    shortest: float,
    by_arc_length: bool,
) -> float:
    """By the sum of edges over their lengths: over the sum of inverse lengths, or (`by_arc_length`) over half that of lengths.

    Edges shorter than `shortest` count as that long. Returns Gershgorin's bound of the spectrum of -L, by arc length.
    """
    bound = 0.0
    for m in prange(which.shape[0]):
        i = _U(which[m])
        row = _pull(points, out, i, neighbours, _U(offsets[i]), _U(offsets[i + _U(1)]), step, shortest, by_arc_length)
        bound = max(bound, row)
    return bound


@compiled
def _pull(
    points: Floats,
    out: Floats,
    i: int,
    neighbours: Ints,
    start: int,
    stop: int,
    step: float,
    shortest: float,
    by_arc_length: bool,
) -> float:
    px, py, pz = points[i, 0], points[i, 1], points[i, 2]
    x = y = z = inverses = lengths = 0.0
    for k in range(start, stop):
        j = _U(neighbours[k])
        dx, dy, dz = points[j, 0] - px, points[j, 1] - py, points[j, 2] - pz
        length = max(math.sqrt(dx * dx + dy * dy + dz * dz), shortest)
        weight = 1.0 / length
        x += weight * dx
        y += weight * dy
        z += weight * dz
        inverses += weight
        lengths += length
    share = 2.0 * step / lengths if by_arc_length else step / inverses
    out[i, 0] = px + share * x
    out[i, 1] = py + share * y
    out[i, 2] = pz + share * z
    return 4.0 * inverses / lengths


@compiled(parallel=True)
def sum_ring_lengths(points: Floats, offsets: Longs, neighbours: Ints, sums: Floats) -> None:
    """For every vertex the sum of the lengths of its edges, into `sums`."""
    for i in prange(sums.shape[0]):
        total = 0.0
        for k in range(_U(offsets[i]), _U(offsets[i + 1])):
            j = _U(neighbours[k])
            dx, dy, dz = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            total += math.sqrt(dx * dx + dy * dy + dz * dz)
        sums[i] = total

"""Orders of the vertices of a mesh in which neighbours lie near each other in memory."""

import math
from typing import Any

import numpy as np

from ..compilation import compiled, prange
from ..execution import over_range, threads_for
from .arrays import Floats, Ints

# A vertex and its neighbours up to this distance on both sides take a third of a second-level cache of 1 MB.
_NEAR = 8192
_SAMPLE = 20_000
# Reordering takes as much time as this many sweeps lose to a bad order, as measured.
_SWEEPS_A_REORDERING_COSTS = 8
# Slabs are so many typical edges thick, and so many at most in a direction.
_THICK, _MOST_SLABS = 2.0, 4096
# The slabs span the points but for this share on either side, so that a few far ones do not make them thick.
_STRAY = 0.01
#: Of fewer vertices a sweep finds most in the processor's caches, in any order.
FITS_IN_CACHE = 200_000
# Parts of a sort by counting, for threads.
_PARTS = 4


def worth_reordering(faces: Ints, n_vertices: int, sweeps: float = math.inf, *, size: int = 1) -> bool:
    """Whether that many sweeps over the one-rings are faster after a reordering.

    Subdivision, decimation and merging leave vertices in an order that has little to do with place. It makes no difference to
    the result of a sweep.

    The kernel reads of each vertex and its faces `size` times as much as three coordinates.
    """
    if n_vertices * size < FITS_IN_CACHE or len(faces) == 0 or sweeps < _SWEEPS_A_REORDERING_COSTS:
        return False
    sample = faces[:: max(1, len(faces) // _SAMPLE)].astype(np.int64)
    return bool((np.abs(sample[:, 0] - sample[:, 1]) * size > _NEAR).mean() > 0.25)


def order_by_place(points: Floats, faces: Ints, middle: Floats | None = None, scale: float = 1.0) -> Ints:
    """(n,) a permutation: the points by slabs across the longest direction, within a slab by the next direction, then the last.

    A sweep over a surface in this order reads a few rows of neighbours at a time, each from its start to its end. Breadth first
    would be better by a quarter, but takes longer to find: it visits one vertex after another, far apart in memory.

    About the (3,) `middle`, and times the scale, the coordinates are of ordinary size; there is a triangle at least.
    """
    n, middle = len(points), np.zeros(3) if middle is None else middle
    sample = faces[:: max(1, len(faces) // _SAMPLE)]
    starts, ends = (points[sample[:, 0]] - middle) * scale, (points[sample[:, 1]] - middle) * scale
    edge = float(np.median(np.linalg.norm(starts - ends, axis=1)))
    low, high = np.quantile(starts, (_STRAY, 1.0 - _STRAY), axis=0)
    order, other = np.arange(n, dtype=np.int32), np.empty(n, dtype=np.int32)
    slabs = np.empty(n, dtype=np.uint16)
    for axis in np.argsort(high - low, kind="stable"):
        count = min(_MOST_SLABS, 1 + int((high[axis] - low[axis]) / (_THICK * edge))) if edge > 0.0 else 1
        if count > 1:
            per_length = count / (high[axis] - low[axis])
            over_range(_find_slabs, n, points, axis, middle[axis], scale, low[axis], per_length, count, slabs)
            with threads_for(n):
                _sort_by_key(slabs, np.zeros((_PARTS, count), dtype=np.int32), order, other)
            order, other = other, order
    return order


def order_of_faces(faces: Ints, n_vertices: int, run: int = 1) -> Ints:
    """(m,) a permutation: the triangles by the number of their lowest vertex over `run`, rounded down.

    It suits vertices in an order such as that of `order_by_place`.
    """
    lowest = np.minimum(np.minimum(faces[:, 0], faces[:, 1]), faces[:, 2]) // np.int32(run)
    order = np.empty(len(faces), dtype=np.int32)
    starts = np.zeros((_PARTS, n_vertices // run + 1), dtype=np.int32)
    with threads_for(n_vertices):
        _sort_by_key(lowest, starts, np.arange(len(faces), dtype=np.int32), order)
    return order


@compiled(nogil=True)
def _find_slabs(
    points: Floats,
    axis: int,
    middle: float,
    scale: float,
    low: float,
    per_length: float,
    count: int,
    slabs: Any,
    first: int,
    last: int,
) -> None:
    for i in range(first, last):
        slabs[i] = min(max(((points[i, axis] - middle) * scale - low) * per_length, 0.0), count - 1.0)


@compiled(parallel=True)
def _sort_by_key(keys: Any, starts: Ints, order: Ints, ordered: Ints) -> None:
    """Sort by counting, stable: each part of `order` counts its own, and writes after those of the parts before it."""
    parts, n = starts.shape[0], order.shape[0]
    for part in prange(parts):
        for k in range(part * n // parts, (part + 1) * n // parts):
            starts[part, keys[order[k]]] += 1
    _counts_to_starts(starts)
    for part in prange(parts):
        for k in range(part * n // parts, (part + 1) * n // parts):
            i = order[k]
            ordered[starts[part, keys[i]]] = i
            starts[part, keys[i]] += 1


@compiled
def _counts_to_starts(counts: Ints) -> None:
    """In place, the number before each of (parts, bins): of all lower bins, and of the parts before it in its own."""
    total = 0
    for k in range(counts.shape[1]):
        for part in range(counts.shape[0]):
            count = counts[part, k]
            counts[part, k] = total
            total += count

"""Nested dissection: an order of the vertices in which the factors of a matrix of a mesh stay sparse."""

from __future__ import annotations

import math

import numpy as np

from ..compilation import compiled, prange
from ..execution import SERIAL_BELOW, threads_for
from ..mesh import Bools, Ints, Longs
from .conjugate_gradients import CompressedRows

#: Parts of at most this many vertices are not cut further.
_LEAF = 16
#: A separator that lies a share s of the part away from its middle counts as 1 + this times s of its size.
_UNEVEN = 0.5
#: Into so many parts a large graph is cut, which threads share.
PARTS = 8
#: Vertices with more neighbours than this times the root of the number of vertices come last: the levels around them are wide.
_HUB = 10.0


def dissected(matrix: CompressedRows) -> tuple[Ints, Longs, Longs]:
    """An order of the vertices, and the groups of which it consists: separators, and parts that are not cut further.

    The vertices are sorted by their distance in edges from one end of the graph. A separator, the vertices of a level near the
    middle that touch the next level, comes last in the order; the two sides come before it, each ordered in the same way
    [george1973]. On a surface the factors have about n log n entries. Written here because the orders by least degree that come
    with SuperLU take quadratic time on regular meshes; docs/solvers.md compares them.

    Returns:
        order: (n,) int32 a permutation.
        firsts: (groups + 1,) where in the order each group begins, ascending, and n.
        lows: (groups,) where the part begins that the group separates; for a part that is not cut, where it begins itself.
    """
    n = len(matrix.indptr) - 1
    hub = np.diff(matrix.indptr) > _HUB * math.sqrt(n)
    order = np.concatenate([np.flatnonzero(~hub), np.flatnonzero(hub)]).astype(np.int32)
    # Written at the last place of each group.
    firsts, lows = np.full(n, -1, dtype=np.int64), np.zeros(n, dtype=np.int64)
    if hub.any():
        firsts[-1] = n - int(hub.sum())
    inside = np.zeros(n, dtype=np.bool_)
    ranges = np.array([[0, n - int(hub.sum())]])
    if n >= SERIAL_BELOW:
        ranges = _dissect(matrix, order, firsts, lows, inside, PARTS, 0, n - int(hub.sum()))
    with threads_for(n):
        _dissect_all(matrix, order, firsts, lows, inside, ranges)
    ends = firsts >= 0
    return order, np.append(firsts[ends], n), lows[ends]


@compiled(parallel=True)
def _dissect_all(matrix: CompressedRows, order: Ints, firsts: Longs, lows: Longs, inside: Bools, ranges: Longs) -> None:
    """Cuts ranges of `order`, between which there are no edges, until nothing is left to cut."""
    for k in prange(ranges.shape[0]):
        _dissect(matrix, order, firsts, lows, inside, order.shape[0] + 1, ranges[k, 0], ranges[k, 1])


@compiled(nogil=True)
def _dissect(
    matrix: CompressedRows, order: Ints, firsts: Longs, lows: Longs, inside: Bools, most: int, begin: int, end: int
) -> Longs:
    """Cuts a range of `order` until nothing is left to cut, or there are at least `most`; returns those that are left, (k, 2)."""
    queue, bounds = np.empty(end - begin + 1, dtype=np.int32), np.empty(end - begin + 1, dtype=np.int32)
    waiting = [(begin, end)]
    done = 0
    while 0 < len(waiting) - done < most:
        low, high = waiting[done]
        done += 1
        if high - low <= _LEAF:
            if high > low:
                firsts[high - 1], lows[high - 1] = low, low
            continue
        for k in range(low, high):
            inside[order[k]] = True
        reached = bounds[_levels(matrix, order[low], inside, queue, bounds)]
        if reached < high - low:
            # It is not connected: each of its components is a part.
            waiting.append((low, low + reached))
            for k in range(low, high):
                if inside[order[k]]:
                    start = reached
                    reached += bounds[_levels(matrix, order[k], inside, queue[start:], bounds)]
                    waiting.append((low + start, low + reached))
            order[low:high] = queue[:reached]
            continue
        for k in range(reached):
            inside[queue[k]] = True
        # Levels counted from the vertex that is farthest from any other are many and narrow.
        depth = _levels(matrix, queue[reached - 1], inside, queue, bounds)
        front, back = _cut(matrix, order[low:high], inside, queue, bounds, depth)
        firsts[high - 1], lows[high - 1] = low + back, low
        if back > 0:
            waiting.append((low, low + front))
            waiting.append((low + front, low + back))
    left = np.empty((len(waiting) - done, 2), dtype=np.int64)
    for k in range(left.shape[0]):
        left[k] = waiting[done + k]
    return left


@compiled(nogil=True)
def _levels(matrix: CompressedRows, first: int, inside: Bools, queue: Ints, bounds: Ints) -> int:
    """Moves the vertices connected with `first` into `queue` by levels of distance, which begin at `bounds`; their number."""
    queue[0], bounds[0], inside[first] = first, 0, False
    depth, end = 0, 1
    while bounds[depth] < end:
        depth += 1
        bounds[depth] = end
        for now in range(bounds[depth - 1], end):
            i = np.uint32(queue[now])  # for signed numbers the compiler adds the test whether they count from the end
            for p in range(matrix.indptr[i], matrix.indptr[i + np.uint32(1)]):
                j = np.uint32(matrix.indices[p])
                queue[end] = j  # overwritten if it is not inside: a branch would be unpredictable
                end += inside[j]
                inside[j] = False
    return depth


@compiled(nogil=True)
def _cut(matrix: CompressedRows, order: Ints, inside: Bools, queue: Ints, bounds: Ints, depth: int) -> tuple[int, int]:
    """Puts the near side of a part first, then the far side, then its separator; returns where these two begin.

    The separator are the vertices that touch the far side of the narrowest level among those that leave at least a third of the
    part on either side, or among all if none does. A part of two levels stays whole.
    """
    count = order.shape[0]
    if depth < 3:
        return 0, 0
    middle, least = 0, np.inf
    for k in range(depth - 1):
        share = bounds[k + 1] / count
        cost = (bounds[k + 1] - bounds[k]) * (1.0 + _UNEVEN * abs(share - 0.5))
        if min(share, 1.0 - share) < 1.0 / 3.0:
            cost += count
        if cost < least:
            middle, least = k, cost
    start, far = bounds[middle], bounds[middle + 1]
    for k in range(far, bounds[middle + 2]):
        inside[queue[k]] = True
    order[:start] = queue[:start]
    front, back = start, count
    for k in range(start, far):
        i = queue[k]
        touches = False
        for p in range(matrix.indptr[i], matrix.indptr[i + 1]):
            touches |= inside[np.uint32(matrix.indices[p])]
        if touches:
            back -= 1
            order[back] = i
        else:
            order[front] = i
            front += 1
    for k in range(far, bounds[middle + 2]):
        inside[queue[k]] = False
    order[front:back] = queue[far:count]
    return front, back

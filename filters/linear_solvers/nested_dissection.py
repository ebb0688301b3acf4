"""Nested dissection: an order of the vertices in which the factors of a matrix of a mesh stay sparse."""

from __future__ import annotations

import math

import numpy as np

from ..compilation import compiled, prange
from ..execution import SERIAL_BELOW, threads_for
from ..mesh import Ints, Longs
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

    Args:
        matrix: (n, n) with a symmetric pattern.

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
    part, level, queue = np.where(hub, -1, 0), np.full(n, -1, dtype=np.int32), np.empty(n, dtype=np.int32)
    ranges = np.array([[0, n - int(hub.sum())]])
    if n >= SERIAL_BELOW:
        ranges = _dissect(matrix, order, part, firsts, lows, level, queue, PARTS, ranges)
    with threads_for(n):
        _dissect_all(matrix, order, part, firsts, lows, level, queue, ranges)
    ends = firsts >= 0
    return order, np.append(firsts[ends], n), lows[ends]


@compiled(nogil=True)
def _levels(matrix: CompressedRows, part: Longs, name: int, first: int, level: Ints, queue: Ints, at: int) -> int:
    """Writes the vertices of a part, by their distance from `first`, into `queue` from `at` on; returns its end.

    `level` is -1 at all vertices of the part before the call, and their distance in edges after it.
    """
    queue[at] = first
    level[first] = 0
    now, end = at, at + 1
    while now < end:
        i = queue[now]
        now += 1
        for p in range(matrix.indptr[i], matrix.indptr[i + 1]):
            j = matrix.indices[p]
            if part[j] == name and level[j] < 0:
                level[j] = level[i] + 1
                queue[end] = j
                end += 1
    return end


@compiled(parallel=True)
def _dissect_all(
    matrix: CompressedRows, order: Ints, part: Longs, firsts: Longs, lows: Longs, level: Ints, queue: Ints, ranges: Longs
) -> None:
    """Cuts ranges of `order` until nothing is left to cut."""
    for k in prange(ranges.shape[0]):
        _dissect(matrix, order, part, firsts, lows, level, queue, order.shape[0] + 1, ranges[k : k + 1])


@compiled(nogil=True)
def _dissect(
    matrix: CompressedRows,
    order: Ints,
    part: Longs,
    firsts: Longs,
    lows: Longs,
    level: Ints,
    queue: Ints,
    most: int,
    ranges: Longs,
) -> Longs:
    """Cuts ranges of `order` until nothing is left to cut, or there are at least `most`; returns those that are left, (k, 2).

    `part` is the number of each vertex's part, the beginning of its range plus 1.
    """
    stack = [(ranges[k, 0], ranges[k, 1]) for k in range(ranges.shape[0])]
    while 0 < len(stack) < most:
        low, high = stack.pop(0)
        if high - low <= _LEAF:
            if high > low:
                firsts[high - 1], lows[high - 1] = low, low
            continue
        for k in range(low, high):
            part[order[k]] = low + 1
        end = _levels(matrix, part, low + 1, order[low], level, queue, low)
        if end < high:
            # It is not connected: each of its components is a part.
            stack.append((low, end))
            for k in range(low, high):
                if level[order[k]] < 0:
                    begin, end = end, _levels(matrix, part, low + 1, order[k], level, queue, end)
                    stack.append((begin, end))
            order[low:high] = queue[low:high]
            front = back = low
        else:
            # Levels counted from the vertex that is farthest from any other are many and narrow.
            far = queue[end - 1]
            for k in range(low, high):
                level[queue[k]] = -1
            _levels(matrix, part, low + 1, far, level, queue, low)
            front, back = _cut(matrix, order, part, level, queue, low, high)
            firsts[high - 1], lows[high - 1] = back, low
        for k in range(low, high):
            level[order[k]] = -1
            part[order[k]] = 0
        if back > low:
            stack.append((low, front))
            stack.append((front, back))
    left = np.empty((len(stack), 2), dtype=np.int64)
    for k, (low, high) in enumerate(stack):
        left[k] = low, high
    return left


@compiled(nogil=True)
def _cut(matrix: CompressedRows, order: Ints, part: Longs, level: Ints, queue: Ints, low: int, high: int) -> tuple[int, int]:
    """Puts the near side of a part first, then the far side, then its separator; returns where these two begin.

    The separator are the vertices that touch the far side of the narrowest level among those that leave at least a third of the
    part on either side, or among all if none does. A part of two levels stays whole.
    """
    depth = level[queue[high - 1]] + 1
    if depth < 3:
        return low, low
    middle, least, begin = 0, np.inf, low
    for k in range(low, high):
        if level[queue[k]] == depth - 1:
            break
        if level[queue[k + 1]] > level[queue[k]]:
            share = (k + 1 - low) / (high - low)
            cost = (k + 1 - begin) * (1.0 + _UNEVEN * abs(share - 0.5))
            if min(share, 1.0 - share) < 1.0 / 3.0:
                cost += high - low
            if cost < least:
                middle, least = level[queue[k]], cost
            begin = k + 1
    front, count = low, 0
    for k in range(low, high):
        i = queue[k]
        touches = False
        if level[i] == middle:
            for p in range(matrix.indptr[i], matrix.indptr[i + 1]):
                j = matrix.indices[p]
                if part[j] == low + 1 and level[j] == middle + 1:
                    touches = True
                    break
        if touches:
            order[high - 1 - count] = i
            count += 1
        elif level[i] <= middle:
            order[front] = i
            front += 1
    back = front
    for k in range(low, high):
        if level[queue[k]] > middle:
            order[back] = queue[k]
            back += 1
    return front, back

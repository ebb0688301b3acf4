"""Nested dissection: an elimination order that keeps the factors of a mesh's matrix sparse."""

from __future__ import annotations

import math

import numpy as np

from ..compilation import compiled, prange
from ..execution import SERIAL_BELOW, threads_for
from ..mesh import Bools, Ints, Longs
from .conjugate_gradients import CompressedRows

#: Parts of at most this many vertices are not cut further.
_LEAF = 16
#: In `_cut` a level costs its size times 1 + `_UNEVEN` |s - 1/2|; s is the share of the part's vertices up to the level's end.
_UNEVEN = 0.5
#: A large graph is first cut into at least this many parts, which threads share.
PARTS = 8
#: A vertex with more than `_HUB` sqrt(n) neighbours is a hub. Hubs come last in the order: the levels around them are wide.
_HUB = 10.0


def dissected(matrix: CompressedRows) -> tuple[Ints, Longs, Longs]:
    """Returns an elimination order of the vertices, and its groups: uncut parts and separators. Hubs form the last separator.

    Vertices are sorted into levels by their distance in edges from one end of the graph. The separator is the set of vertices of
    a middle level that touch the next level. It comes last in the order; the two sides come first, each ordered in the same way
    [george1973]. On a surface the factors have about n log n entries. SuperLU's minimum degree orders take quadratic time on
    regular meshes; docs/solvers.md compares the times.

    Returns:
        order: (n,) int32 a permutation.
        firsts: (groups + 1,) the place of each group's first vertex in the order, ascending; the last entry is n.
        lows: (groups,) for a separator, the place where the part that it cuts begins; for an uncut part, the same as in `firsts`.
    """
    n = len(matrix.indptr) - 1
    hub = np.diff(matrix.indptr) > _HUB * math.sqrt(n)
    order = np.concatenate([np.flatnonzero(~hub), np.flatnonzero(hub)]).astype(np.int32)
    # Until the return, the values of a group stand at the place of its last vertex.
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
    """Cuts a range of `order` until no parts or at least `most` parts are left to cut; returns their ranges, (k, 2)."""
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
            # Each component of the range becomes a part.
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
        # Levels counted from a vertex at the end of the graph are many and narrow.
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
    """Moves the component of `first` into `queue`, sorted by levels that begin at `bounds`; returns the number of levels."""
    queue[0], bounds[0], inside[first] = first, 0, False
    depth, end = 0, 1
    while bounds[depth] < end:
        depth += 1
        bounds[depth] = end
        for now in range(bounds[depth - 1], end):
            i = np.uint32(queue[now])  # unsigned: the compiler would test a signed index for being negative
            for p in range(matrix.indptr[i], matrix.indptr[i + np.uint32(1)]):
                j = np.uint32(matrix.indices[p])
                queue[end] = j  # if j is not inside, the next entry overwrites it; this avoids an unpredictable branch
                end += inside[j]
                inside[j] = False
    return depth


@compiled(nogil=True)
def _cut(matrix: CompressedRows, order: Ints, inside: Bools, queue: Ints, bounds: Ints, depth: int) -> tuple[int, int]:
    """Reorders a part: near side, far side, separator; returns where the far side and the separator begin.

    The separator lies in the cheapest level that ends between one and two thirds of the part; if no level does, in the cheapest
    of all. It is the set of the level's vertices that touch the far side. A part of one or two levels stays whole.
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

"""Nested dissection: an order of the vertices in which the factors of a matrix of a mesh stay sparse."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..compilation import compiled
from ..libraries import sparse
from ..mesh import Ints, Longs

#: Parts of at most this many vertices are not cut further.
_LEAF = 48
#: A separator that lies a share s of the part away from its middle counts as 1 + this times s of its size.
_UNEVEN = 0.5


def nested_dissection(matrix: sparse.csc_matrix) -> Ints:
    """(n,) int32 a permutation: row i of the matrix to factorise is row ``order[i]`` of this one.

    The vertices are sorted by their distance in edges from one end of the graph. A separator, the vertices of a level near the
    middle that touch the next level, comes last in the order; the two sides come before it, each ordered in the same way
    [george1973]. On a surface the factors have about n log n entries. Written here because the orders by least degree that come
    with SuperLU take quadratic time on regular meshes; docs/solvers.md compares them.

    Args:
        matrix: (n, n) with a symmetric pattern.
    """
    n = matrix.shape[0]
    order = np.arange(n, dtype=np.int32)
    dissect: Any = _dissect
    dissect(matrix.indptr.astype(np.int64), matrix.indices.astype(np.int32), order, np.zeros(n, dtype=np.int64), _LEAF)
    return order


@compiled
def _levels(
    starts: Longs, neighbours: Ints, part: Longs, name: int, first: int, level: Ints, queue: Ints, at: int
) -> tuple[int, int]:
    """Writes the vertices of a part, by their distance from `first`, into `queue` from `at` on; returns its end and their levels.

    `level` is -1 at all vertices of the part before the call, and their distance in edges after it.
    """
    queue[at] = first
    level[first] = 0
    now, end = at, at + 1
    while now < end:
        i = queue[now]
        now += 1
        for p in range(starts[i], starts[i + 1]):
            j = neighbours[p]
            if part[j] == name and level[j] < 0:
                level[j] = level[i] + 1
                queue[end] = j
                end += 1
    return end, level[queue[end - 1]] + 1


@compiled
def _dissect(starts: Longs, neighbours: Ints, order: Ints, part: Longs, leaf: int) -> None:
    """Cuts ``order[low:high]`` for every part on the stack; `part` is the number of each vertex's part, its `low` plus 1."""
    n = order.shape[0]
    level = np.full(n, -1, dtype=np.int32)
    queue = np.empty(n, dtype=np.int32)
    stack = [(0, n)]
    while len(stack) > 0:
        low, high = stack.pop()
        if high - low <= leaf:
            continue
        name = low + 1
        for k in range(low, high):
            part[order[k]] = name
        # Levels counted from the vertex that is farthest from any other are many and narrow.
        end, _ = _levels(starts, neighbours, part, name, order[low], level, queue, low)
        far = queue[end - 1]
        for k in range(low, end):
            level[queue[k]] = -1
        end, depth = _levels(starts, neighbours, part, name, far, level, queue, low)
        if end < high:
            # The part is not connected: split it into the vertices that were reached and the others.
            rest = end
            for k in range(low, high):
                i = order[k]
                if level[i] < 0:
                    queue[rest] = i
                    rest += 1
            order[low:high] = queue[low:high]
            for k in range(low, end):
                level[order[k]] = -1
            for k in range(low, high):
                part[order[k]] = 0
            stack.append((low, end))
            stack.append((end, high))
            continue
        if depth < 3:
            for k in range(low, high):
                level[order[k]] = -1
                part[order[k]] = 0
            continue
        # The narrowest level among those that leave at least a third of the part on either side, or among all if none does.
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
        # The near side first, then the far side, then the separator: the vertices of the middle level that touch the far side.
        front, back, count = low, 0, 0
        for k in range(low, high):
            i = queue[k]
            touches = False
            if level[i] == middle:
                for p in range(starts[i], starts[i + 1]):
                    j = neighbours[p]
                    if part[j] == name and level[j] == middle + 1:
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
            i = queue[k]
            if level[i] > middle:
                order[back] = i
                back += 1
        for k in range(low, high):
            level[queue[k]] = -1
            part[queue[k]] = 0
        stack.append((low, front))
        stack.append((front, back))

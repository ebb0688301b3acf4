"""The k nearest neighbours of all points of a k-d tree, searched for all points of a leaf at once.

One walk down the tree serves the whole leaf, a point is compared with a leaf in vector instructions, and points that are close in
space are close in memory. Each point of the leaf collects candidates within its bound, the distance of its k-th nearest so far;
when there are too many, the k nearest stay and the bound shrinks.

Points are ordered by computed squared distance, then by index. The computed distance of a box never exceeds that of a point in
it, because rounding is monotonic and both sums have the same order. So the answer is exact, also among ties, and does not depend
on the walk.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..compilation import compiled
from ..mesh import Floats, Ints, Longs
from .kd_tree import LEAF, STACK, KdTree
from .selection import ANY_INDEX, FAR, keep_nearest


def search_leaves(tree: KdTree, first: int, last: int, k: int) -> tuple[Ints, Floats]:
    """The k < n nearest other points of every point in the leaves from `first` to before `last`.

    Returns:
        (rows, k) positions and (rows, k) squared distances in the tree's scale, each row in no particular but a fixed order.
    """
    rows = min(last * LEAF, tree.count) - first * LEAF
    positions: Ints = np.empty((rows, k), np.int32)
    squared: Floats = np.empty((rows, k))
    _search(tree.coordinates, tree.indices, tree.boxes, tree.lowest, first, positions, squared)
    return positions, squared


@compiled(nogil=True)
def _search(
    coordinates: Floats,
    indices: Ints,
    boxes: Floats,
    lowest: Longs,
    first: int,
    positions: Ints,
    squared: Floats,
) -> None:
    rows, k = positions.shape
    found = np.empty((LEAF, 2 * k + LEAF))
    found_at = np.empty((LEAF, 2 * k + LEAF), np.int32)
    counts = np.empty(LEAF, np.int64)
    bounds = np.empty(LEAF)
    ties = np.empty(LEAF, np.int64)
    state = found, found_at, counts, bounds, ties, np.empty(LEAF), np.empty(LEAF)
    stack = np.empty((STACK, 3), np.int64)
    stack_gaps = np.empty(STACK)
    box = np.empty((2, 3))
    for leaf in range(first, first + (rows + LEAF - 1) // LEAF):
        start = (leaf - first) * LEAF
        asking = min(LEAF, rows - start)
        for d in range(3):
            box[0, d] = coordinates[leaf, d, :asking].min()
            box[1, d] = coordinates[leaf, d, :asking].max()
        counts[:], bounds[:], ties[:] = 0, FAR, ANY_INDEX
        bound, tie = FAR, ANY_INDEX  # the largest of the leaf
        stack[0, 0], stack[0, 1], stack[0, 2], stack_gaps[0] = 1, 0, coordinates.shape[0], 0.0
        top = 1
        while top > 0:
            top -= 1
            node, a, b, gap = stack[top, 0], stack[top, 1], stack[top, 2], stack_gaps[top]
            # Down to the nearest leaf; the farther child of every node goes onto the stack. If all points coincide the left child
            # has the lower indices.
            while b - a > 1 and _within(gap, lowest[node], bound, tie):
                middle = (a + b) // 2
                left_gap, right_gap = _gap(box, boxes[2 * node]), _gap(box, boxes[2 * node + 1])
                if left_gap <= right_gap:
                    stack[top, 0], stack[top, 1], stack[top, 2], stack_gaps[top] = 2 * node + 1, middle, b, right_gap
                    node, b, gap = 2 * node, middle, left_gap
                else:
                    stack[top, 0], stack[top, 1], stack[top, 2], stack_gaps[top] = 2 * node, a, middle, left_gap
                    node, a, gap = 2 * node + 1, middle, right_gap
                top += 1
            if _within(gap, lowest[node], bound, tie) and _offer(
                coordinates, indices, boxes[node], lowest[node], leaf, asking, a, k, state
            ):
                bound, tie = 0.0, 0
                for q in range(asking):
                    if bounds[q] > bound or (bounds[q] == bound and ties[q] > tie):
                        bound, tie = bounds[q], ties[q]
        for q in range(asking):
            keep_nearest(found[q], found_at[q], counts[q], k, bounds[q], indices)
            for i in range(k):
                squared[start + q, i], positions[start + q, i] = found[q, i], found_at[q, i]


@compiled(nogil=True)
def _offer(
    coordinates: Floats,
    indices: Ints,
    box: Floats,
    lowest: int,
    leaf: int,
    asking: int,
    other: int,
    k: int,
    state: tuple[Any, ...],
) -> bool:
    """Adds the points of another leaf, with its box, to the candidates of the asking leaf; returns whether a bound has shrunk."""
    found, found_at, counts, bounds, ties, gaps, distances = state
    shrunk = False
    gaps[:] = 0.0
    for d in range(3):
        for q in range(LEAF):
            outside = max(max(box[0, d] - coordinates[leaf, d, q], coordinates[leaf, d, q] - box[1, d]), 0.0)
            gaps[q] += outside * outside
    for q in range(asking):
        if not _within(gaps[q], lowest, bounds[q], ties[q]):
            continue
        x, y, z = coordinates[leaf, 0, q], coordinates[leaf, 1, q], coordinates[leaf, 2, q]
        for i in range(LEAF):
            dx, dy, dz = coordinates[other, 0, i] - x, coordinates[other, 1, i] - y, coordinates[other, 2, i] - z
            distances[i] = dx * dx + dy * dy + dz * dz
        if other == leaf:
            distances[q] = np.inf  # a point is no neighbour of itself
        count = counts[q]
        for i in range(LEAF):
            found[q, count], found_at[q, count] = distances[i], other * LEAF + i
            count += 1 if distances[i] <= bounds[q] else 0  # no branch to predict
        if count > 2 * k:
            bounds[q], ties[q] = keep_nearest(found[q], found_at[q], count, k, bounds[q], indices)
            count = k
            shrunk = True
        counts[q] = count
    return shrunk


@compiled(nogil=True)
def _within(gap: float, lowest: int, bound: float, tie: int) -> bool:
    """Whether a box at the squared distance `gap`, with that lowest index, can hold a candidate."""
    return gap < bound or (gap == bound and lowest < tie)


@compiled(nogil=True)
def _gap(one: Floats, other: Floats) -> float:
    """The squared distance between two boxes."""
    total = 0.0
    for d in range(3):
        outside = max(max(other[0, d] - one[1, d], one[0, d] - other[1, d]), 0.0)
        total += outside * outside
    return total

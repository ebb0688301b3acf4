"""The k nearest neighbours of all points of a k-d tree, the points of a leaf asking together.

One walk down the tree serves the whole leaf, a point is compared with a leaf in vector instructions, and near points lie near in
memory. Each asking point gathers candidates within its bound, the distance beyond which it has enough; when there are too many,
the k nearest stay and the bound shrinks.

Points are ordered by computed squared distance, then by index. No box is computed to be farther than a point in it, because
rounding is monotonic and both sums have the same order; so the answer is exact, also among ties, and independent of the walk.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .kd_tree import LEAF, STACK, KdTree

#: beyond any squared distance of a tree's coordinates, and below the infinity of a point to itself
_FAR = 1e300
_ANY_INDEX = 2**62
#: guesses at a threshold before the exact selection takes over: ties never let a guess succeed
_GUESSES = 6


def search(tree: KdTree, first: int, last: int, k: int) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """The k < n nearest other points of every point in the leaves from `first` to before `last`.

    Returns:
        (rows, k) positions and (rows, k) squared distances in the tree's scale, each row in no particular but a fixed order.
    """
    rows = min(last * LEAF, tree.count) - first * LEAF
    positions: NDArray[np.int32] = np.empty((rows, k), np.int32)
    squared: NDArray[np.float64] = np.empty((rows, k))
    _search(tree.coordinates, tree.indices, tree.boxes, tree.lowest, first, positions, squared)
    return positions, squared


@njit(nogil=True, cache=True)
def _search(
    coordinates: NDArray[np.float64],
    indices: NDArray[np.int32],
    boxes: NDArray[np.float64],
    lowest: NDArray[np.int64],
    first: int,
    positions: NDArray[np.int32],
    squared: NDArray[np.float64],
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
        counts[:], bounds[:], ties[:] = 0, _FAR, _ANY_INDEX
        bound, tie = _FAR, _ANY_INDEX  # of the point that still looks farthest
        stack[0, 0], stack[0, 1], stack[0, 2], stack_gaps[0] = 1, 0, coordinates.shape[0], 0.0
        top = 1
        while top > 0:
            top -= 1
            node, a, b, gap = stack[top, 0], stack[top, 1], stack[top, 2], stack_gaps[top]
            # Down to the nearest leaf, with the farther child of every node put aside. The left one has the lower indices if
            # all points coincide.
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
            _keep_nearest(found[q], found_at[q], counts[q], k, bounds[q], indices)
            for i in range(k):
                squared[start + q, i], positions[start + q, i] = found[q, i], found_at[q, i]


@njit(nogil=True, cache=True)
def _offer(
    coordinates: NDArray[np.float64],
    indices: NDArray[np.int32],
    box: NDArray[np.float64],
    lowest: int,
    leaf: int,
    asking: int,
    other: int,
    k: int,
    state: tuple[NDArray[Any], ...],
) -> bool:
    """Offer the points of another leaf, with its box, to those of the asking leaf; whether a bound has shrunk."""
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
            bounds[q], ties[q] = _keep_nearest(found[q], found_at[q], count, k, bounds[q], indices)
            count = k
            shrunk = True
        counts[q] = count
    return shrunk


@njit(nogil=True, cache=True)
def _within(gap: float, lowest: int, bound: float, tie: int) -> bool:
    """Whether a box that far away, with that lowest index, can have a candidate."""
    return gap < bound or (gap == bound and lowest < tie)


@njit(nogil=True, cache=True)
def _gap(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """The squared distance between two boxes."""
    total = 0.0
    for d in range(3):
        outside = max(max(other[0, d] - one[1, d], one[0, d] - other[1, d]), 0.0)
        total += outside * outside
    return total


@njit(nogil=True, cache=True)
def _keep_nearest(
    found: NDArray[np.float64], found_at: NDArray[np.int32], count: int, k: int, bound: float, indices: NDArray[np.int32]
) -> tuple[float, int]:
    """Move the k nearest of `count` candidates to the front; their bound and the index below which a tie is still of interest."""
    if count == k:
        return bound, _ANY_INDEX
    # Guess a distance that k candidates do not exceed, as if they were spread evenly: counting is faster than sorting.
    low, high = 0.0, bound
    n_low, n_high = 0, count
    if bound == _FAR:
        high = 0.0
        for i in range(count):
            high = found[i] if found[i] > high else high
    for _ in range(_GUESSES):
        guess = low + (high - low) * ((k - n_low) / (n_high - n_low))
        n = 0
        for i in range(count):
            n += 1 if found[i] <= guess else 0
        if n in (n_low, n_high):
            break  # probably ties
        if n > k:
            high, n_high = guess, n
        else:
            low, n_low = guess, n
        if n == k:
            break
    if n_low == k:
        _move_to_front(found, found_at, count, low)
        return low, _ANY_INDEX
    _move_to_front(found, found_at, count, high)
    if n_low > 0:
        _move_to_front(found, found_at, n_high, low)
    _select(found, found_at, n_low, n_high, k - 1, indices)
    return found[k - 1], int(indices[found_at[k - 1]])


@njit(nogil=True, cache=True)
def _move_to_front(found: NDArray[np.float64], found_at: NDArray[np.int32], count: int, limit: float) -> None:
    """Move the candidates up to a distance to the front, without a branch."""
    front = 0
    for i in range(count):
        distance, at = found[i], found_at[i]
        found[i], found_at[i] = found[front], found_at[front]
        found[front], found_at[front] = distance, at
        front += 1 if distance <= limit else 0


@njit(nogil=True, cache=True)
def _select(
    found: NDArray[np.float64], found_at: NDArray[np.int32], low: int, high: int, middle: int, indices: NDArray[np.int32]
) -> None:
    """Move the nearer ones of the candidates from `low` to before `high` before the `middle` (Hoare's selection)."""
    high -= 1
    while low < high:
        pivot = found[(low + high) // 2]
        pivot_index = indices[found_at[(low + high) // 2]]
        i, j = low, high
        while i <= j:
            while found[i] < pivot or (found[i] == pivot and indices[found_at[i]] < pivot_index):
                i += 1
            while found[j] > pivot or (found[j] == pivot and indices[found_at[j]] > pivot_index):
                j -= 1
            if i <= j:
                found[i], found[j] = found[j], found[i]
                found_at[i], found_at[j] = found_at[j], found_at[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return

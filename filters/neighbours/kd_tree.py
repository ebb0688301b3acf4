"""A balanced k-d tree [friedman1977] of the points of a cloud, built on all cores.

Written here because SciPy's and pykdtree's do not order ties and are slower; docs/solvers.md has the times.

A node's points are halved at the median of the widest side of their bounding box, down to leaves of `LEAF` points, so that the
tree adapts to any density. Node 1 is the root, the children of node i are 2 i and 2 i + 1. A node covers a range of leaves, its
children the two halves of that range, and every leaf but the last is full.
"""

from functools import partial
from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..execution import Progress, in_parallel, part_of
from ..mesh import Floats, Ints, Longs

#: Points in a leaf, compiled into the kernels: 8 and 32 are slower.
LEAF = 16
#: Leaves of a subtree that one task builds.
_SUBTREE = 4096
#: Deep enough for any walk down a tree of 2^31 points.
STACK = 64
#: The column of the index, which a float64 holds exactly.
_INDEX = 3
#: Beyond any squared distance of a tree's coordinates, and below the infinite distance of a point to itself.
FAR = 1e300
#: Above every index, so that every tie counts.
ANY_INDEX = 2**62
#: Guesses at a threshold before an exact selection: with ties no guess succeeds.
_GUESSES = 6


class KdTree(NamedTuple):
    """The points in the order of the tree; a "position" counts in that order, an "index" in the caller's."""

    size: int  # the number of points n
    # the power of two by which the caller's coordinates are divided, so that no squared distance overflows or vanishes
    scale: float
    coordinates: Floats  # (leaves, 3, LEAF), NaN after the last point
    indices: Ints  # (leaves * LEAF,) the index of the point at each position
    boxes: Floats  # (nodes, 2, 3) the lowest and the highest coordinates of each node's points
    lowest: Longs  # (nodes,) the smallest index of each node's points


def tree_scale(largest: float) -> float:
    """The power of two above the largest coordinate's size, by which a tree divides the coordinates."""
    exponent = np.frexp(largest)[1]
    return float(2.0 ** min(max(int(exponent), -1000), 1000))


def build_tree(points: Floats, progress: Progress, *, scale: float | None = None) -> KdTree:
    """The tree of finite points, at least one; the same for any number of threads.

    Of a part of a cloud the scale is the `tree_scale` of the whole.
    """
    count = len(points)
    leaves = -(-count // LEAF)
    if scale is None:
        scale = tree_scale(max(points.max(), -points.min()))
    rows = np.full((leaves * LEAF, 4), np.nan)
    np.multiply(points, 1.0 / scale, out=rows[:count, :3])
    rows[:, _INDEX] = np.arange(len(rows))
    nodes = 2 << (leaves - 1).bit_length()
    boxes: Floats = np.empty((nodes, 2, 3))
    lowest: Longs = np.empty(nodes, np.int64)

    split = partial(_split_node, rows[:count], LEAF, boxes, lowest)
    build = partial(split_nodes, rows[:count], LEAF, boxes, lowest)
    # The nodes of a level are independent. The upper levels are split one after the other, each subtree below them is one task.
    level = [(1, 0, leaves)]
    depth = ((leaves - 1) // _SUBTREE).bit_length()
    for above in range(depth):
        in_parallel(split, level, part_of(progress, above / (depth + 1), (above + 1) / (depth + 1)))
        halves = [(node, first, (first + last) // 2, last) for node, first, last in level]
        level = [part for i, a, b, c in halves for part in ((2 * i, a, b), (2 * i + 1, b, c))]
    if depth > 0:
        in_parallel(build, level, part_of(progress, depth / (depth + 1), 1.0))
    else:
        build(*level[0])  # faster than to start a thread
        progress(1.0)
    coordinates = np.ascontiguousarray(rows[:, :3].reshape(leaves, LEAF, 3).transpose(0, 2, 1))
    return KdTree(count, scale, coordinates, rows[:, _INDEX].astype(np.int32), boxes, lowest)


@compiled(nogil=True)
def split_nodes(rows: Floats, leaf: int, boxes: Floats, lowest: Longs, node: int, first: int, last: int) -> None:
    """Splits a node, which covers the leaves from `first` to before `last`, and all nodes below it, in place.

    The (n, 4) rows, coordinates and indices, `leaf` of them in a leaf, are put into the order of the tree; (nodes, 2, 3) `boxes`
    get the lowest and the highest coordinates of each node's rows, (nodes,) `lowest` their smallest index.
    """
    stack = np.empty((STACK, 3), np.int64)
    stack[0, 0], stack[0, 1], stack[0, 2] = node, first, last
    top = 1
    while top > 0:
        top -= 1
        node, first, last = stack[top, 0], stack[top, 1], stack[top, 2]
        _split_node(rows, leaf, boxes, lowest, node, first, last)
        if last - first > 1:
            middle = (first + last) // 2
            stack[top, 0], stack[top, 1], stack[top, 2] = 2 * node, first, middle
            stack[top + 1, 0], stack[top + 1, 1], stack[top + 1, 2] = 2 * node + 1, middle, last
            top += 2


@compiled(nogil=True)
def _split_node(rows: Floats, leaf: int, boxes: Floats, lowest: Longs, node: int, first: int, last: int) -> None:
    """Computes the box of one node and moves its points so that those of its first half of leaves come first."""
    start, stop = first * leaf, min(last * leaf, rows.shape[0])
    low = rows[start].copy()
    high = rows[start].copy()
    for r in range(start + 1, stop):
        for c in range(4):
            value = rows[r, c]
            low[c] = value if value < low[c] else low[c]
            high[c] = value if value > high[c] else high[c]
    axis = 0
    for c in range(3):
        boxes[node, 0, c], boxes[node, 1, c] = low[c], high[c]
        axis = c if high[c] - low[c] > high[axis] - low[axis] else axis
    lowest[node] = np.int64(low[_INDEX])
    if last - first > 1:
        # Points that all coincide are halved by index, so that a search finds the lowest ones first and can stop there.
        _partition(rows, start, stop, (first + last) // 2 * leaf, axis if high[axis] > low[axis] else _INDEX)


@compiled(nogil=True)
def _partition(rows: Floats, start: int, stop: int, middle: int, column: int) -> None:
    """Moves the rows from `start` to before `stop` so that none before `middle` is above one after it."""
    low, high = start, stop - 1
    seed = np.uint64(start + stop)
    while low < high:
        # The median of three at pseudo-random places: the patterns in a scan's order make fixed places take quadratic time.
        seed = seed * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
        size = np.uint64(high - low + 1)
        a = rows[low + np.int64((seed >> np.uint64(43)) % size), column]
        b = rows[low + np.int64((seed >> np.uint64(22) & np.uint64(0x1FFFFF)) % size), column]
        c = rows[(low + high) // 2, column]
        pivot = max(min(a, b), min(max(a, b), c))
        i, j = low, high
        while i <= j:
            while rows[i, column] < pivot:
                i += 1
            while rows[j, column] > pivot:
                j -= 1
            if i <= j:
                for d in range(4):
                    rows[i, d], rows[j, d] = rows[j, d], rows[i, d]
                i += 1
                j -= 1
        low, high = _side_of_middle(low, high, i, j, middle)


@compiled(nogil=True)
def keep_nearest(
    near: Floats, at: Ints, q: int, count: int, k: int, most: int, bound: float, indices: Ints
) -> tuple[int, float, int]:
    """Moves the k nearest of the candidates of a point, or up to `most`, to the front.

    Returns:
        How many are kept, their bound, and the index below which a tie counts.
    """
    if count <= most:
        return count, bound, ANY_INDEX
    low, high = 0.0, bound
    n_low, n_high = 0, count
    if bound == FAR:
        high = _farthest(near, q, count)
    # Guess a distance as if all were spread evenly, and count: that is faster than sorting.
    for _ in range(_GUESSES):
        guess = low + (high - low) * ((0.5 * (k + most) - n_low) / (n_high - n_low))
        n = _count_within(near, q, count, guess)
        if k <= n <= most:
            _drop_beyond(near, at, q, count, guess)
            return n, guess, ANY_INDEX
        if n in (n_low, n_high):
            break  # probably ties
        if n > k:
            high, n_high = guess, n
        else:
            low, n_low = guess, n
    _drop_beyond(near, at, q, count, high)
    if n_low > 0:
        _move_to_front(near, at, q, n_high, low)
    _select(near, at, q, n_low, n_high, k - 1, indices)
    return k, near[q, k - 1], int(indices[at[q, k - 1]])


@compiled(nogil=True)
def _farthest(near: Floats, q: int, count: int) -> float:
    largest = 0.0
    for i in range(count):
        largest = near[q, i] if near[q, i] > largest else largest
    return largest


@compiled(nogil=True)
def _count_within(near: Floats, q: int, count: int, limit: float) -> int:
    n = 0
    for i in range(count):
        n += 1 if near[q, i] <= limit else 0
    return n


@compiled(nogil=True)
def _drop_beyond(near: Floats, at: Ints, q: int, count: int, limit: float) -> None:
    """Keeps the candidates up to a distance, without a branch."""
    front = np.uint64(0)
    for i in range(count):
        distance = near[q, i]
        near[q, front], at[q, front] = distance, at[q, i]
        front += np.uint64(distance <= limit)


@compiled(nogil=True)
def _move_to_front(near: Floats, at: Ints, q: int, count: int, limit: float) -> None:
    """Moves the candidates up to a distance before the others, without a branch."""
    front = np.uint64(0)
    for i in range(count):
        distance, position = near[q, i], at[q, i]
        near[q, i], at[q, i] = near[q, front], at[q, front]
        near[q, front], at[q, front] = distance, position
        front += np.uint64(distance <= limit)


@compiled(nogil=True)
def _select(near: Floats, at: Ints, q: int, low: int, high: int, middle: int, indices: Ints) -> None:
    """Moves the nearer ones of the candidates from `low` to before `high` to before the `middle`."""
    high -= 1
    while low < high:
        pivot = near[q, (low + high) // 2]
        pivot_index = indices[at[q, (low + high) // 2]]
        i, j = low, high
        while i <= j:
            while near[q, i] < pivot or (near[q, i] == pivot and indices[at[q, i]] < pivot_index):
                i += 1
            while near[q, j] > pivot or (near[q, j] == pivot and indices[at[q, j]] > pivot_index):
                j -= 1
            if i <= j:
                near[q, i], near[q, j] = near[q, j], near[q, i]
                at[q, i], at[q, j] = at[q, j], at[q, i]
                i += 1
                j -= 1
        low, high = _side_of_middle(low, high, i, j, middle)


@compiled(nogil=True)
def _side_of_middle(low: int, high: int, i: int, j: int, middle: int) -> tuple[int, int]:
    """The part that still has to be split around the `middle`, after a split into `low` to j and i to `high`; else no part."""
    if middle <= j:
        return low, j
    if middle >= i:
        return i, high
    return middle, middle

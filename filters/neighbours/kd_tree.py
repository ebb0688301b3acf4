"""Finds the exact nearest neighbours of each point of a cloud by a balanced k-d tree [friedman1977], built on all cores.

The trees of SciPy and pykdtree do not order points at the same distance and are slower; docs/solvers.md has the times.
The points of a node are halved at the median of the widest side of their bounding box, down to leaves of `LEAF` points. Node 1 is
the root, the children of node i are 2 i and 2 i + 1. A node covers a range of leaves, its children cover the two halves of the
range, and every leaf but the last is full.
"""

import math
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_whole_number
from ..compilation import compiled
from ..execution import Progress, ignore_progress, in_parallel, part_of
from ..mesh import Floats, Ints, Longs, check_points

#: Number of points in a leaf, a constant of the kernels: 8 and 32 points are slower.
LEAF = 16
#: The largest number of leaves in a subtree that one task builds.
_SUBTREE = 4096
#: Size of a stack for any traversal of a tree of 2^31 points.
STACK = 64
#: The column of the index; a float64 holds an index exactly.
_INDEX = 3
#: A finite number above all squared distances in a tree. The distance of a point from itself is set to infinity.
FAR = 1e300
#: The bound on indices that lets all pass. A search applies its bound on indices to points exactly at its bound on distance.
ANY_INDEX = 2**62
#: How many distances `keep_nearest` tries before it selects exactly: with equal distances every try may fail.
_GUESSES = 6
#: The approximate share of the whole time that building the tree takes.
_BUILDING = 0.2
#: The most neighbours that one task finds, in about 0.01 s; its arrays fit the cache.
_CHUNK = 2**18
#: The least number of tasks for a large cloud, so that threads end at about the same time.
_TASKS = 64
#: The fewest neighbours that one task finds, in half a millisecond, a hundred times the cost of starting a task.
_LEAST = 2**14
#: If a point has more than 2 k candidates, only the nearest k to k + k / `_MORE` are kept.
_MORE = 8


class KdTree(NamedTuple):
    """The points in the order of the tree. A "position" is a place in this order, an "index" a place in the caller's order."""

    size: int  # the number of points n
    # the caller's coordinates are divided by this power of two, so that squared distances neither overflow nor underflow
    scale: float
    coordinates: Floats  # (leaves, 3, LEAF), NaN after the last point
    indices: Ints  # (leaves * LEAF,) the index of the point at each position
    boxes: Floats  # (nodes, 2, 3) the lowest and the highest coordinates of each node's points
    lowest: Longs  # (nodes,) the smallest index of each node's points


def tree_scale(largest: float) -> float:
    """Returns the power of two (2^-1000 to 2^1000) above the largest absolute coordinate: a tree divides coordinates by it."""
    exponent = np.frexp(largest)[1]
    return float(2.0 ** min(max(int(exponent), -1000), 1000))


def build_tree(points: Floats, progress: Progress, *, scale: float | None = None) -> KdTree:
    """Returns the tree of finite points, at least one. It is the same for any number of threads.

    For a part of a cloud `scale` is the `tree_scale` of the whole cloud.
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
    # The upper levels are split one after the other; each subtree below them is one task.
    level = [(1, 0, leaves)]
    depth = ((leaves - 1) // _SUBTREE).bit_length()
    for above in range(depth):
        in_parallel(split, level, part_of(progress, above / (depth + 1), (above + 1) / (depth + 1)))
        halves = [(node, first, (first + last) // 2, last) for node, first, last in level]
        level = [part for i, a, b, c in halves for part in ((2 * i, a, b), (2 * i + 1, b, c))]
    if depth > 0:
        in_parallel(build, level, part_of(progress, depth / (depth + 1), 1.0))
    else:
        build(*level[0])  # faster than starting a thread
        progress(1.0)
    coordinates = np.ascontiguousarray(rows[:, :3].reshape(leaves, LEAF, 3).transpose(0, 2, 1))
    return KdTree(count, scale, coordinates, rows[:, _INDEX].astype(np.int32), boxes, lowest)


@compiled(nogil=True)
def split_nodes(rows: Floats, leaf: int, boxes: Floats, lowest: Longs, node: int, first: int, last: int) -> None:
    """Splits a node, which covers the leaves from `first` to before `last`, and all nodes below it, in place.

    It sorts the (n, 4) rows of coordinates and index into the order of the tree, `leaf` rows in a leaf. For `boxes` and `lowest`
    see `KdTree`.
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
    """Computes the box of a node and partitions its points between the first and the second half of its leaves."""
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
        # If all points coincide they are halved by index: a search then finds the lowest indices first and can stop.
        _partition(rows, start, stop, (first + last) // 2 * leaf, axis if high[axis] > low[axis] else _INDEX)


@compiled(nogil=True)
def _partition(rows: Floats, start: int, stop: int, middle: int, column: int) -> None:
    """Reorders the rows from `start` to before `stop`: values of `column` before row `middle` do not exceed later ones."""
    low, high = start, stop - 1
    seed = np.uint64(start + stop)
    while low < high:
        # The median of three rows, two of them pseudo-random: with fixed rows the order of a scan may lead to quadratic time.
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
    """Moves the nearest candidates, k to `most` of them, to the front; returns how many, and new bounds on distance and index."""
    if count <= most:
        return count, bound, ANY_INDEX
    low, high = 0.0, bound
    n_low, n_high = 0, count
    if bound == FAR:
        high = _farthest(near, q, count)
    # Guessing a distance, as if distances were evenly spread, and counting the candidates within it is faster than sorting.
    for _ in range(_GUESSES):
        guess = low + (high - low) * ((0.5 * (k + most) - n_low) / (n_high - n_low))
        n = _count_within(near, q, count, guess)
        if k <= n <= most:
            _drop_beyond(near, at, q, count, guess)
            return n, guess, ANY_INDEX
        if n in (n_low, n_high):
            break  # probably equal distances
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
    """Keeps the candidates within a distance, in a loop without branches."""
    front = np.uint64(0)
    for i in range(count):
        distance = near[q, i]
        near[q, front], at[q, front] = distance, at[q, i]
        front += np.uint64(distance <= limit)


@compiled(nogil=True)
def _move_to_front(near: Floats, at: Ints, q: int, count: int, limit: float) -> None:
    """Moves the candidates within a distance before the others, in a loop without branches."""
    front = np.uint64(0)
    for i in range(count):
        distance, position = near[q, i], at[q, i]
        near[q, i], at[q, i] = near[q, front], at[q, front]
        near[q, front], at[q, front] = distance, position
        front += np.uint64(distance <= limit)


@compiled(nogil=True)
def _select(near: Floats, at: Ints, q: int, low: int, high: int, middle: int, indices: Ints) -> None:
    """Partitions the candidates from `low` to before `high` at `middle`: nearer candidates come first."""
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
    """Returns which of the ranges `low` to j and i to `high` has the `middle`; an empty range if none has it."""
    if middle <= j:
        return low, j
    if middle >= i:
        return i, high
    return middle, middle


def nearest_neighbours(points: ArrayLike, k: int, *, progress: Progress = ignore_progress) -> tuple[Floats, Ints]:
    """Finds the k nearest neighbours of each point among all other points.

    The search is exact: neighbours are ordered by the squared distance as computed in float64, then by index. Only the point
    itself is excluded, so that another point at the same place is a neighbour at distance 0.

    Args:
        points: (n, 3) finite coordinates, in any unit and of any magnitude.
        k: the number of neighbours, at least 1 and below n. The time grows with k; for many hundreds of neighbours, with k^2.
        progress: called with the share of the work done.

    Returns:
        distances: (n, k) float64 in the unit of the points, ascending.
        indices: (n, k) int32.

    Raises:
        FilterInputError: k is out of its bounds, or coordinates are missing, NaN or infinite.
    """
    cloud, k = check_cloud(points, k)
    tree = build_tree(cloud, part_of(progress, 0.0, _BUILDING))
    distances: Floats = np.empty((tree.size, k))
    indices: Ints = np.empty((tree.size, k), np.int32)
    in_parallel(partial(_find, tree, indices, distances), leaf_ranges(tree, k), part_of(progress, _BUILDING, 1.0))
    return distances, indices


def check_cloud(points: ArrayLike, k: int, name: str = "k") -> tuple[Floats, int]:
    """Returns the points as (n, 3) float64, and k; refuses a cloud of k points or fewer."""
    cloud, k = check_points(points), check_whole_number(name, k, least=1)
    if k >= len(cloud):
        raise FilterInputError(
            f"{k} neighbours need a cloud of at least {k + 1} points, got {len(cloud)}: ask for fewer neighbours or add points"
        )
    return cloud, k


def leaf_ranges(tree: KdTree, k: int) -> list[tuple[int, int]]:
    """Returns the ranges of leaves, one for each task of a search."""
    leaves = len(tree.coordinates)
    size = max(1, min(_CHUNK // (k * LEAF), max(leaves // _TASKS, _LEAST // (k * LEAF))))
    return [(first, min(first + size, leaves)) for first in range(0, leaves, size)]


@compiled(nogil=True)
def _find(tree: KdTree, indices: Ints, distances: Floats, first: int, last: int) -> None:
    """Fills the rows of the points in the leaves from `first` to before `last`, leaf by leaf to save memory."""
    k = indices.shape[1]
    positions, squared = np.empty((LEAF, k), np.int32), np.empty((LEAF, k))
    for leaf in range(first, last):
        rows = min(LEAF, tree.size - leaf * LEAF)
        _search(tree, leaf, positions[:rows], squared[:rows])
        _sort_rows(tree.indices, leaf * LEAF, positions[:rows], squared[:rows], tree.scale, indices, distances)


@compiled(nogil=True)
def _sort_rows(
    index_at: Ints, start: int, positions: Ints, squared: Floats, scale: float, indices: Ints, distances: Floats
) -> None:
    """Writes the neighbours of each point, sorted by distance, then by index; `start` is the position of the first point."""
    k = positions.shape[1]
    keys, places = np.empty(k, np.float32), np.empty(k, np.int32)
    for r in range(positions.shape[0]):
        row = index_at[start + r]
        # The place of a neighbour is the number of nearer neighbours. Counting is vectorised and, for up to hundreds of
        # neighbours, faster than sorting; float32 doubles its speed. If some of the keys are equal, `_exact_places` counts.
        for i in range(k):
            keys[i] = squared[r, i]
        total = 0
        for i in range(k):
            place: Any = np.int32(0)
            for j in range(k):
                place = np.int32(place + np.int32(keys[j] < keys[i]))
            places[i] = place
            total += place
        if total != k * (k - 1) // 2:
            _exact_places(index_at, positions, squared, r, places)
        for i in range(k):
            distances[row, places[i]] = math.sqrt(squared[r, i]) * scale
            indices[row, places[i]] = index_at[positions[r, i]]


@compiled(nogil=True)
def _exact_places(index_at: Ints, positions: Ints, squared: Floats, r: int, places: Ints) -> None:
    for i in range(places.shape[0]):
        place, index = 0, index_at[positions[r, i]]
        for j in range(places.shape[0]):
            nearer = squared[r, j] < squared[r, i]
            place += nearer | ((squared[r, j] == squared[r, i]) & (index_at[positions[r, j]] < index))
        places[i] = place


def search_leaves(tree: KdTree, first: int, last: int, positions: Ints) -> tuple[slice, Floats]:
    """Finds the k nearest other points of each point in the leaves from `first` to before `last`; writes them to `positions`.

    The rows of the (n, k) positions are in the order of the tree. A row is in a reproducible order, but not sorted by distance.
    Returns the slice of the written rows, and their squared distances in the tree's scale.
    """
    rows = slice(first * LEAF, min(last * LEAF, tree.size))
    squared: Floats = np.empty((rows.stop - rows.start, positions.shape[1]))
    _search(tree, first, positions[rows], squared)
    return rows, squared


@compiled(nogil=True)
def _search(tree: KdTree, first: int, positions: Ints, squared: Floats) -> None:
    coordinates, boxes, lowest, indices = tree.coordinates, tree.boxes, tree.lowest, tree.indices
    rows, k = positions.shape
    near = np.empty((LEAF, 2 * k + LEAF))  # squared distances of each point's candidates; `at` has their positions
    at = np.empty((LEAF, 2 * k + LEAF), np.int32)
    counts, ties = np.empty(LEAF, np.int64), np.empty(LEAF, np.int64)
    bounds, gaps, distances = np.empty(LEAF), np.empty(LEAF), np.empty(LEAF)
    stack = np.empty((STACK, 3), np.int64)
    stack_gaps = np.empty(STACK)
    box = np.empty((2, 3))
    width = coordinates.shape[2]
    for leaf in range(first, first + (rows + LEAF - 1) // LEAF):
        start = (leaf - first) * LEAF
        asking = min(LEAF, rows - start)
        for d in range(3):
            box[0, d] = coordinates[leaf, d, :asking].min()
            box[1, d] = coordinates[leaf, d, :asking].max()
        counts[:], bounds[:], ties[:] = 0, FAR, ANY_INDEX
        bound, tie = FAR, ANY_INDEX  # the largest distance bound of the leaf's points, and the index bound with it
        stack[0, 0], stack[0, 1], stack[0, 2], stack_gaps[0] = 1, 0, coordinates.shape[0], 0.0
        top = 1
        while top > 0:
            top -= 1
            node, a, b, gap = stack[top, 0], stack[top, 1], stack[top, 2], stack_gaps[top]
            # At equal gaps the left child comes first: if all points coincide, it has the lower indices.
            while b - a > 1 and _within(gap, lowest[node], bound, tie):
                middle = (a + b) // 2
                left_gap, right_gap = _gap(box, boxes, 2 * node), _gap(box, boxes, 2 * node + 1)
                if left_gap <= right_gap:
                    stack[top, 0], stack[top, 1], stack[top, 2], stack_gaps[top] = 2 * node + 1, middle, b, right_gap
                    node, b, gap = 2 * node, middle, left_gap
                else:
                    stack[top, 0], stack[top, 1], stack[top, 2], stack_gaps[top] = 2 * node, a, middle, left_gap
                    node, a, gap = 2 * node + 1, middle, right_gap
                top += 1
            if not _within(gap, lowest[node], bound, tie):
                continue
            _gaps(coordinates, leaf, boxes, node, gaps)
            shrunk = False
            for q in range(asking):
                if not _within(gaps[q], lowest[node], bounds[q], ties[q]):
                    continue
                x, y, z = coordinates[leaf, 0, q], coordinates[leaf, 1, q], coordinates[leaf, 2, q]
                for i in range(width):
                    dx, dy, dz = coordinates[a, 0, i] - x, coordinates[a, 1, i] - y, coordinates[a, 2, i] - z
                    distances[i] = dx * dx + dy * dy + dz * dz
                if a == leaf:
                    distances[q] = np.inf  # a point is no neighbour of itself
                count, limit = np.uint64(counts[q]), bounds[q]
                for i in range(LEAF):
                    near[q, count], at[q, count] = distances[i], a * LEAF + i
                    count += np.uint64(distances[i] <= limit)  # adds 0 or 1 without a branch
                counts[q] = count
                if counts[q] > 2 * k:
                    # Selecting exactly k would take longer.
                    counts[q], bounds[q], ties[q] = keep_nearest(near, at, q, counts[q], k, k + k // _MORE, limit, indices)
                    shrunk = True
            if shrunk:
                bound, tie = 0.0, 0
                for q in range(asking):
                    if bounds[q] > bound or (bounds[q] == bound and ties[q] > tie):
                        bound, tie = bounds[q], ties[q]
        for q in range(asking):
            keep_nearest(near, at, q, counts[q], k, k, bounds[q], indices)
            for i in range(k):
                squared[start + q, i], positions[start + q, i] = near[q, i], at[q, i]


@compiled(nogil=True)
def _gaps(coordinates: Floats, leaf: int, boxes: Floats, node: int, gaps: Floats) -> None:
    """Writes the squared distance of each point of a leaf from the box of a node."""
    gaps[:] = 0.0
    for d in range(3):
        low, high = boxes[node, 0, d], boxes[node, 1, d]
        for q in range(LEAF):
            outside = max(max(low - coordinates[leaf, d, q], coordinates[leaf, d, q] - high), 0.0)
            gaps[q] += outside * outside


@compiled(nogil=True)
def _within(gap: float, lowest: int, bound: float, tie: int) -> bool:
    """Whether a box at the squared distance `gap`, with the `lowest` index, can hold a candidate."""
    return gap < bound or (gap == bound and lowest < tie)


@compiled(nogil=True)
def _gap(box: Floats, boxes: Floats, node: int) -> float:
    """Returns the squared distance between a box and the box of a node."""
    total = 0.0
    for d in range(3):
        outside = max(max(boxes[node, 0, d] - box[1, d], box[0, d] - boxes[node, 1, d]), 0.0)
        total += outside * outside
    return total

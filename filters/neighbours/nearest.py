"""The exact nearest neighbours of every point of a cloud."""

import math
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_whole_number
from ..compilation import compiled
from ..execution import Progress, ignore_progress, in_parallel, part_of
from ..mesh import Floats, Ints, check_points
from .kd_tree import ANY_INDEX, FAR, LEAF, STACK, KdTree, build_tree, keep_nearest

#: The share of the time that building the tree takes, roughly.
_BUILDING = 0.2
#: Neighbours that one task finds: about a hundredth of a second, and their arrays stay in the cache.
_CHUNK = 2**18
#: At least this many tasks, so that all threads end at about the same time,
_TASKS = 64
#: unless one would find fewer neighbours than these: half a millisecond. To give a thread a task takes a hundredth.
_LEAST = 2**14
#: Up to k / 8 more candidates than k may stay in the search.
_MORE = 8


def nearest_neighbours(points: ArrayLike, k: int, *, progress: Progress = ignore_progress) -> tuple[Floats, Ints]:
    """The k nearest neighbours of every point among all other points.

    The search is exact: neighbours are ordered by the squared distance as computed in float64, then by index. A point is left
    out of its own neighbours by its index, so that a point at the same place is a neighbour at distance 0.

    Args:
        points: (n, 3) finite coordinates, in any unit and of any magnitude.
        k: the number of neighbours, at least 1 and less than n. The time grows with k, for many hundreds with its square.
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
    """The points as (n, 3) float64, and the number of neighbours as an int.

    Raises:
        FilterInputError: points of another shape or not finite, or no k other points for each; `name` is that of k.
    """
    cloud, k = check_points(points), check_whole_number(name, k, least=1)
    if k >= len(cloud):
        raise FilterInputError(
            f"{k} neighbours need a cloud of at least {k + 1} points, got {len(cloud)}: ask for fewer neighbours or add points"
        )
    return cloud, k


def leaf_ranges(tree: KdTree, k: int) -> list[tuple[int, int]]:
    """The ranges of leaves that one task searches for."""
    leaves = len(tree.coordinates)
    size = max(1, min(_CHUNK // (k * LEAF), max(leaves // _TASKS, _LEAST // (k * LEAF))))
    return [(first, min(first + size, leaves)) for first in range(0, leaves, size)]


@compiled(nogil=True)
def _find(tree: KdTree, indices: Ints, distances: Floats, first: int, last: int) -> None:
    """Fills the rows of the points in the leaves from `first` to before `last`, leaf by leaf, to keep little beside them."""
    k = indices.shape[1]
    positions, squared = np.empty((LEAF, k), np.int32), np.empty((LEAF, k))
    for leaf in range(first, last):
        rows = min(LEAF, tree.size - leaf * LEAF)
        _search(tree, leaf, positions[:rows], squared[:rows])
        _sort_rows(tree.indices, leaf * LEAF, positions[:rows], squared[:rows], tree.scale, indices, distances)


@compiled(nogil=True)
def _sort_rows(
    index_at: Ints,
    start: int,
    positions: Ints,
    squared: Floats,
    scale: float,
    indices: Ints,
    distances: Floats,
) -> None:
    """Writes the rows of the positions from `start` on to the rows of their points, ordered by distance, then by index."""
    k = positions.shape[1]
    keys, places = np.empty(k, np.float32), np.empty(k, np.int32)
    for r in range(positions.shape[0]):
        row = index_at[start + r]
        # Counting the nearer ones uses vector instructions, which is faster than sorting for up to hundreds of neighbours; in
        # float32, which rounds alike in order, twice as much as in float64. Where two are the same there, the count is exact.
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
    """The place of each neighbour in a row by distance, then by index."""
    for i in range(places.shape[0]):
        place, index = 0, index_at[positions[r, i]]
        for j in range(places.shape[0]):
            nearer = squared[r, j] < squared[r, i]
            place += nearer | ((squared[r, j] == squared[r, i]) & (index_at[positions[r, j]] < index))
        places[i] = place


def search_leaves(tree: KdTree, first: int, last: int, positions: Ints) -> tuple[slice, Floats]:
    """Writes the k nearest other points of every point in the leaves from `first` to before `last` to its row of `positions`.

    The rows of the (n, k) positions are in the order of the tree, each in no particular but a fixed order. Returns those that
    were written, and their squared distances in the tree's scale.
    """
    rows = slice(first * LEAF, min(last * LEAF, tree.size))
    squared: Floats = np.empty((rows.stop - rows.start, positions.shape[1]))
    _search(tree, first, positions[rows], squared)
    return rows, squared


@compiled(nogil=True)
def _search(tree: KdTree, first: int, positions: Ints, squared: Floats) -> None:
    coordinates, boxes, lowest, indices = tree.coordinates, tree.boxes, tree.lowest, tree.indices
    rows, k = positions.shape
    near = np.empty((LEAF, 2 * k + LEAF))  # candidates of each point of a leaf, and where they are
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
                    count += np.uint64(distances[i] <= limit)  # no branch to predict
                counts[q] = count
                if counts[q] > 2 * k:
                    # Some more may stay: exactly k would take longer.
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
    """The squared distance of each point of a leaf to the box of a node."""
    gaps[:] = 0.0
    for d in range(3):
        low, high = boxes[node, 0, d], boxes[node, 1, d]
        for q in range(LEAF):
            outside = max(max(low - coordinates[leaf, d, q], coordinates[leaf, d, q] - high), 0.0)
            gaps[q] += outside * outside


@compiled(nogil=True)
def _within(gap: float, lowest: int, bound: float, tie: int) -> bool:
    """Whether a box at the squared distance `gap`, with that lowest index, can hold a candidate."""
    return gap < bound or (gap == bound and lowest < tie)


@compiled(nogil=True)
def _gap(box: Floats, boxes: Floats, node: int) -> float:
    """The squared distance between a box and that of a node."""
    total = 0.0
    for d in range(3):
        outside = max(max(boxes[node, 0, d] - box[1, d], box[0, d] - boxes[node, 1, d]), 0.0)
        total += outside * outside
    return total

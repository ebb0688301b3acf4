"""The exact nearest neighbours of every point of a cloud."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_whole_number
from ..compilation import compiled
from ..execution import Progress, ignore_progress, in_parallel, part_of
from ..mesh import Floats, Ints
from .kd_tree import LEAF, KdTree, build_tree
from .tree_search import search_leaves

#: The share of the time that building the tree takes, roughly.
_BUILDING = 0.2
#: Neighbours that one task finds: about a hundredth of a second, and their arrays stay in the cache.
_CHUNK = 2**18
#: At least this many tasks, if there are as many leaves, so that all threads end at about the same time.
_TASKS = 64


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
    distances: Floats = np.empty((tree.count, k))
    indices: Ints = np.empty((tree.count, k), np.int32)

    def find(first: int, last: int) -> None:
        positions, squared = search_leaves(tree, first, last, k)
        _sort_rows(tree.indices, first * LEAF, positions, squared, tree.scale, indices, distances)

    in_parallel(find, leaf_ranges(tree, k), part_of(progress, _BUILDING, 1.0))
    return distances, indices


def check_cloud(points: ArrayLike, k: int, name: str = "k") -> tuple[Floats, int]:
    """The points as (n, 3) float64, and the number of neighbours as an int.

    Raises:
        FilterInputError: points of another shape or not finite, or no k other points for each; `name` is that of k.
    """
    cloud = np.ascontiguousarray(points, dtype=np.float64)
    if cloud.ndim != 2 or cloud.shape[1] != 3:
        raise FilterInputError(f"points must have the shape (n, 3), got {cloud.shape}")
    k = check_whole_number(name, k, least=1)
    if k >= len(cloud):
        raise FilterInputError(
            f"{k} neighbours need a cloud of at least {k + 1} points, got {len(cloud)}: ask for fewer neighbours or add points"
        )
    bad = np.flatnonzero(~np.isfinite(cloud).all(axis=1))
    if bad.size:
        raise FilterInputError(
            f"{bad.size} of {len(cloud)} points have a coordinate that is NaN or infinite, the first is point {bad[0]} at "
            f"{tuple(cloud[bad[0]].tolist())}: remove them first"
        )
    return cloud, k


def leaf_ranges(tree: KdTree, k: int) -> list[tuple[int, int]]:
    """The ranges of leaves that one task searches for."""
    leaves = len(tree.coordinates)
    size = max(1, min(_CHUNK // (k * LEAF), leaves // _TASKS))
    return [(first, min(first + size, leaves)) for first in range(0, leaves, size)]


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
    """Writes the rows found for the positions from `start` on to the rows of their points, by distance, then by index."""
    k = positions.shape[1]
    found = np.empty(k, np.int32)
    for r in range(positions.shape[0]):
        row = index_at[start + r]
        for i in range(k):
            found[i] = index_at[positions[r, i]]
        for i in range(k):
            # Counting the nearer ones uses vector instructions, which is faster than sorting for up to hundreds of neighbours.
            place = 0
            for j in range(k):
                place += (squared[r, j] < squared[r, i]) | ((squared[r, j] == squared[r, i]) & (found[j] < found[i]))
            distances[row, place], indices[row, place] = math.sqrt(squared[r, i]) * scale, found[i]

"""LoOP: how likely each point of a cloud is an outlier [kriegel2009]."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_positive
from ..execution import Progress, ignore_progress, in_parallel, part_of
from ..mesh import Floats, Ints
from ..neighbours import LEAF, build_tree, check_cloud, leaf_ranges, search_leaves
from .factors import SPREAD_BLOCK, compare, probabilities_of, spread_of, standard_distances


def local_outlier_probability(
    points: ArrayLike, *, neighbors: int = 20, extent: float = 3.0, progress: Progress = ignore_progress
) -> Floats:
    r"""The probability of each point to be an outlier: the distances to its neighbours compared with theirs to their own.

    With :math:`K_p` the k nearest neighbours of p, p itself left out:

    .. math::

        \sigma(p) &= \sqrt{\tfrac1k \textstyle\sum_{q \in K_p} |p - q|^2} \\
        \mathrm{PLOF}(p) &= \sigma(p) / \tfrac1k \textstyle\sum_{q \in K_p} \sigma(q) - 1 \\
        \mathrm{nPLOF} &= \lambda \sqrt{\tfrac1n \textstyle\sum_p \mathrm{PLOF}(p)^2} \\
        \mathrm{LoOP}(p) &= \max(0, \mathrm{erf}(\mathrm{PLOF}(p) / (\sqrt2 \, \mathrm{nPLOF})))

    The result depends neither on the unit nor on the density of the cloud: a point is an outlier if its neighbours are farther
    from it than from their own neighbours, by more than is usual in the cloud.

    Args:
        points: (n, 3) finite coordinates.
        neighbors: k, from 1 to n - 1. Must exceed the size of the clumps of outliers that are to be found; larger gives steadier
            probabilities, blurs borders between densities and takes longer.
        extent: :math:`\lambda > 0`, in standard deviations of PLOF. Larger gives smaller probabilities, so fewer points above
            any threshold.
        progress: called with the share of the work done.

    Returns:
        (n,) float64 probabilities in [0, 1]. Where a point coincides with all its neighbours the probability is 0. Where all
        neighbours coincide with theirs but the point does not, PLOF is infinite: the probability is 1, and the point is left out
        of the mean in nPLOF. Distances that differ by no more than the rounding of the coordinates count as equal, so that a
        regular arrangement of points has no outliers.

    Raises:
        FilterInputError: a parameter is out of its bounds, or coordinates are missing, NaN or infinite.
    """
    check_positive("extent", extent)
    factors = outlier_factors(points, neighbors=neighbors, progress=progress)
    return probabilities_of(factors, spread_of(lambda: _blocks(factors), extent))


def outlier_factors(points: ArrayLike, *, neighbors: int, progress: Progress = ignore_progress) -> Floats:
    """(n,) the probabilistic local outlier factors PLOF of `local_outlier_probability`: at least -1, above 0 where a point is
    farther from its neighbours than they are from theirs, and infinite as said there.
    """
    cloud, k = check_cloud(points, neighbors, "neighbors")
    tree = build_tree(cloud, part_of(progress, 0.0, 0.2))
    distances: Floats = np.empty(tree.count)
    positions: Ints = np.empty((tree.count, k), np.int32)
    factors: Floats = np.empty(tree.count)

    def find(first: int, last: int) -> None:
        found, squared = search_leaves(tree, first, last, k)
        rows = slice(first * LEAF, first * LEAF + len(found))
        positions[rows] = found
        distances[rows] = standard_distances(squared)

    def judge(first: int, last: int) -> None:
        compare(distances, positions, first * LEAF, min(last * LEAF, tree.count), factors)

    in_parallel(find, leaf_ranges(tree, k), part_of(progress, 0.2, 0.9))
    in_parallel(judge, leaf_ranges(tree, k), part_of(progress, 0.9, 1.0))
    by_index: Floats = np.empty(tree.count)
    by_index[tree.indices[: tree.count]] = factors
    return by_index


def _blocks(factors: Floats) -> Iterator[Floats]:
    return (factors[first : first + SPREAD_BLOCK] for first in range(0, len(factors), SPREAD_BLOCK))

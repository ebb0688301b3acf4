"""LoOP: how likely each point of a cloud is an outlier [kriegel2009]."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_positive
from ..compilation import compiled
from ..execution import Progress, ignore_progress, in_parallel, part_of
from ..libraries import special
from ..mesh import Floats, Ints
from ..neighbours import LEAF, build_tree, check_cloud, leaf_ranges, search_leaves

#: The difference that rounding makes between equal distances, in the unit of a tree, where the largest coordinate is 1/2 to 1.
_ROUNDING = 32 * np.finfo(np.float64).eps
#: And at most this share of the distance, since a cloud may be finer than that around the origin.
_ALIKE = 1e-6


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
    finite = factors[np.isfinite(factors)]
    scale = np.abs(finite).max(initial=0.0) or 1.0  # so that no square overflows
    spread = extent * scale * np.sqrt(np.mean((finite / scale) ** 2)) if finite.size else 0.0
    if spread == 0.0:
        return (factors > 0.0).astype(np.float64)
    probabilities: Floats = np.maximum(0.0, special.erf(factors / (np.sqrt(2.0) * spread)))
    return probabilities


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
        distances[rows] = np.sqrt(_row_sums(squared) / k)

    def compare(first: int, last: int) -> None:
        _compare(distances, positions, tree.indices, first * LEAF, min(last * LEAF, tree.count), factors)

    in_parallel(find, leaf_ranges(tree, k), part_of(progress, 0.2, 0.9))
    in_parallel(compare, leaf_ranges(tree, k), part_of(progress, 0.9, 1.0))
    return factors


@compiled(nogil=True)
def _row_sums(values: Floats) -> Floats:
    sums = np.zeros(values.shape[0])
    for r in range(values.shape[0]):
        for c in range(values.shape[1]):
            sums[r] += values[r, c]
    return sums


@compiled(nogil=True)
def _compare(
    distances: Floats,
    positions: Ints,
    indices: Ints,
    start: int,
    stop: int,
    factors: Floats,
) -> None:
    """Computes PLOF in place, of the points at the positions from `start` to before `stop`."""
    k = positions.shape[1]
    for p in range(start, stop):
        total = 0.0
        for i in range(k):
            total += distances[positions[p, i]]
        mean = total / k
        difference = distances[p] - mean
        if abs(difference) <= min(_ROUNDING, _ALIKE * mean):
            factors[indices[p]] = 0.0
        elif mean > 0.0:
            factors[indices[p]] = difference / mean
        else:
            factors[indices[p]] = np.inf

"""The local outlier probability (LoOP) of each point of a cloud [kriegel2009]."""

import math
from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_positive
from ..compilation import compiled
from ..execution import Progress, ignore_progress, in_parallel, part_of
from ..libraries import special
from ..mesh import Floats, Ints
from ..neighbours import LEAF, build_tree, check_cloud, leaf_ranges, search_leaves

REPLACED_SCALARS = "the outlier probabilities replace the vertex scalars of the mesh"
#: Number of factors in one block of the sum of squares.
SPREAD_BLOCK = 1 << 16
#: Largest rounding error of a difference of distances, in the unit of a search tree, whose largest coordinate is 1/2 to 1.
_ROUNDING = 32 * np.finfo(np.float64).eps
#: Differences above this share of the mean distance are no rounding errors, even below `_ROUNDING`: distances can be tiny.
_ALIKE = 1e-6
#: The smallest float64 above 0 is 2 to this power.
_LOWEST = -1074


def local_outlier_probability(
    points: ArrayLike, *, neighbors: int = 20, extent: float = 3.0, progress: Progress = ignore_progress
) -> Floats:
    r"""Returns the probability that a point is an outlier: that it is farther from its neighbours than they are from theirs.

    :math:`K_p` are the k nearest neighbours of p, without p:

    .. math::

        \sigma(p) &= \sqrt{\tfrac1k \textstyle\sum_{q \in K_p} |p - q|^2} \\
        \mathrm{PLOF}(p) &= \sigma(p) / \tfrac1k \textstyle\sum_{q \in K_p} \sigma(q) - 1 \\
        \mathrm{nPLOF} &= \lambda \sqrt{\tfrac1n \textstyle\sum_p \mathrm{PLOF}(p)^2} \\
        \mathrm{LoOP}(p) &= \max(0, \mathrm{erf}(\mathrm{PLOF}(p) / (\sqrt2 \, \mathrm{nPLOF})))

    The result does not depend on the unit or the density of the cloud.

    Args:
        points: (n, 3) finite coordinates.
        neighbors: k, from 1 to n - 1. Must exceed the number of points in a clump of outliers. Larger gives steadier
            probabilities, blurs borders between densities and takes longer.
        extent: :math:`\lambda > 0`, in standard deviations of PLOF. Larger gives smaller probabilities, so fewer points above
            any threshold.
        progress: called with the share of the work done.

    Returns:
        (n,) float64 probabilities in [0, 1], 0 for a point that coincides with all its neighbours. If all neighbours coincide
        with their own neighbours but not with the point, PLOF is infinite: the probability is 1, and nPLOF ignores the point.
        Distances that differ by no more than the rounding of the coordinates count as equal: rounding alone makes no outliers.

    Raises:
        FilterInputError: a parameter is out of its bounds, or coordinates are missing, NaN or infinite.
    """
    check_positive("extent", extent)
    factors = outlier_factors(points, neighbors=neighbors, progress=progress)
    starts = range(0, len(factors), SPREAD_BLOCK)
    return probabilities_of(factors, spread_of(lambda: (factors[at : at + SPREAD_BLOCK] for at in starts), extent))


def outlier_factors(points: ArrayLike, *, neighbors: int, progress: Progress = ignore_progress) -> Floats:
    """Returns (n,) PLOF, see `local_outlier_probability`: at least -1."""
    cloud, k = check_cloud(points, neighbors, "neighbors")
    tree = build_tree(cloud, part_of(progress, 0.0, 0.2))
    distances: Floats = np.empty(tree.size)
    positions: Ints = np.empty((tree.size, k), np.int32)
    factors: Floats = np.empty(tree.size)

    def find(first: int, last: int) -> None:
        rows, squared = search_leaves(tree, first, last, positions)
        distances[rows] = standard_distances(squared)

    def compare(first: int, last: int) -> None:
        part = slice(first * LEAF, min(last * LEAF, tree.size))
        factors[part] = compare_rows(distances[part], distances.take(positions[part]))

    in_parallel(find, leaf_ranges(tree, k), part_of(progress, 0.2, 0.9))
    in_parallel(compare, leaf_ranges(tree, k), part_of(progress, 0.9, 1.0))
    by_index: Floats = np.empty(tree.size)
    by_index[tree.indices[: tree.size]] = factors
    return by_index


@compiled(nogil=True)
def standard_distances(squared: Floats) -> Floats:
    """Returns (n,) the root of the mean of each row of (n, k) squared distances; the order in a row does not matter."""
    distances = np.empty(squared.shape[0])
    for r in range(squared.shape[0]):
        distances[r] = math.sqrt(_sum(squared[r]) / squared.shape[1])
    return distances


@compiled(nogil=True)
def compare_rows(distances: Floats, around: Floats) -> Floats:
    """Returns (a,) PLOF from standard distances in a tree's unit: (a,) of the points, and (a, k) of their neighbours."""
    factors = np.empty(distances.shape[0])
    for p in range(distances.shape[0]):
        factors[p] = _factor(distances[p], around[p])
    return factors


def spread_of(blocks: Callable[[], Iterable[Floats]], extent: float) -> float:
    """Returns nPLOF: `extent` times the root mean square of the finite factors of a cloud.

    `blocks` is called twice, and yields the factors in the order of the points: `SPREAD_BLOCK` at a time, fewer at the end.
    """
    largest, count = 0.0, 0
    for block in blocks():
        finite = block[np.isfinite(block)]
        largest, count = max(largest, float(np.abs(finite).max(initial=0.0))), count + len(finite)
    scale = largest or 1.0  # so that no square overflows
    total = math.fsum(float(np.sum((block[np.isfinite(block)] / scale) ** 2)) for block in blocks())
    return extent * scale * math.sqrt(total / count) if count else 0.0


def probabilities_of(factors: Floats, spread: float) -> Floats:
    """Returns LoOP for factors PLOF and the nPLOF `spread` of the cloud."""
    if spread == 0.0:
        return (factors > 0.0).astype(np.float64)
    probabilities: Floats = np.maximum(0.0, special.erf(factors / (np.sqrt(2.0) * spread)))
    return probabilities


@compiled(nogil=True)
def _sum(values: Floats) -> float:
    """Returns the sum of numbers >= 0. Each is rounded down to a multiple of one tiny number, so their order does not matter."""
    largest = 0.0
    for value in values:
        largest = max(largest, value)
    if not 0.0 < largest < np.inf:
        return largest
    digits = 61
    while (values.shape[0] >> (61 - digits)) > 0:
        digits -= 1
    exponent = max(math.frexp(largest)[1] - digits, _LOWEST)
    # Products with powers of two are as exact as quotients, and faster. A single power may be too large for a float64.
    half = math.ldexp(1.0, -(exponent // 2))
    other = math.ldexp(1.0, exponent // 2 - exponent)
    total = np.int64(0)
    for value in values:
        total += np.int64(value * half * other)
    return total * math.ldexp(1.0, exponent)


@compiled(nogil=True)
def _factor(distance: float, others: Floats) -> float:
    mean = _sum(others) / others.shape[0]
    difference = distance - mean
    if abs(difference) <= min(_ROUNDING, _ALIKE * mean):
        return 0.0
    return difference / mean if mean > 0.0 else np.inf

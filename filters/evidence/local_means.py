"""Means over the surroundings of vertices: what is said of a place, and not of one vertex."""

import numpy as np

from ..mesh import Bools, Floats, Ints


def local_means(values: Floats, counted: Bools, pairs: Ints, *, times: int) -> Floats:
    """(n,) the means of the values around, added up over the one-rings so many times; what is not counted has no part in them.

    Args:
        values: (n,) numbers.
        counted: (n,) which of them count.
        pairs: (e, 2) the edges.
        times: how often; the surroundings are as many rings wide.

    Returns:
        The means; 0 where nothing around counts.
    """
    sums, weights = np.where(counted, values, 0.0), counted.astype(np.float64)
    a, b = pairs.T
    for _ in range(times):
        for numbers in (sums, weights):
            numbers += np.bincount(a, numbers[b], len(numbers)) + np.bincount(b, numbers[a], len(numbers))
    return np.divide(sums, weights, out=np.zeros(len(values)), where=weights > 0.0)

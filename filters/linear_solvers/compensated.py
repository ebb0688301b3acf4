"""Powers of a Laplace operator applied in twice the precision: residuals whose digits the conditioning of the power leaves."""

from __future__ import annotations

import numpy as np

from ..compilation import compiled, prange
from ..execution import threads_for
from ..libraries import sparse
from ..mesh import Floats, Ints, Longs

# Veltkamp's constant 2^27 + 1 splits a double into two halves whose products are exact.
_SPLITTER = 134217729.0


def laplacian_power(
    matrix: sparse.csr_matrix, inverse_mass: Floats, order: int, values: Floats, more: Floats | None = None
) -> Floats:
    """(S M^-1)^(order - 1) S x, computed with about 32 digits and rounded once.

    The rows of S count as summing to 0 exactly: its diagonal is not read. In ordinary precision each application loses the digits
    that differences between neighbours lose, at order 3 and 100,000 vertices nearly all of 16; of 32 enough are left. Sums and
    products carry their rounding errors along as a second double [dekker1971].

    Args:
        matrix: S, (n, n) symmetric; S or -S is semidefinite.
        inverse_mass: (n,) the diagonal of M^-1.
        order: the power, at least 1.
        values: x, (n, 3).
        more: (n, 3) added to x without rounding; None for 0.

    Returns:
        (n, 3).
    """
    high, low = np.ascontiguousarray(values), np.zeros(values.shape) if more is None else np.ascontiguousarray(more)
    indptr, indices = matrix.indptr.astype(np.int64), matrix.indices.astype(np.int32)
    with threads_for(len(values)):
        for step in range(order):
            high_product, low_product = np.empty(values.shape), np.empty(values.shape)
            factors = inverse_mass if step < order - 1 else np.ones(len(values))
            _apply(indptr, indices, matrix.data, factors, high, low, high_product, low_product)
            high, low = high_product, low_product
    return high


@compiled
def _two_sum(a: float, b: float) -> tuple[float, float]:
    s = a + b
    t = s - a
    return s, (a - (s - t)) + (b - t)


@compiled
def _two_product(a: float, b: float) -> tuple[float, float]:
    p = a * b
    t = _SPLITTER * a
    a_high = t - (t - a)
    a_low = a - a_high
    t = _SPLITTER * b
    b_high = t - (t - b)
    b_low = b - b_high
    return p, ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low


@compiled(parallel=True)
def _apply(
    indptr: Longs, indices: Ints, data: Floats, factors: Floats, high: Floats, low: Floats, out_high: Floats, out_low: Floats
) -> None:
    """out_i = factors_i sum_j S_ij (x_j - x_i), every number a sum of a high and a low double."""
    for i in prange(indptr.shape[0] - 1):
        for c in range(high.shape[1]):
            total, rest = 0.0, 0.0
            for k in range(indptr[i], indptr[i + 1]):
                j = indices[k]
                if j == i:
                    continue
                difference, error = _two_sum(high[j, c], -high[i, c])
                more, rest_of_more = _two_sum(low[j, c], -low[i, c])
                difference, lost = _two_sum(difference, more)
                difference, error = _two_sum(difference, error + lost + rest_of_more)
                product, lost = _two_product(data[k], difference)
                lost += data[k] * error
                total, carried = _two_sum(total, product)
                rest += carried + lost
            total, rest = _two_sum(total, rest)
            product, lost = _two_product(factors[i], total)
            lost += factors[i] * rest
            out_high[i, c], out_low[i, c] = _two_sum(product, lost)

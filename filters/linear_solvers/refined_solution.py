"""Iterative refinement with residuals in twice the precision, for ill-conditioned powers of Laplace operators."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..checks import ConvergenceError
from ..compilation import compiled, prange
from ..execution import Progress, ignore_progress, threads_for
from ..libraries import sparse
from ..mesh import Floats
from .conjugate_gradients import CompressedRows
from .spd_solver import Cholesky, SpdSystem

#: Corrections are made until the next is predicted below this share of the extent, at most this many.
_REFINED, _MOST_REFINEMENTS = 1e-11, 12
#: The refinement has failed if its last correction is above this share of the extent.
_UNREFINED = 1e-6
# Veltkamp's constant 2^27 + 1 splits a double into two halves whose products are exact.
_SPLITTER = 134217729.0


def refined_solution(
    matrix: sparse.csr_matrix,
    residual: Callable[[Floats], Floats],
    start: Floats,
    *,
    extent: float,
    first: Floats | None = None,
    solve: Callable[[Floats], Floats] | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Solves A x = b by factors and iterative refinement; the caller computes b - A x more precisely than A is stored.

    If A is a product, its rounding alone may leave only a few digits of x. With a precise residual each step adds that many, and
    the solution is that of the exact product [higham2002].

    Args:
        matrix: A, (n, n) symmetric positive definite to rounding.
        residual: b - A x of (n, k) values x, with more digits than the condition number of A takes.
        start: (n, k) a first guess.
        extent: the length against which errors in x count.
        first: (n, k) b - A x of the first guess where ordinary precision will do; None for that of `residual`.
        solve: solves A x = r to a few digits for (n, k) residuals; None for factors.
        progress: called meanwhile; may raise to stop.

    Returns:
        x, (n, k).

    Raises:
        FilterInputError: A is not finite or has a diagonal entry that is not positive.
        ConvergenceError: A is singular to rounding, or the corrections do not shrink.
    """
    csr = SpdSystem.of(matrix).matrix
    solve = solve or Cholesky(csr, progress=progress, done=0.1).solve
    x = np.asarray(start, dtype=np.float64)
    del start  # not needed after the first step
    before, steps = np.inf, 0
    while True:
        rest = first if steps == 0 and first is not None else residual(x)
        correction = solve(rest)
        x = x + correction
        moved = float(np.abs(correction).max(initial=0.0))
        progress(0.9 + 0.1 * steps / (steps + 1))
        if moved == 0.0 or (steps > 0 and moved * (moved / before) <= _REFINED * extent):
            break
        if steps == _MOST_REFINEMENTS or (steps > 1 and not moved < 0.5 * before):
            break
        before, steps = moved, steps + 1
    if not moved <= _UNREFINED * extent:
        raise ConvergenceError(f"refinement of {len(x)} equations stalls at corrections of {moved / extent:.3g} of the extent")
    return x


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
    rows = CompressedRows(matrix.indptr.astype(np.int64), matrix.indices.astype(np.int32), matrix.data)
    with threads_for(len(values)):
        for step in range(order):
            high_product, low_product = np.empty(values.shape), np.empty(values.shape)
            factors = inverse_mass if step < order - 1 else np.ones(len(values))
            _apply(rows, factors, high, low, high_product, low_product)
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


@compiled
def _added(
    total: float, rest: float, factor: float, high: float, low: float, from_high: float, from_low: float
) -> tuple[float, float]:
    """The sum and its rest with factor (high + low - from_high - from_low) added."""
    difference, error = _two_sum(high, -from_high)
    more, rest_of_more = _two_sum(low, -from_low)
    difference, lost = _two_sum(difference, more)
    difference, error = _two_sum(difference, error + lost + rest_of_more)
    product, lost = _two_product(factor, difference)
    lost += factor * error
    total, carried = _two_sum(total, product)
    return total, rest + (carried + lost)


@compiled
def _scaled(total: float, rest: float, factor: float) -> tuple[float, float]:
    total, rest = _two_sum(total, rest)
    product, lost = _two_product(factor, total)
    return _two_sum(product, lost + factor * rest)


@compiled(parallel=True)
def _apply(matrix: CompressedRows, factors: Floats, high: Floats, low: Floats, out_high: Floats, out_low: Floats) -> None:
    """out_i = factors_i sum_j S_ij (x_j - x_i), every number a sum of a high and a low double.

    The three columns take turns: each waits for its own last sum alone.
    """
    indptr, indices, data = matrix
    for i in prange(indptr.shape[0] - 1):
        x, y, z, p, q, r = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if j != i:
                x, p = _added(x, p, data[k], high[j, 0], low[j, 0], high[i, 0], low[i, 0])
                y, q = _added(y, q, data[k], high[j, 1], low[j, 1], high[i, 1], low[i, 1])
                z, r = _added(z, r, data[k], high[j, 2], low[j, 2], high[i, 2], low[i, 2])
        out_high[i, 0], out_low[i, 0] = _scaled(x, p, factors[i])
        out_high[i, 1], out_low[i, 1] = _scaled(y, q, factors[i])
        out_high[i, 2], out_low[i, 2] = _scaled(z, r, factors[i])

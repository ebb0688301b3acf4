"""Filters by a polynomial of the operator, which takes only products with a sparse matrix [hammond2011].

A response F(sqrt kappa) is approximated on [0, b], b at least the largest eigenvalue, by a Chebyshev series p, and p(M^-1 S) v is
summed by the recurrence T_{k+1}(t) = 2 t T_k(t) - T_{k-1}(t). The matrix is used as D = M^-1/2 S M^-1/2 on M^1/2 v, symmetric,
so that the error of p is that of the filter: |p(M^-1 S) v - F v|_M <= max |p - F| |v|_M.

The degree grows with sqrt(b) / omega_c, for the default low pass and 1e-6 as 8.7 times that: so with the cutoff wavelength in
edges, and with thinner triangles.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..compilation import compiled, prange
from ..execution import Progress, ignore_progress, part_of, threads_for
from ..libraries import fft, sparse
from ..linear_solvers import CompressedRows
from ..mesh import Floats, Ints
from .responses import Response

#: The fewest samples, and the samples per 1 / width.
_FIRST_SAMPLES, _SAMPLES_A_WIDTH = 64, 16
#: Coefficients below this share of the largest are rounding.
_ROUNDING = 1e-15


@dataclass(frozen=True, eq=False)
class ChebyshevSeries:
    """p(t) = sum_k coefficients_k T_k(t), an approximation of a function on [-1, 1]."""

    coefficients: Floats  # (degree + 1,)
    error: float  # a bound of |p - f| on [-1, 1]: the sum of the sizes of the computed coefficients that were left out

    @property
    def degree(self) -> int:
        """The degree of the polynomial."""
        return len(self.coefficients) - 1


def chebyshev_series(
    function: Callable[[Floats], Floats], *, tolerance: float, width: float, largest_degree: int
) -> ChebyshevSeries:
    """The shortest Chebyshev series of a smooth function whose error is bounded by the tolerance.

    The coefficients come from samples at the roots of a T_N, by a cosine transform. N doubles until the sum of the second half of
    the coefficients is below a hundredth of the tolerance, so that aliasing into the first half is negligible.

    Args:
        function: of (N,) t in (-1, 1).
        tolerance: of |p - f|, above 0.
        width: the smallest angle theta, t = cos theta, in which the function changes: samples farther apart could miss it.
        largest_degree: the series has at most this degree. Its `error` is then larger than the tolerance, infinite if unknown.
    """
    if not width * largest_degree > 1.0:
        return ChebyshevSeries(np.zeros(1), math.inf)
    samples = max(_FIRST_SAMPLES, math.ceil(_SAMPLES_A_WIDTH / width))
    while True:
        nodes = np.cos(np.pi * (np.arange(samples) + 0.5) / samples)
        coefficients: Floats = fft.dct(function(nodes), type=2) / samples
        coefficients[0] *= 0.5
        sizes = np.abs(coefficients)
        second_half = float(sizes[samples // 2 :].sum())
        floor = _ROUNDING * samples * float(sizes.max())
        if second_half <= max(0.01 * tolerance, floor) or samples > 4 * largest_degree:
            break
        samples *= 2
    # tails[k] is the error of a series of degree k - 1; the coefficients beyond the samples sum to less than their second half.
    tails = np.append(np.cumsum(sizes[::-1])[::-1], 0.0) + second_half
    degree = int(np.argmax(tails[1:] <= max(tolerance, tails[-1])))
    degree = min(degree, largest_degree)
    return ChebyshevSeries(coefficients[: degree + 1].copy(), float(tails[degree + 1]))


#: Norms may exceed their bound by this factor, for rounding.
_GROWTH = 1.0 + 1e-6
_CHECKED_EVERY = 16
#: The highest degree that is tried.
LARGEST_DEGREE = 100_000
#: Steps of Lanczos's method, and the factor on its result.
_LANCZOS_STEPS, _MARGIN = 24, 1.02
#: Of fewer rows a product finds most in the processor's caches, in any order.
FITS_IN_CACHE = 200_000
#: A large matrix is reordered if more than this share of its entries lies far from the diagonal ...
_SCATTERED = 0.2
#: ... farther than this many columns, ...
_NEAR = 8192
#: ... and if this many products with one column are to come: they lose about as much time without the order as finding it takes.
_PRODUCTS_AN_ORDER_COSTS = 300


def polynomial_series(
    response: Response, bound: float, *, tolerance: float, largest_degree: int = LARGEST_DEGREE
) -> ChebyshevSeries:
    """The series in t = 1 - 2 kappa / bound of a response on 0 <= kappa <= bound."""

    def sampled(t: Floats) -> Floats:
        return response.profile(np.sqrt(0.5 * bound * (1.0 - t)))

    # kappa = bound sin^2(theta / 2), so that the lowest cutoff lies at this angle.
    width = 2.0 * response.cutoffs[0] / math.sqrt(bound) if bound > 0.0 else 1.0
    return chebyshev_series(sampled, tolerance=tolerance, width=width, largest_degree=largest_degree)


def polynomial_filter(
    symmetric: sparse.csr_matrix,
    mass: Floats,
    values: Floats,
    series: ChebyshevSeries,
    bound: float,
    *,
    progress: Progress = ignore_progress,
) -> Floats | None:
    """p(M^-1 S) v for the series of `polynomial_series`.

    Args:
        symmetric: D of `symmetric_form`, (n, n).
        mass: (n,), above 0.
        values: v, (n, k); columns are taken three at a time.
        series: p.
        bound: b, in which the series is scaled.
        progress: called after every product; may raise to stop.

    Returns:
        None if D has an eigenvalue above b, which shows in the growth of the recurrence.
    """
    n, columns = values.shape
    root = np.sqrt(mass)
    # 2 A for A = I - 2 D / b, with a diagonal entry in every row.
    doubled = sparse.csr_matrix((symmetric.data * (-4.0 / bound), symmetric.indices, symmetric.indptr), shape=symmetric.shape)
    doubled.setdiag(doubled.diagonal() + 2.0)
    order = nearby_order(doubled, columns * series.degree)
    if order is not None:
        doubled = sparse.csr_matrix(doubled[order][:, order])
    groups: list[Floats] = []
    for first in range(0, columns, 3):
        start = np.zeros((n, 3))
        start[:, : min(3, columns - first)] = values[:, first : first + 3] * root[:, None]
        partial = part_of(progress, first / columns, min(1.0, (first + 3) / columns))
        summed = _sum_series(doubled, start if order is None else start[order], series.coefficients, partial)
        if summed is None:
            return None
        groups.append((summed if order is None else put_back(summed, order)) / root[:, None])
    return np.hstack(groups)[:, :columns] if groups else np.empty((n, 0))


def _sum_series(doubled: sparse.csr_matrix, start: Floats, coefficients: Floats, progress: Progress) -> Floats | None:
    """The sum of c_k T_k(A) x, from 2 A; None if it grows."""
    now, before = start.copy(), np.empty_like(start)
    total: Floats = coefficients[0] * now
    allowed = _GROWTH * float((start * start).sum())
    rows = CompressedRows.of(doubled)
    degree = len(coefficients) - 1
    with threads_for(len(start)):
        for k in range(1, degree + 1):
            # T_1 = A x is half of 2 A x - 0.
            if k == 1:
                before[:] = 0.0
            _advance(rows, now, before, total, coefficients[k], 0.5 if k == 1 else 1.0)
            now, before = before, now
            if (k % _CHECKED_EVERY == 0 or k == degree) and not float((now * now).sum()) <= allowed:
                return None
            progress(k / degree)
    return total


# Unsigned indices spare the test whether each counts from the end, which takes half of the time. Fusing products and sums halves
# the time again, and is more exact.
@compiled(fastmath={"contract"})
def fused_row_product(matrix: CompressedRows, i: Any, x: Floats) -> tuple[float, float, float]:
    """(A x)_i for x of shape (n, 3), products fused with sums; i is unsigned."""
    indptr, indices, data = matrix
    a = b = c = 0.0
    for entry in range(indptr[i], indptr[i + np.uint64(1)]):
        k = np.uint64(entry)
        j, value = np.uint64(indices[k]), data[k]
        a += value * x[j, 0]
        b += value * x[j, 1]
        c += value * x[j, 2]
    return a, b, c


@compiled(parallel=True, fastmath={"contract"})
def _advance(matrix: CompressedRows, now: Floats, before: Floats, total: Floats, coefficient: float, factor: float) -> None:
    """Computes before = factor (B now) - before and total += coefficient before in place, in one pass over the rows of B."""
    for row in prange(now.shape[0]):
        i = np.uint64(row)
        x, y, z = fused_row_product(matrix, i, now)
        x, y, z = factor * x - before[i, 0], factor * y - before[i, 1], factor * z - before[i, 2]
        before[i, 0], before[i, 1], before[i, 2] = x, y, z
        total[i, 0] += coefficient * x
        total[i, 1] += coefficient * y
        total[i, 2] += coefficient * z


def symmetric_form(dirichlet: sparse.csr_matrix, mass: Floats) -> sparse.csr_matrix:
    """D = M^-1/2 S M^-1/2, (n, n), the eigenvalues of which are those of M^-1 S."""
    inverse_root = 1.0 / np.sqrt(mass)
    data = dirichlet.data * (np.repeat(inverse_root, np.diff(dirichlet.indptr)) * inverse_root[dirichlet.indices])
    return sparse.csr_matrix((data, dirichlet.indices, dirichlet.indptr), shape=dirichlet.shape)


def gershgorin_bound(symmetric: sparse.csr_matrix, mass: Floats) -> float:
    """A proven bound of the largest eigenvalue, by the circles of M^-1 S; on regular triangles it is 4/3 of it."""
    root = np.sqrt(mass)
    return float((abs(symmetric) @ root / root).max(initial=0.0))


def lanczos_bound(symmetric: sparse.csr_matrix) -> float:
    """An estimate from above of the largest eigenvalue: the largest Ritz value plus its residual, times 1.02.

    The Ritz value of 24 steps from a random start is about a percent too low where eigenvalues are crowded, and exact where one
    stands out. `polynomial_filter` notices if the estimate was too low. Infinite for small matrices and where the method ends
    early, since the start may then lack some modes.
    """
    n = symmetric.shape[0]
    if n < 4 * _LANCZOS_STEPS:
        return math.inf
    steps = _LANCZOS_STEPS
    q = np.random.default_rng(0).uniform(-1.0, 1.0, n)
    q /= math.sqrt(float((q * q).sum()))
    before = np.zeros(n)
    diagonal, off = np.zeros(steps), np.zeros(steps)
    beta = 0.0
    for k in range(steps):
        w = symmetric @ q - beta * before
        # numpy's sums have a fixed order; BLAS would divide a product among its threads.
        diagonal[k] = alpha = float((w * q).sum())
        w -= alpha * q
        off[k] = beta = math.sqrt(float((w * w).sum()))
        if beta <= 1e-12 * abs(diagonal[: k + 1]).max():
            return math.inf
        before, q = q, w / beta
    ritz, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(off[:-1], 1) + np.diag(off[:-1], -1))
    return _MARGIN * (float(ritz[-1]) + abs(beta * float(vectors[-1, -1])))


def nearby_order(matrix: sparse.csr_matrix, products: int) -> Ints | None:
    """(n,) the rows in Cuthill and McKee's order, which keeps entries near the diagonal; None if it does not pay.

    Args:
        matrix: (n, n) with a symmetric pattern.
        products: the number of products to come, of one column each.
    """
    n = matrix.shape[0]
    if n < FITS_IN_CACHE or products < _PRODUCTS_AN_ORDER_COSTS:
        return None
    rows = np.repeat(np.arange(n, dtype=matrix.indices.dtype), np.diff(matrix.indptr))
    if (np.abs(rows - matrix.indices) > _NEAR).mean() < _SCATTERED:
        return None
    return np.asarray(sparse.csgraph.reverse_cuthill_mckee(matrix, symmetric_mode=True), dtype=np.int32)


def put_back(rows: Floats, order: Ints) -> Floats:
    """The rows in their order before `nearby_order`."""
    result = np.empty_like(rows)
    result[order] = rows
    return result

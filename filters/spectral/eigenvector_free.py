"""Spectral filters without eigenvectors, by a polynomial or a rational function of the operator [hammond2011].

M is the mass matrix, S the Dirichlet matrix, and b bounds all eigenvalues kappa of M^-1 S. A Chebyshev series p approximates the
response F(sqrt kappa) on [0, b]. The recurrence T_{k+1}(t) = 2 t T_k(t) - T_{k-1}(t) evaluates p(M^-1 S) v = M^-1/2 p(D) M^1/2 v.
D = M^-1/2 S M^-1/2 is symmetric, so the error of p bounds that of the filter: |p(M^-1 S) v - F v|_M <= max |p - F| |v|_M. The
degree for the default low pass (cutoff omega_c) and error 1e-6 is 8.7 sqrt(b) / omega_c: it grows with the cutoff wavelength
in edges and with thinner triangles. The degree of a series in 1 / (kappa + sigma) does not depend on b, but a term takes a solve.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from ..checks import ConvergenceError
from ..compilation import compiled, prange
from ..execution import Progress, ignore_progress, part_of, threads_for
from ..libraries import fft, sparse
from ..linear_solvers import FINEST_TOLERANCE, Cholesky, CompressedRows, SpdSolver
from ..mesh import FITS_IN_CACHE, NEAR, Floats, Ints
from .problem import Response, SpectralProblem

RouteName: TypeAlias = Literal["polynomial", "rational"]
#: Beyond this degree a polynomial takes longer than a rational function with Cholesky factors; see docs/solvers.md.
MOST_PRODUCTS = 1_000
#: The rounding error per degree, as a share of the result.
_ROUNDING = 8.0 * float(np.finfo(float).eps)


class Filtered(NamedTuple):
    """The result of `filter_without_eigenvectors`."""

    values: Floats  # of the shape of the input
    # the root mean square error over the surface and all columns, sqrt(|e|_M^2 / area), in the unit of the values: a bound for
    # the polynomial; for the rational function a bound plus an estimate of the error of the solves
    error: float
    share: float  # the error as a share of the root mean square deviation of the values from their component means
    route: RouteName
    degree: int  # the number of products with the matrix for every three columns, or of solves for all columns


def filter_without_eigenvectors(
    problem: SpectralProblem, values: Floats, response: Response, *, tolerance: float = 1e-5, progress: Progress = ignore_progress
) -> Filtered:
    """Returns F(sqrt(M^-1 S)) v: multiplies every mode in v by the response at its frequency.

    The mean of each component is subtracted first and added back exactly. A polynomial takes about three products with a matrix
    for each edge in the cutoff wavelength, more with thin triangles; if its degree would exceed `MOST_PRODUCTS`, a rational
    function takes about 30 solves.

    Args:
        problem: S, M and the components, n rows.
        values: v, (n,) or (n, k).
        response: F.
        tolerance: the error aimed at in the M-norm, as a share of |v - means|_M; `Filtered.share` is the error reached. Solves of
            the rational route may add 0.3 x tolerance. Rounding errors exceed a tolerance below 1e-12. Smaller takes longer.
        progress: called after every product and every few steps of a solve; may raise to stop.

    Returns:
        The filtered values, their error and the route.

    Raises:
        ConvergenceError: the systems of the rational route cannot be solved, or S is not positive semidefinite.
    """
    mass = problem.mass
    deviations, means = _split_at_means(problem, values if values.ndim == 2 else values[:, None])
    size, area = m_norm(mass, deviations), float(mass.sum())
    if size == 0.0 or area == 0.0:  # all values are the means of their components
        return Filtered(means.reshape(values.shape), 0.0, 0.0, "polynomial", 0)
    unit = deviations / size  # so that no square of a coordinate over- or underflows
    tolerance = max(tolerance, 1e-14)
    symmetric = symmetric_form(problem.dirichlet, mass)
    proven = gershgorin_bound(symmetric, mass)
    bound = min(lanczos_bound(symmetric), proven)
    series, pole = _chosen_series(response, bound, tolerance)
    error = 0.0
    dirichlet = problem.dirichlet
    order = nearby_order(symmetric, unit.shape[1] * (series.degree if pole is None else _PRODUCTS_AN_ORDER_COSTS))
    if order is not None:
        symmetric, dirichlet = (sparse.csr_matrix(each[order][:, order]) for each in (symmetric, dirichlet))
        mass, unit = mass[order], unit[order]
    if pole is not None:
        filtered, error = rational_filter(dirichlet, mass, unit, series, pole, tolerance=tolerance, progress=progress)
    else:
        attempt = polynomial_filter(symmetric, mass, unit, series, bound, progress=progress)
        if attempt is None:
            # The estimate of the largest eigenvalue was too low; the proven bound never is.
            bound = proven * (1.0 + 1e-9)
            series = polynomial_series(response, bound, tolerance=tolerance)
            attempt = polynomial_filter(symmetric, mass, unit, series, bound, progress=progress)
        if attempt is None:
            raise ConvergenceError("the recurrence of the polynomial grows: the operator is not positive semidefinite")
        filtered = attempt
    if order is not None:
        unit[order] = filtered
        filtered = unit
    share = series.error + error + _ROUNDING * (1 + series.degree)
    result = (means + size * filtered).reshape(values.shape)
    return Filtered(result, share * size / math.sqrt(area), share, "polynomial" if pole is None else "rational", series.degree)


def _chosen_series(response: Response, bound: float, tolerance: float) -> tuple[ChebyshevSeries, float | None]:
    series = polynomial_series(response, bound, tolerance=tolerance, largest_degree=MOST_PRODUCTS)
    if series.error <= 2.0 * tolerance:
        return series, None
    rational, pole = rational_series(response, tolerance=tolerance)
    if rational.error > 2.0 * tolerance:  # one pole does not suit both ends of a very wide band
        series = polynomial_series(response, bound, tolerance=tolerance)
        if series.error <= 2.0 * tolerance:
            return series, None
    return rational, pole


def _split_at_means(problem: SpectralProblem, columns: Floats) -> tuple[Floats, Floats]:
    """Splits values into deviations and the mass-weighted means of their components, both (n, k)."""
    mass, labels = problem.mass, problem.components
    weights = np.bincount(labels, mass)
    means = np.empty_like(columns)
    for c in range(columns.shape[1]):
        # The second pass corrects the rounding error of the first, which is large for coordinates far from the origin.
        mean = (np.bincount(labels, mass * columns[:, c]) / weights)[labels]
        mean += (np.bincount(labels, mass * (columns[:, c] - mean)) / weights)[labels]
        means[:, c] = mean
    return columns - means, means


#: `_POLES` poles are tried, from `_LOWEST_POLE` times the lowest squared cutoff to `_HIGHEST_POLE` times the highest one.
_LOWEST_POLE, _HIGHEST_POLE, _POLES = 0.2, 30.0, 40
_LARGEST_DEGREE = 400  # of a rational series
#: Systems of at most this many rows are factorised, which takes up to a second.
LARGEST_FACTORS = 120_000
#: The error that all solves together may add, as a share of the tolerance.
_SHARE_OF_SOLVES = 0.3


def rational_series(response: Response, *, tolerance: float) -> tuple[ChebyshevSeries, float]:
    """Returns the shortest series of a response in t = 2 sigma / (kappa + sigma) - 1 on all kappa >= 0, and its pole sigma."""
    lowest, highest = _LOWEST_POLE * response.cutoffs[0] ** 2, _HIGHEST_POLE * response.cutoffs[-1] ** 2
    series = [(_series(response, pole, tolerance), float(pole)) for pole in np.geomspace(lowest, highest, _POLES)]
    return min(series, key=lambda pair: (pair[0].error > tolerance, pair[0].degree, pair[0].error))


def rational_filter(
    dirichlet: sparse.csr_matrix,
    mass: Floats,
    values: Floats,
    series: ChebyshevSeries,
    pole: float,
    *,
    tolerance: float,
    progress: Progress,
) -> tuple[Floats, float]:
    """Applies the series of `rational_series` to (n, k) values.

    The result has the error e_k of solve k, from 0, multiplied by at most 4 sum_{j>k} |c_j| (j - k). These factors fall with k,
    so the first solves must be the most exact.

    The M-norm of the error of all solves together should be at most `_SHARE_OF_SOLVES` x tolerance x |v|_M. Returns the filtered
    values and an estimate of this norm, in the unit of the values.
    """
    c, degree = series.coefficients, series.degree
    system = _System(dirichlet, mass, pole, degree, progress)
    # With R of `_System`, T_{k+1} = 4 R T_k - 2 T_k - T_{k-1}: errors grow like Chebyshev polynomials of the second kind.
    beyond = np.cumsum(np.abs(c)[::-1])[::-1]
    amplification = 4.0 * np.cumsum(beyond[::-1])[::-1][1:]
    size = m_norm(mass, values)
    now, before, total = values.copy(), np.zeros_like(values), c[0] * values
    image, image_before = np.zeros_like(values), np.zeros_like(values)
    error = 0.0
    for k in range(degree):
        allowed = _SHARE_OF_SOLVES * tolerance * size / (degree * max(float(amplification[k]), 1e-300))
        # The guess for R T_k = 4 R R T_{k-1} - 2 R T_{k-1} - R T_{k-2} has R T_{k-1}, already smooth, in place of R R T_{k-1}.
        guess = now if k == 0 else 2.0 * image - image_before
        image_before = image
        image, solve_error = system.solve(now, guess, allowed, part_of(progress, k / degree, (k + 1) / degree))
        error += float(amplification[k]) * solve_error
        following = 2.0 * image - now
        now, before = (following if k == 0 else 2.0 * following - before), now
        total += c[k + 1] * now
        progress((k + 1) / degree)
    return total, error


class _System:
    """Applies R = sigma A^-1 M for A = S + sigma M, by Cholesky factors up to `LARGEST_FACTORS` rows, else by `SpdSolver`."""

    def __init__(self, dirichlet: sparse.csr_matrix, mass: Floats, pole: float, solves: int, progress: Progress) -> None:
        self._mass, self._pole = mass, pole
        self._matrix = sparse.csr_matrix(dirichlet + pole * sparse.diags_array(mass))
        self._factors: Cholesky | None = None
        if len(mass) <= LARGEST_FACTORS and solves > 0:
            # If rounding spoils the factors, the iterative solver takes over.
            with suppress(ConvergenceError):
                self._factors = Cholesky(self._matrix, progress=progress)
        self._solver = SpdSolver(self._matrix)

    def solve(self, values: Floats, guess: Floats, allowed: float, progress: Progress) -> tuple[Floats, float]:
        """Returns R v for the values v, and an estimate of the M-norm of its error, which should be at most `allowed`."""
        right = (self._pole * self._mass)[:, None] * values
        if self._factors is not None:
            x = self._factors.solve(right)
            error, residual = self._bound(right, x)
            if error > allowed:
                x += self._factors.solve(residual)
                error, residual = self._bound(right, x)
            if error > allowed:
                # Rounding at tiny triangles makes the bound far too large; one more correction has nearly the size of the error.
                error = min(error, m_norm(self._mass, self._factors.solve(residual)))
            return x, error
        # |e|_M <= |e|_A / sqrt(sigma), since A >= sigma M.
        root = math.sqrt(self._pole)
        reference = root * max(m_norm(self._mass, values), np.finfo(float).tiny)
        share = min(max(allowed * root / reference, FINEST_TOLERANCE), 1e-3)
        solution = self._solver.solve(right, tolerance=share, reference=reference, start=guess, progress=progress)
        return solution.values, self._bound(right, solution.values)[0] if solution.method == "cholesky" else solution.error / root

    def _bound(self, right: Floats, x: Floats) -> tuple[float, Floats]:
        """Returns a bound of the error, |A^-1 r|_M <= |r|_{M^-1} / sigma, and the residual r."""
        residual = right - self._matrix @ x
        return m_norm(1.0 / self._mass, residual) / self._pole, residual


def m_norm(mass: Floats, values: Floats) -> float:
    """The norm |v|_M = sqrt(sum_i m_i |v_i|^2), summed in a fixed order."""
    return math.sqrt(float((mass * (values * values).sum(axis=1)).sum()))


def _series(response: Response, pole: float, tolerance: float) -> ChebyshevSeries:
    def sampled(t: Floats) -> Floats:
        return response.profile(np.sqrt(pole * (1.0 - t) / (1.0 + t)))

    # With kappa = sigma tan^2(theta / 2): the narrower of two ranges, from theta = 0 to the lowest cutoff, or the highest to pi.
    root = math.sqrt(pole)
    width = 2.0 * min(math.atan(response.cutoffs[0] / root), math.atan(root / response.cutoffs[-1]))
    return chebyshev_series(sampled, tolerance=tolerance, width=width, largest_degree=_LARGEST_DEGREE)


#: `chebyshev_series` takes at least `_FIRST_SAMPLES` samples of a function, and at least `_SAMPLES_A_WIDTH` / `width`.
_FIRST_SAMPLES, _SAMPLES_A_WIDTH = 64, 16
#: Coefficients below this share of the largest coefficient are rounding errors.
_NOTHING = 1e-15


@dataclass(frozen=True, eq=False)
class ChebyshevSeries:
    """p(t) = sum_k coefficients_k T_k(t), an approximation of a function on [-1, 1]."""

    coefficients: Floats  # (degree + 1,)
    error: float  # a bound of |p - f| on [-1, 1]: the sum of |c_k| over the omitted coefficients

    @property
    def degree(self) -> int:
        return len(self.coefficients) - 1


def chebyshev_series(
    function: Callable[[Floats], Floats], *, tolerance: float, width: float, largest_degree: int
) -> ChebyshevSeries:
    """Returns the shortest Chebyshev series of a smooth function with an error bound within the tolerance.

    A cosine transform of samples at the roots of T_N gives the coefficients. N doubles until the second half of the coefficients
    sums to less than a hundredth of the tolerance, so that aliasing is negligible, or until N > 4 `largest_degree`.

    `function` takes (N,) values t in (-1, 1). Its narrowest feature spans an angle `width` of theta = arccos t; samples farther
    apart could miss it. At `largest_degree` the error may exceed the tolerance; it is infinite if `width` <= 1/`largest_degree`.
    """
    if not width * largest_degree > 1.0:
        return ChebyshevSeries(np.zeros(1), math.inf)
    samples = max(_FIRST_SAMPLES, math.ceil(_SAMPLES_A_WIDTH / width))
    while True:
        coefficients: Floats = fft.dct(function(np.cos(np.pi * (np.arange(samples) + 0.5) / samples)), type=2) / samples
        coefficients[0] *= 0.5
        sizes = np.abs(coefficients)
        second_half = float(sizes[samples // 2 :].sum())
        floor = _NOTHING * samples * float(sizes.max())
        if second_half <= max(0.01 * tolerance, floor) or samples > 4 * largest_degree:
            break
        samples *= 2
    # tails[k] is the error of a series of degree k - 1. Coefficients beyond the N computed ones sum to less than the second half.
    tails = np.append(np.cumsum(sizes[::-1])[::-1], 0.0) + second_half
    degree = min(int(np.argmax(tails[1:] <= max(tolerance, tails[-1]))), largest_degree)
    return ChebyshevSeries(coefficients[: degree + 1].copy(), float(tails[degree + 1]))


#: Rounding may raise squared norms above their bound by this factor.
_GROWTH = 1.0 + 1e-6
_CHECKED_EVERY = 16  # products between two checks of the norm
#: The highest degree that is tried.
LARGEST_DEGREE = 100_000
#: Steps of Lanczos's method, and the factor on its result.
_LANCZOS_STEPS, _MARGIN = 24, 1.02
#: A large matrix is reordered if at least the share `_SCATTERED` of its entries is more than `NEAR` columns off the diagonal,
#: and if at least `_PRODUCTS_AN_ORDER_COSTS` products with one column follow, which take as long as the reordering.
_SCATTERED = 0.2
_PRODUCTS_AN_ORDER_COSTS = 300


def polynomial_series(
    response: Response, bound: float, *, tolerance: float, largest_degree: int = LARGEST_DEGREE
) -> ChebyshevSeries:
    """Returns the series of a response on 0 <= kappa <= bound, in t = 1 - 2 kappa / bound."""

    def sampled(t: Floats) -> Floats:
        return response.profile(np.sqrt(0.5 * bound * (1.0 - t)))

    # The angle theta of the lowest cutoff, from kappa = bound sin^2(theta / 2).
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
    """Returns p(M^-1 S) v for the series that `polynomial_series` makes for `bound`.

    `symmetric` is D of `symmetric_form`, (n, n); the values v are (n, k). If D has an eigenvalue above `bound`, the recurrence
    grows, and the result is None.
    """
    n, columns = values.shape
    root = np.sqrt(mass)
    # 2 A for A = I - 2 D / b, with a diagonal entry in every row.
    doubled = sparse.csr_matrix((symmetric.data * (-4.0 / bound), symmetric.indices, symmetric.indptr), shape=symmetric.shape)
    doubled.setdiag(doubled.diagonal() + 2.0)
    groups: list[Floats] = []
    for first in range(0, columns, 3):
        start = np.zeros((n, 3))
        start[:, : min(3, columns - first)] = values[:, first : first + 3] * root[:, None]
        partial = part_of(progress, first / columns, min(1.0, (first + 3) / columns))
        summed = _sum_series(doubled, start, series.coefficients, partial)
        if summed is None:
            return None
        groups.append(summed / root[:, None])
    return np.hstack(groups)[:, :columns] if groups else np.empty((n, 0))


def _sum_series(doubled: sparse.csr_matrix, start: Floats, coefficients: Floats, progress: Progress) -> Floats | None:
    """Returns the sum of c_k T_k(A) x, given 2 A; None if the norm of T_k(A) x grows."""
    now, before = start.copy(), np.zeros_like(start)
    total: Floats = coefficients[0] * now
    allowed = _GROWTH * float((start * start).sum())
    rows = CompressedRows.of(doubled)
    degree = len(coefficients) - 1
    with threads_for(len(start)):
        for k in range(1, degree + 1):
            # T_1 = A x is half of 2 A x - 0.
            _advance(rows, now, before, total, coefficients[k], 0.5 if k == 1 else 1.0)
            now, before = before, now
            if (k % _CHECKED_EVERY == 0 or k == degree) and not float((now * now).sum()) <= allowed:
                return None
            progress(k / degree)
    return total


# The compiler would test a signed index for being negative, which takes half of the time. Fusing products and sums halves the
# time again, and is more exact.
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
    """Sets `before` to factor * (B now) - before, then adds coefficient * before to `total`, in one pass over the rows of B."""
    for row in prange(now.shape[0]):
        i = np.uint64(row)
        x, y, z = fused_row_product(matrix, i, now)
        x, y, z = factor * x - before[i, 0], factor * y - before[i, 1], factor * z - before[i, 2]
        before[i, 0], before[i, 1], before[i, 2] = x, y, z
        total[i, 0] += coefficient * x
        total[i, 1] += coefficient * y
        total[i, 2] += coefficient * z


def symmetric_form(dirichlet: sparse.csr_matrix, mass: Floats) -> sparse.csr_matrix:
    """Returns D = M^-1/2 S M^-1/2, (n, n), which has the eigenvalues of M^-1 S."""
    inverse_root = 1.0 / np.sqrt(mass)
    data = dirichlet.data * (np.repeat(inverse_root, np.diff(dirichlet.indptr)) * inverse_root[dirichlet.indices])
    return sparse.csr_matrix((data, dirichlet.indices, dirichlet.indptr), shape=dirichlet.shape)


def gershgorin_bound(symmetric: sparse.csr_matrix, mass: Floats) -> float:
    """Gershgorin's upper bound of the largest eigenvalue of M^-1 S; on regular triangles it is 4/3 of that eigenvalue."""
    root = np.sqrt(mass)
    return float((abs(symmetric) @ root / root).max(initial=0.0))


def lanczos_bound(symmetric: sparse.csr_matrix) -> float:
    """Estimates an upper bound of the largest eigenvalue: the largest Ritz value plus its residual, times 1.02.

    After 24 steps from a random start the Ritz value is about a percent too low if the largest eigenvalues are close together,
    and exact if the largest stands out. `polynomial_filter` detects an estimate that is too low. The result is infinite for small
    matrices, and if the method ends early, because the start may then lack some modes.
    """
    n = symmetric.shape[0]
    if n < 4 * _LANCZOS_STEPS:
        return math.inf
    q = np.random.default_rng(0).uniform(-1.0, 1.0, n)
    q /= math.sqrt(float((q * q).sum()))
    before = np.zeros(n)
    diagonal, off = np.zeros(_LANCZOS_STEPS), np.zeros(_LANCZOS_STEPS)
    beta = 0.0
    for k in range(_LANCZOS_STEPS):
        w = symmetric @ q - beta * before
        # NumPy's sums have a fixed order; BLAS would divide an inner product among its threads.
        diagonal[k] = alpha = float((w * q).sum())
        w -= alpha * q
        off[k] = beta = math.sqrt(float((w * w).sum()))
        if beta <= 1e-12 * abs(diagonal[: k + 1]).max():
            return math.inf
        before, q = q, w / beta
    ritz, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(off[:-1], 1) + np.diag(off[:-1], -1))
    return _MARGIN * (float(ritz[-1]) + abs(beta * float(vectors[-1, -1])))


def nearby_order(matrix: sparse.csr_matrix, products: int) -> Ints | None:
    """(n,) the rows in reverse Cuthill-McKee order, which puts entries near the diagonal; None if that does not pay."""
    n = matrix.shape[0]
    if n < FITS_IN_CACHE or products < _PRODUCTS_AN_ORDER_COSTS:
        return None
    rows = np.repeat(np.arange(n, dtype=matrix.indices.dtype), np.diff(matrix.indptr))
    if (np.abs(rows - matrix.indices) > NEAR).mean() < _SCATTERED:
        return None
    return np.asarray(sparse.csgraph.reverse_cuthill_mckee(matrix, symmetric_mode=True), dtype=np.int32)

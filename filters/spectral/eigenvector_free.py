"""Spectral filters without eigenvectors, by a polynomial or a rational function of the operator."""

import math
from contextlib import suppress
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ..checks import ConvergenceError, FilterInputError
from ..execution import Progress, ignore_progress, part_of
from ..libraries import sparse
from ..linear_solvers import FINEST_TOLERANCE, Cholesky, SpdSolver
from ..mesh import Floats
from .polynomial import (
    LARGEST_DEGREE,
    ChebyshevSeries,
    chebyshev_series,
    gershgorin_bound,
    lanczos_bound,
    nearby_order,
    polynomial_filter,
    polynomial_series,
    put_back,
    symmetric_form,
)
from .problem import SpectralProblem
from .responses import Response

RouteName: TypeAlias = Literal["polynomial", "rational"]
#: A polynomial of a higher degree takes longer than a rational function with factors; see docs/solvers.md.
MOST_PRODUCTS = 1_000
#: Rounding in sums of this many terms, as a share of the result, per degree.
_ROUNDING = 8.0 * float(np.finfo(float).eps)


class Filtered(NamedTuple):
    """The result of `filter_without_eigenvectors`."""

    values: Floats  # of the shape of the input
    # of the error's root mean square over the surface, sqrt(|e|_M^2 / area), over all columns, in the unit of the values: a bound
    # for the polynomial; for the rational function a bound plus an estimate of the error of the solves
    error: float
    share: float  # the error as a share of the root mean square of the values about the means of their components
    route: RouteName
    degree: int  # how many products with the matrix, or solves, it took for every three columns


def filter_without_eigenvectors(
    problem: SpectralProblem,
    values: Floats,
    response: Response,
    *,
    tolerance: float = 1e-5,
    route: Literal["auto"] | RouteName = "auto",
    progress: Progress = ignore_progress,
) -> Filtered:
    """F(sqrt(M^-1 S)) v: every mode in v times the response at its frequency.

    The mean of each component is taken out first and put back, exactly.

    Args:
        problem: S, M and the components, n rows.
        values: (n,) or (n, k), finite.
        response: F.
        tolerance: of the error in the M-norm, as a share of |v|_M about the means; solves may add a third. Below 1e-12 it
            is rounding. The time grows with the logarithm of 1 / tolerance.
        route: "polynomial": products with S, about as many as the shortest wave that stays is long in edges, and more with thin
            triangles. "rational": about 30 solves. "auto": a polynomial; a rational function where its degree would pass
            `MOST_PRODUCTS`.
        progress: called after every product or some steps of a solve; may raise to stop.

    Returns:
        The values with the error and the route; the same to the bit for any number of threads.

    Raises:
        FilterInputError: a polynomial of an excessive degree.
        ConvergenceError: the systems of the rational route cannot be solved.
    """
    mass = problem.mass
    deviations, means = _about_means(problem, values if values.ndim == 2 else values[:, None])
    size, area = m_norm(mass, deviations), float(mass.sum())
    if size == 0.0 or area == 0.0:  # all values are the means of their components
        return Filtered(means.reshape(values.shape), 0.0, 0.0, "polynomial", 0)
    unit = deviations / size  # so that no square of a coordinate over- or underflows
    tolerance = max(tolerance, 1e-14)
    symmetric = symmetric_form(problem.dirichlet, mass)
    proven = gershgorin_bound(symmetric, mass)
    bound = min(lanczos_bound(symmetric), proven)
    series, pole = _planned(response, bound, tolerance, route)
    error = 0.0
    if pole is not None:
        filtered, error = rational_filter(problem.dirichlet, mass, unit, series, pole, tolerance=tolerance, progress=progress)
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
    share = series.error + error + _ROUNDING * (1 + series.degree)
    result = (means + size * filtered).reshape(values.shape)
    return Filtered(result, share * size / math.sqrt(area), share, "polynomial" if pole is None else "rational", series.degree)


def _planned(
    response: Response, bound: float, tolerance: float, route: Literal["auto"] | RouteName
) -> tuple[ChebyshevSeries, float | None]:
    """A polynomial, or a rational function and its pole."""
    if route != "rational":
        most = MOST_PRODUCTS if route == "auto" else LARGEST_DEGREE
        series = polynomial_series(response, bound, tolerance=tolerance, largest_degree=most)
        if series.error <= 2.0 * tolerance:
            return series, None
        if route == "polynomial":
            raise FilterInputError(
                f"a polynomial of degree {LARGEST_DEGREE} still has an error of {series.error:.3g}: the mesh has too "
                "thin triangles for the wavelength; take the rational route or the robust operator"
            )
    rational, pole = rational_series(response, tolerance=tolerance)
    if route == "auto" and rational.error > 2.0 * tolerance:  # a band of a thousand lengths, whose ends one pole does not reach
        series = polynomial_series(response, bound, tolerance=tolerance)
        if series.error <= 2.0 * tolerance:
            return series, None
    return rational, pole


def _about_means(problem: SpectralProblem, columns: Floats) -> tuple[Floats, Floats]:
    """The values less the mean of their component, weighted by mass, and these means, both (n, k)."""
    mass, labels = problem.mass, problem.components
    weights = np.bincount(labels, mass)
    means = np.empty_like(columns)
    for c in range(columns.shape[1]):
        # Twice, so that the rest of the mean is rounding of the deviations rather than of coordinates far from the origin.
        mean = (np.bincount(labels, mass * columns[:, c]) / weights)[labels]
        mean += (np.bincount(labels, mass * (columns[:, c] - mean)) / weights)[labels]
        means[:, c] = mean
    return columns - means, means


#: Poles are tried from the lowest squared cutoff times the first factor to the highest times the second, this many.
_LOWEST_POLE, _HIGHEST_POLE, _POLES = 0.2, 30.0, 40
_LARGEST_DEGREE = 400
#: Systems of at most this many rows are factorised, which takes up to a second.
LARGEST_FACTORS = 120_000
#: The share of the tolerance that the solves may use.
_SHARE_OF_SOLVES = 0.3


def rational_series(response: Response, *, tolerance: float) -> tuple[ChebyshevSeries, float]:
    """The shortest series in t = 2 sigma / (kappa + sigma) - 1 of a response on all kappa from 0, and its sigma."""
    lowest, highest = _LOWEST_POLE * response.cutoffs[0] ** 2, _HIGHEST_POLE * response.cutoffs[-1] ** 2
    series = [(_series(response, pole, tolerance), float(pole)) for pole in np.geomspace(lowest, highest, _POLES)]
    return min(series, key=lambda pair: (pair[0].error > tolerance, pair[0].degree, pair[0].error))


def rational_filter(
    dirichlet: "sparse.csr_matrix",
    mass: Floats,
    values: Floats,
    series: ChebyshevSeries,
    pole: float,
    *,
    tolerance: float,
    progress: Progress = ignore_progress,
) -> tuple[Floats, float]:
    """The series of `rational_series` applied to (n, k) values.

    An error e_k of the k-th solve enters all later terms, multiplied by at most 4 sum_{j>k} |c_j| (j - k). These factors fall
    with k, so the first solves have to be the most exact.

    Args:
        dirichlet: S, (n, n).
        mass: (n,), above 0.
        values: v, (n, k).
        series: of degree d.
        pole: sigma, in the unit of kappa.
        tolerance: of the error in the M-norm by all solves together, as a share of |v|_M.
        progress: called during the solves; may raise to stop.

    Returns:
        The filtered values, and an estimate of the error by the solves in the M-norm, not as a share.

    Raises:
        ConvergenceError: a system cannot be solved.
    """
    order = None if series.degree == 0 or len(mass) <= LARGEST_FACTORS else nearby_order(dirichlet, values.shape[1] * 300)
    if order is not None:
        dirichlet, mass, values = sparse.csr_matrix(dirichlet[order][:, order]), mass[order], values[order]
    c, degree = series.coefficients, series.degree
    system = _System(dirichlet, mass, pole, degree, progress)
    # 4 sum_{j > k} |c_j| (j - k): R enters T_{k+1} four times, and the rest grows as the polynomials U do.
    beyond = np.cumsum(np.abs(c)[::-1])[::-1]
    amplification = 4.0 * np.cumsum(beyond[::-1])[::-1][1:]
    size = m_norm(mass, values)
    now, before, total = values.copy(), np.zeros_like(values), c[0] * values
    image, image_before = np.zeros_like(values), np.zeros_like(values)
    error = 0.0
    for k in range(degree):
        allowed = _SHARE_OF_SOLVES * tolerance * size / (degree * max(float(amplification[k]), 1e-300))
        # R T_k = 4 R R T_{k-1} - 2 R T_{k-1} - R T_{k-2}, and R changes little in values that it was applied to before.
        guess = now if k == 0 else 2.0 * image - image_before
        image_before = image
        image, missed = system.solve(now, guess, allowed, part_of(progress, k / degree, (k + 1) / degree))
        error += float(amplification[k]) * missed
        following = 2.0 * image - now
        now, before = (following if k == 0 else 2.0 * following - before), now
        total += c[k + 1] * now
        progress((k + 1) / degree)
    return total if order is None else put_back(total, order), error


class _System:
    """Solves A x = sigma M b for A = S + sigma M, by factors up to `LARGEST_FACTORS` rows, else by multigrid."""

    def __init__(self, dirichlet: "sparse.csr_matrix", mass: Floats, pole: float, solves: int, progress: Progress) -> None:
        self._mass, self._pole = mass, pole
        self._matrix = sparse.csr_matrix(dirichlet + pole * sparse.diags_array(mass))
        self._factors: Cholesky | None = None
        if len(mass) <= LARGEST_FACTORS and solves > 0:
            # If rounding spoils the factors the iterative solver takes over.
            with suppress(ConvergenceError):
                self._factors = Cholesky(self._matrix, progress=progress)
        self._solver = SpdSolver(self._matrix)

    def solve(self, values: Floats, guess: Floats, allowed: float, progress: Progress) -> tuple[Floats, float]:
        """R b, and its error in the M-norm, which is to be at most `allowed`."""
        right = (self._pole * self._mass)[:, None] * values
        if self._factors is not None:
            x = self._factors.solve(right)
            residual = right - self._matrix @ x
            if self._bound(residual) > allowed:
                x += self._factors.solve(residual)
                residual = right - self._matrix @ x
            error = self._bound(residual)
            if error > allowed:
                # Rounding at tiny triangles makes that bound far too large; the size of a further correction is closer.
                error = min(error, m_norm(self._mass, self._factors.solve(residual)))
            return x, error
        # |e|_M <= |e|_A / sqrt(sigma), since A >= sigma M.
        root = math.sqrt(self._pole)
        reference = root * max(m_norm(self._mass, values), np.finfo(float).tiny)
        share = min(max(allowed * root / reference, FINEST_TOLERANCE), 1e-3)
        solution = self._solver.solve(right, tolerance=share, reference=reference, start=guess, progress=progress)
        if solution.method == "cholesky":
            return solution.values, self._bound(right - self._matrix @ solution.values)
        return solution.values, solution.error / root

    def _bound(self, residual: Floats) -> float:
        """|A^-1 r|_M <= |r|_{M^-1} / sigma."""
        return m_norm(1.0 / self._mass, residual) / self._pole


def m_norm(mass: Floats, values: Floats) -> float:
    """|v|_M = sqrt(sum_i m_i |v_i|^2), summed in a fixed order."""
    return math.sqrt(float((mass * (values * values).sum(axis=1)).sum()))


def _series(response: Response, pole: float, tolerance: float) -> ChebyshevSeries:
    def sampled(t: Floats) -> Floats:
        return response.profile(np.sqrt(pole * (1.0 - t) / (1.0 + t)))

    # kappa = sigma tan^2(theta / 2): the angles of the lowest cutoff from 0 and of the highest from pi.
    root = math.sqrt(pole)
    width = 2.0 * min(math.atan(response.cutoffs[0] / root), math.atan(root / response.cutoffs[-1]))
    return chebyshev_series(sampled, tolerance=tolerance, width=width, largest_degree=_LARGEST_DEGREE)

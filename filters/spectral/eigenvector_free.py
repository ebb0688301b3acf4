"""Spectral filters without eigenvectors, by a polynomial or a rational function of the operator."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from ..checks import ConvergenceError, FilterInputError, check_choice, check_positive
from ..execution import Progress, ignore_progress
from ..mesh import Floats
from .chebyshev import ChebyshevSeries
from .polynomial import LARGEST_DEGREE, gershgorin_bound, lanczos_bound, polynomial_filter, polynomial_series, symmetric_form
from .problem import SpectralProblem
from .rational import LARGEST_FACTORS, m_norm, rational_filter, rational_series
from .responses import Response

RouteName: TypeAlias = Literal["polynomial", "rational"]
ROUTE_NAMES: tuple[RouteName, ...] = get_args(RouteName)
#: Measured seconds per row with three columns on one thread: a product, making Cholesky's factors, a solve with them, a solve by
#: multigrid. Only their ratios matter; see docs/solvers.md.
_PRODUCT, _FACTORS, _FACTOR_SOLVE, _MULTIGRID_SOLVE = 1.2e-8, 9e-6, 2.5e-7, 2.5e-6
#: Rounding in sums of this many terms, as a share of the result, per degree.
_ROUNDING = 8.0 * float(np.finfo(float).eps)


class Filtered(NamedTuple):
    """What `filter_without_eigenvectors` returns.

    Attributes:
        values: of the shape of what was filtered.
        error_bound: of the error's root mean square over the surface, sqrt(|e|_M^2 / area), over all columns, in the unit of the
            values.
        route: how it was computed.
    """

    values: Floats
    error_bound: float
    route: Route


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

    The mean of each component is taken out first and put back multiplied by the response's `constant`, exactly.

    Args:
        problem: S, M and the components, n rows.
        values: (n,) or (n, k), finite.
        response: F.
        tolerance: of the error in the M-norm, as a share of |v|_M about the means; solves may add a third. Below 1e-12 it
            is rounding. The time grows with the logarithm of 1 / tolerance.
        route: "polynomial": products with S, about as many as the shortest wave that stays is long in edges, and more with thin
            triangles. "rational": about 30 solves. "auto": what is predicted to be faster.
        progress: called after every product or some steps of a solve; may raise to stop.

    Returns:
        The values with the error bound and the route; the same to the bit for any number of threads.

    Raises:
        FilterInputError: values of another shape or not finite, a tolerance not above 0, an unknown route, or a polynomial of
            an excessive degree.
        ConvergenceError: the systems of the rational route cannot be solved.
    """
    check_choice("route", route, ("auto", *ROUTE_NAMES))
    check_positive("tolerance", tolerance)
    columns = _columns(values, len(problem.mass))
    deviations, means = _about_means(problem, columns)
    size = m_norm(problem.mass, deviations)
    area = float(problem.mass.sum())
    planned = Plan(problem, response, max(tolerance, 1e-14), route)
    if size == 0.0 or area == 0.0:
        unneeded = Route(planned.route, 0, 0.0, 0.0, "all values are the means of their components")
        return Filtered((response.constant * means).reshape(values.shape), 0.0, unneeded)
    # Of unit norm, so that no square of a coordinate over- or underflows.
    filtered, share, largest = planned.run(deviations / size, progress)
    result = response.constant * means + size * filtered
    done = Route(planned.route, planned.degree, share, size * largest, planned.reason)
    return Filtered(result.reshape(values.shape), share * size / math.sqrt(area), done)


def _columns(values: Floats, n: int) -> Floats:
    if values.ndim not in (1, 2) or len(values) != n or not np.isfinite(values).all():
        raise FilterInputError(f"values must be finite and have a row for each of {n} vertices, got shape {values.shape}")
    columns = np.asarray(values, dtype=np.float64)
    return columns if columns.ndim == 2 else columns[:, None]


def _about_means(problem: SpectralProblem, columns: Floats) -> tuple[Floats, Floats]:
    """The values less the mean of their component, weighted by mass, and these means, both (n, k)."""
    mass, labels = problem.mass, problem.components
    weights = np.bincount(labels, mass)
    means = np.empty_like(columns)
    for c in range(columns.shape[1]):
        # Twice, so that what is left of the mean is rounding of the deviations rather than of coordinates far from the origin.
        mean = (np.bincount(labels, mass * columns[:, c]) / weights)[labels]
        mean += (np.bincount(labels, mass * (columns[:, c] - mean)) / weights)[labels]
        means[:, c] = mean
    return columns - means, means


@dataclass(frozen=True)
class Route:
    """How a filter was computed.

    Attributes:
        name: "polynomial" or "rational".
        degree: how many products with the matrix, or solves, it took for every three columns.
        share: of the error in |v|_M, v the values about the means of their components: a bound for the polynomial; for the
            rational function a bound plus an estimate of the error of the solves.
        largest_error: an estimate of the largest error at a vertex, in the unit of the values.
        reason: why this route was taken.
    """

    name: RouteName
    degree: int
    share: float
    largest_error: float
    reason: str

    def __str__(self) -> str:
        if self.name == "polynomial":
            how = f"a polynomial of degree {self.degree}"
        else:
            how = f"a rational function of degree {self.degree} with one pole"
        return f"{how} with an error of at most {self.share:.1g} of the root mean square, since {self.reason}"


class Plan:
    """Both routes with their degrees and errors, which depend on the response and bounds of the spectrum, and the choice.

    Attributes:
        route: the route that is taken.
        reason: why.
    """

    def __init__(
        self, problem: SpectralProblem, response: Response, tolerance: float, route: Literal["auto"] | RouteName
    ) -> None:
        """Plans a filter.

        Args:
            problem: of n rows.
            response: of the filter.
            tolerance: of the error, as a share of the M-norm of the values.
            route: what was asked for.

        Raises:
            FilterInputError: a polynomial was asked for and would need an excessive degree.
        """
        self._problem, self._response, self._tolerance = problem, response, tolerance
        self._rational, self._pole = rational_series(response, tolerance=tolerance)
        n = len(problem.mass)
        self._symmetric = symmetric_form(problem.dirichlet, problem.mass)
        self._proven = gershgorin_bound(self._symmetric, problem.mass)
        self._bound = min(lanczos_bound(self._symmetric), self._proven) if n else 0.0
        solves = _solving_time(n, self._rational.degree)
        exact = self._rational.error <= 2.0 * tolerance
        # On thin triangles a polynomial takes a hundred times as many products as that: its samples alone would fill memory.
        useful = min(LARGEST_DEGREE, int(solves / (_PRODUCT * n)) + 1) if exact and n and route == "auto" else LARGEST_DEGREE
        self._polynomial = self._series(useful)
        products = self.degree_of("polynomial") * _PRODUCT * n
        fits = self._polynomial.error <= 2.0 * tolerance
        if route == "polynomial" and not fits:
            raise FilterInputError(
                f"a polynomial of degree {LARGEST_DEGREE} has an error of {self._polynomial.error:.3g} still: the mesh has too "
                "thin triangles for the wavelength; take the rational route or the robust operator"
            )
        faster: RouteName = "polynomial" if fits and (products <= solves or not exact) else "rational"
        self.route: RouteName = faster if route == "auto" else route
        other: RouteName = "rational" if self.route == "polynomial" else "polynomial"
        possible = exact if other == "rational" else fits
        seconds = {"polynomial": products, "rational": solves}
        if route != "auto":
            self.reason = "it was asked for"
        elif possible:
            self.reason = (
                f"its predicted time is {seconds[self.route]:.2g} s, that of a {other} one of degree {self.degree_of(other)} "
                f"{seconds[other]:.2g} s"
            )
        else:
            tried = f"up to degree {useful}, which takes as long," if useful < LARGEST_DEGREE else "of a degree that is tried"
            self.reason = f"no {other} function {tried} meets the tolerance"

    @property
    def degree(self) -> int:
        """The degree of the chosen route."""
        return self.degree_of(self.route)

    def degree_of(self, route: RouteName) -> int:
        """The degree of one of the two."""
        return (self._polynomial if route == "polynomial" else self._rational).degree

    def run(self, values: Floats, progress: Progress) -> tuple[Floats, float, float]:
        """The filtered values of unit norm, a bound of the error in the M-norm, an estimate of the largest error at a vertex."""
        problem, tolerance = self._problem, self._tolerance
        rounding = _ROUNDING * (1 + self.degree)
        if self.route == "rational":
            applied, error = rational_filter(
                problem.dirichlet, problem.mass, values, self._rational, self._pole, tolerance=tolerance, progress=progress
            )
            return applied.values, self._rational.error + error + rounding, applied.largest_error
        done = polynomial_filter(self._symmetric, problem.mass, values, self._polynomial, self._bound, progress=progress)
        if done is None:
            # The estimate of the largest eigenvalue was too low; the proven bound never is.
            self._bound = self._proven * (1.0 + 1e-9)
            self._polynomial = self._series()
            done = polynomial_filter(self._symmetric, problem.mass, values, self._polynomial, self._bound, progress=progress)
        if done is None:
            raise ConvergenceError("the recurrence of the polynomial grows: the operator is not positive semidefinite")
        return done.values, self._polynomial.error + rounding, done.largest_error

    def _series(self, largest_degree: int = LARGEST_DEGREE) -> ChebyshevSeries:
        return polynomial_series(self._response, self._bound, tolerance=self._tolerance, largest_degree=largest_degree)


def _solving_time(n: int, solves: int) -> float:
    if n <= LARGEST_FACTORS:
        return n * (_FACTORS + solves * _FACTOR_SOLVE)
    return n * solves * _MULTIGRID_SOLVE

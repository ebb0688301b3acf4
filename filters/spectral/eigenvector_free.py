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
from .rational import m_norm, rational_filter, rational_series
from .responses import Response

RouteName: TypeAlias = Literal["polynomial", "rational"]
ROUTE_NAMES: tuple[RouteName, ...] = get_args(RouteName)
#: A polynomial of a higher degree takes longer than a rational function with factors; see docs/solvers.md.
MOST_PRODUCTS = 1_000
#: Rounding in sums of this many terms, as a share of the result, per degree.
_ROUNDING = 8.0 * float(np.finfo(float).eps)


class Filtered(NamedTuple):
    """The result of `filter_without_eigenvectors`.

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
            triangles. "rational": about 30 solves. "auto": a polynomial; a rational
            function where its degree would pass `MOST_PRODUCTS`.
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
        # Twice, so that the rest of the mean is rounding of the deviations rather than of coordinates far from the origin.
        mean = (np.bincount(labels, mass * columns[:, c]) / weights)[labels]
        mean += (np.bincount(labels, mass * (columns[:, c] - mean)) / weights)[labels]
        means[:, c] = mean
    return columns - means, means


@dataclass(frozen=True)
class Route:
    """The route of a filter.

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
    """A polynomial; a rational function where the degree would pass `MOST_PRODUCTS`.

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
            route: "auto" for the rule above, or one of the routes.

        Raises:
            FilterInputError: route "polynomial" with an excessive degree.
        """
        self._problem, self._response, self._tolerance = problem, response, tolerance
        self._symmetric = symmetric_form(problem.dirichlet, problem.mass)
        self._proven = gershgorin_bound(self._symmetric, problem.mass)
        self._bound = min(lanczos_bound(self._symmetric), self._proven) if len(problem.mass) else 0.0
        self.route: RouteName = "rational" if route == "rational" else "polynomial"
        self.reason = "it was asked for" if route != "auto" else f"at most {MOST_PRODUCTS:,} products are enough"
        if route == "rational":
            self._series, self._pole = rational_series(response, tolerance=tolerance)
            return
        self._series = self._polynomial(LARGEST_DEGREE if route == "polynomial" else MOST_PRODUCTS)
        if self._is_exact:
            return
        if route == "polynomial":
            raise FilterInputError(
                f"a polynomial of degree {LARGEST_DEGREE} has an error of {self._series.error:.3g} still: the mesh has too "
                "thin triangles for the wavelength; take the rational route or the robust operator"
            )
        self.route, self.reason = "rational", f"a polynomial would take more than {MOST_PRODUCTS:,} products"
        self._series, self._pole = rational_series(response, tolerance=tolerance)
        if not self._is_exact:  # a band of a thousand lengths, whose ends one pole does not reach
            rational, self._series = self._series, self._polynomial(LARGEST_DEGREE)
            if self._is_exact:
                self.route, self.reason = "polynomial", "no rational function with one pole meets the tolerance"
            else:
                self._series = rational

    @property
    def degree(self) -> int:
        """The degree of the polynomial or the rational function."""
        return self._series.degree

    def run(self, values: Floats, progress: Progress) -> tuple[Floats, float, float]:
        """The filtered values of unit norm, a bound of the error in the M-norm, an estimate of the largest error at a vertex."""
        problem, tolerance = self._problem, self._tolerance
        rounding = _ROUNDING * (1 + self.degree)
        if self.route == "rational":
            applied, error = rational_filter(
                problem.dirichlet, problem.mass, values, self._series, self._pole, tolerance=tolerance, progress=progress
            )
            return applied.values, self._series.error + error + rounding, applied.largest_error
        done = polynomial_filter(self._symmetric, problem.mass, values, self._series, self._bound, progress=progress)
        if done is None:
            # The estimate of the largest eigenvalue was too low; the proven bound never is.
            self._bound = self._proven * (1.0 + 1e-9)
            self._series = self._polynomial(LARGEST_DEGREE)
            done = polynomial_filter(self._symmetric, problem.mass, values, self._series, self._bound, progress=progress)
        if done is None:
            raise ConvergenceError("the recurrence of the polynomial grows: the operator is not positive semidefinite")
        return done.values, self._series.error + rounding, done.largest_error

    @property
    def _is_exact(self) -> bool:
        return self._series.error <= 2.0 * self._tolerance

    def _polynomial(self, largest_degree: int) -> ChebyshevSeries:
        return polynomial_series(self._response, self._bound, tolerance=self._tolerance, largest_degree=largest_degree)

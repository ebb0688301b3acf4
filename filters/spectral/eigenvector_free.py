"""Spectral filters without eigenvectors: which of two ways is the cheaper, and how exact it was."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from ..checks import ConvergenceError, FilterInputError
from ..execution import Progress, ignore_progress
from ..mesh import Floats
from .chebyshev import ChebyshevSeries
from .polynomial import LARGEST_DEGREE, gershgorin_bound, lanczos_bound, polynomial_filter, polynomial_series, symmetric_form
from .problem import SpectralProblem
from .rational import LARGEST_FACTORS, m_norm, rational_filter, rational_series
from .responses import Response

RouteName: TypeAlias = Literal["polynomial", "rational"]
ROUTE_NAMES: tuple[RouteName, ...] = get_args(RouteName)

# Seconds a row with three columns, measured on one thread: of a product, of making Cholesky's factors and of a solve with
# them, and of a solve by multigrid.
_PRODUCT, _FACTORS, _FACTOR_SOLVE, _MULTIGRID_SOLVE = 1.2e-8, 9e-6, 2.5e-7, 2.5e-6
#: Rounding in sums of this many terms, as a share of the result, per degree.
_ROUNDING = 8.0 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class Route:
    """How a filter was computed.

    Attributes:
        name: "polynomial" or "rational".
        degree: how many products with the matrix, or solves, it took for every three columns.
        share: of the error in |v|_M, v the values about the means of their components: a bound for the polynomial, for the
            rational function with an estimate of what the solves add.
        largest_error: an estimate of the largest error at a vertex, in the unit of the values.
        reason: why this one.
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


class Filtered(NamedTuple):
    """What `filter_without_eigenvectors` returns.

    Attributes:
        values: of the shape of what was filtered.
        error_bound: of the error's root mean square over the surface, sqrt(|e|_M^2 / area), over all columns, in the unit of the
            values.
        route: how.
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
        tolerance: of the error in the M-norm, as a share of |v|_M about the means; solves may add a third. Below
            1e-12 it is rounding. Smaller takes longer, by its logarithm.
        route: "polynomial": products with S, as many as the waves to be cut off are long in edges, and more where triangles are
            thin. "rational": solves, about 30. "auto": what is predicted to be faster.
        progress: called after every product or some steps of a solve; may raise to stop.

    Returns:
        The values with the error bound and the route; the same to the bit for any number of threads.

    Raises:
        FilterInputError: values of another shape or not finite, a tolerance not above 0, an unknown route, or a polynomial of
            an excessive degree.
        ConvergenceError: the systems of the rational route cannot be solved.
    """
    if route not in ("auto", *ROUTE_NAMES):
        raise FilterInputError(f"route {route!r} is not one of 'auto', {', '.join(map(repr, ROUTE_NAMES))}")
    if not (math.isfinite(tolerance) and tolerance > 0.0):
        raise FilterInputError(f"tolerance {tolerance} is not finite and above 0")
    columns = _columns(values, len(problem.mass))
    deviations, means = _about_means(problem, columns)
    size = m_norm(problem.mass, deviations)
    area = float(problem.mass.sum())
    planned = _Plan(problem, response, max(tolerance, 1e-14), route)
    if size == 0.0 or area == 0.0:
        unneeded = Route(planned.route, 0, 0.0, 0.0, "all values are the means of their components")
        return Filtered((response.constant * means).reshape(values.shape), 0.0, unneeded)
    # Of unit norm, so that no square of a coordinate over- or underflows.
    filtered, share, largest = planned.run(deviations / size, progress)
    result = response.constant * means + size * filtered
    done = Route(planned.route, planned.degree, share, size * largest, planned.reason)
    return Filtered(result.reshape(values.shape), share * size / math.sqrt(area), done)


class _Plan:
    """Both ways as far as scalars tell, and the choice between them."""

    def __init__(
        self, problem: SpectralProblem, response: Response, tolerance: float, route: Literal["auto"] | RouteName
    ) -> None:
        self._problem, self._response, self._tolerance = problem, response, tolerance
        self._rational, self._pole = rational_series(response, tolerance=tolerance)
        n = len(problem.mass)
        self._symmetric = symmetric_form(problem.dirichlet, problem.mass)
        self._certain = gershgorin_bound(self._symmetric, problem.mass)
        self._bound = min(lanczos_bound(self._symmetric), self._certain) if n else 0.0
        self._polynomial = self._series()
        products = self.degree_of("polynomial") * _PRODUCT * n
        solves = _solving_time(n, self._rational.degree)
        fits = self._polynomial.error <= 2.0 * tolerance
        exact = self._rational.error <= 2.0 * tolerance
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
            self.reason = f"no {other} function of a degree that is tried holds the tolerance"

    @property
    def degree(self) -> int:
        """Of the chosen one."""
        return self.degree_of(self.route)

    def degree_of(self, route: RouteName) -> int:
        """Of one of the two."""
        return (self._polynomial if route == "polynomial" else self._rational).degree

    def run(self, values: Floats, progress: Progress) -> tuple[Floats, float, float]:
        """The filtered values of unit norm, the bound of the error's M-norm, the estimate of its largest value at a vertex."""
        problem, tolerance = self._problem, self._tolerance
        rounding = _ROUNDING * (1 + self.degree)
        if self.route == "rational":
            applied, error = rational_filter(
                problem.dirichlet, problem.mass, values, self._rational, self._pole, tolerance=tolerance, progress=progress
            )
            return applied.values, self._rational.error + error + rounding, applied.largest_error
        done = polynomial_filter(self._symmetric, problem.mass, values, self._polynomial, self._bound, progress=progress)
        if done is None:
            # The estimate of the largest eigenvalue was too low; a certain one never is.
            self._bound = self._certain * (1.0 + 1e-9)
            self._polynomial = self._series()
            done = polynomial_filter(self._symmetric, problem.mass, values, self._polynomial, self._bound, progress=progress)
        if done is None:
            raise ConvergenceError("the recurrence of the polynomial grows: the stiffness matrix is not positive semidefinite")
        return done.values, self._polynomial.error + rounding, done.largest_error

    def _series(self) -> ChebyshevSeries:
        return polynomial_series(self._response, self._bound, tolerance=self._tolerance)


def _solving_time(n: int, solves: int) -> float:
    if n <= LARGEST_FACTORS:
        return n * (_FACTORS + solves * _FACTOR_SOLVE)
    return n * solves * _MULTIGRID_SOLVE


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

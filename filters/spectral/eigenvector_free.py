"""Spectral filters without eigenvectors, by a polynomial or a rational function of the operator."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from ..checks import FilterInputError, check_choice, check_positive
from ..execution import Progress, ignore_progress
from ..mesh import Floats
from .problem import SpectralProblem
from .rational import m_norm
from .responses import Response
from .routes import ROUTE_NAMES, Plan, Route, RouteName


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

"""Spectral filters by modes: as many as a smooth response needs, or a given number with a sharp cutoff."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..checks import FilterInputError
from ..execution import Progress, ignore_progress, rising
from ..mesh import Floats
from .eigenpairs import lowest_eigenpairs
from .problem import SpectralProblem
from .responses import Response

#: The largest size of a basis, in numbers: 0.8 GB.
LARGEST_BASIS = 100_000_000
#: The factor on the number of modes by Weyl's law, which leaves out a term that grows with the border.
_MARGIN = 1.15


class FilteredByModes(NamedTuple):
    """The result of a filter by modes.

    Attributes:
        values: (n, 3).
        error: bound of the root mean square error over the surface, in the unit of the values.
        modes: how many were computed, without those that are constant on a component.
        last_frequency: the frequency of the last one, 0 if there is none.
    """

    values: Floats
    error: float
    modes: int
    last_frequency: float


def basis_fits(problem: SpectralProblem, count: int) -> bool:
    """Whether so many modes fit into 0.8 GB."""
    return min(count, most_modes(problem)) * len(problem.mass) <= LARGEST_BASIS


def most_modes(problem: SpectralProblem) -> int:
    """How many modes there are, without those that are constant on a component."""
    return len(problem.mass) - problem.n_components


def filter_by_modes(
    problem: SpectralProblem, values: Floats, response: Response, *, tolerance: float, progress: Progress = ignore_progress
) -> FilteredByModes:
    """F(infinity) v + V (F - F(infinity)) V^T M v, with the modes V up to the frequency where F has nearly reached its limit.

    Args:
        problem: of n rows.
        values: v, (n, 3), of mean 0 on every component.
        response: F.
        tolerance: the most that F may differ from its limit at modes that are left out. Smaller takes more modes.
        progress: told the share that is done; may raise to stop.

    Raises:
        FilterInputError: the modes do not fit into memory.
        ConvergenceError: they cannot be computed.
    """
    last = response.last_frequency(tolerance)
    # Weyl's law: a surface of area A has A omega^2 / 4 pi modes up to omega.
    estimate = math.ceil(_MARGIN * float(problem.mass.sum()) * last**2 / (4.0 * math.pi)) + 10
    most = most_modes(problem)
    count = min(estimate, most)
    not_back = rising(progress)
    while True:
        omega, shapes = _modes(problem, count, not_back)
        if count == most or omega[-1] >= last:
            break
        count = min(count + count // 3 + 10, most)
    after, rest = _combined(problem, values, shapes, response(omega), response.infinity)
    error = 0.0 if count == most else tolerance * rest
    return FilteredByModes(after, error, count, float(omega[-1]) if count else 0.0)


def brick_wall(
    problem: SpectralProblem,
    values: Floats,
    count: int,
    response: Callable[[float], Response] | None,
    *,
    progress: Progress = ignore_progress,
) -> FilteredByModes:
    """The `count` lowest modes of the values, or a band that ends with the last of them.

    Args:
        problem: of n rows.
        values: (n, 3), of mean 0 on every component.
        count: how many modes, from 1, without those that are constant on a component; if there are fewer, all.
        response: None keeps these modes and drops the rest. Otherwise a band pass or enhancement, given the wavelength of the
            last mode: modes from the longest wave of the band on get its gain, and all others the limit of the response.
        progress: told the share that is done; may raise to stop.

    Raises:
        FilterInputError: the modes do not fit into memory.
        ConvergenceError: they cannot be computed.
    """
    count = min(count, most_modes(problem))
    omega, shapes = _modes(problem, count, progress)
    factors, rest = np.ones_like(omega), 0.0
    if response is not None and count and omega[-1] > 0.0:
        band = response(2.0 * math.pi / float(omega[-1]))
        rest = band.infinity
        # The band adds the weight of the profile at its short end to the limit.
        factors = np.where(omega >= band.cutoffs[0], rest + band.weights[-1], rest)
    after, _ = _combined(problem, values, shapes, factors, rest)
    return FilteredByModes(after, 0.0, count, float(omega[-1]) if count else 0.0)


def _modes(problem: SpectralProblem, count: int, progress: Progress) -> tuple[Floats, Floats]:
    """The frequencies and modes, without the modes that are constant on a component, to which the values are orthogonal."""
    if not basis_fits(problem, count):
        raise FilterInputError(
            f"{count} modes of {len(problem.mass)} vertices take {8e-9 * count * len(problem.mass):.1f} GB: take the method "
            "'polynomial', which needs none, a larger detail_size or fewer modes"
        )
    kappa, shapes = lowest_eigenpairs(problem, count, constants=False, progress=progress)
    return np.sqrt(np.maximum(kappa, 0.0)), shapes


def _combined(problem: SpectralProblem, values: Floats, shapes: Floats, factors: Floats, infinity: float) -> tuple[Floats, float]:
    """The modes of the values times factors plus the remainder times `infinity`, and the root mean square of the remainder."""
    rest, after = values.copy(), np.zeros_like(values)
    for k in range(shapes.shape[1]):  # one by one: a product of matrices may round differently with the number of threads
        along = np.einsum("i,ij->j", problem.mass * shapes[:, k], values)
        part = shapes[:, k, None] * along
        rest -= part
        after += factors[k] * part
    return after + infinity * rest, math.sqrt(float(np.sum(problem.mass[:, None] * rest * rest) / problem.mass.sum()))

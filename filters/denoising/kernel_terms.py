"""What bilateral filters have in common: their parameters, checked, and scales that follow from the data."""

import math
from typing import NamedTuple

from ..checks import FilterInputError
from ..mesh import Floats
from ..robust import SIGMA_IN_DEVIATIONS, KernelName, kernel_code, robust_deviation

#: How far a space kernel reaches, in its sigma. A Gaussian exp(-x^2 / (2 s^2)) is our kernel "gaussian" with sigma = sqrt(2) s:
#: this is the distance 2 s at which the papers cut it off.
REACH = math.sqrt(2.0)


class Term(NamedTuple):
    """A kernel by its number, and its scale in the unit of the coordinates that it is applied to."""

    code: int
    sigma: float


def space_term(kernel: KernelName, sigma: float | None, automatic: float) -> Term:
    """The kernel of distances; its sigma, or the automatic one."""
    return Term(kernel_code(kernel), _checked_sigma("space_sigma", sigma, automatic))


def range_term(kernel: KernelName, sigma: float | None, heights: Floats, share: float) -> Term:
    """The kernel of heights; its sigma, or a share of `SIGMA_IN_DEVIATIONS` times the deviation of the heights of neighbours.

    Most of a surface being smooth, the median of their sizes is that of noise, not of features. A term with sigma 0 comes from
    heights that are all 0: there is nothing to remove.
    """
    code = kernel_code(kernel)
    deviation = robust_deviation(heights) if sigma is None and len(heights) else 0.0
    return Term(code, _checked_sigma("range_sigma", sigma, share * SIGMA_IN_DEVIATIONS[kernel] * deviation))


def check_iterations(iterations: int) -> int:
    """The number of iterations, if it is a whole one of at least 0."""
    if iterations != int(iterations) or iterations < 0:
        raise FilterInputError(f"iterations is {iterations}: it is a whole number of at least 0")
    return int(iterations)


def _checked_sigma(name: str, sigma: float | None, automatic: float) -> float:
    if sigma is None:
        return automatic
    if not (math.isfinite(sigma) and sigma > 0.0):
        raise FilterInputError(f"{name} {sigma} is not finite and above 0; None takes it from the mesh")
    return sigma

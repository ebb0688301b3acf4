"""The kernels of bilateral filters with their scales, checked or estimated from the data."""

import math
from typing import NamedTuple

import numpy as np

from ..checks import FilterInputError, check_choice, check_positive
from ..mesh import Floats
from ..robust import KERNEL_CODES, KERNEL_NAMES, SIGMA_IN_DEVIATIONS, KernelName, robust_deviation

#: How far a space kernel reaches, in its sigma. A Gaussian exp(-x^2 / (2 s^2)) is our kernel "gaussian" with sigma = sqrt(2) s:
#: this is the distance 2 s at which the papers cut it off.
REACH = math.sqrt(2.0)
# Scales beyond it, whose squares would be beyond all numbers, are refused.
_EXTREME = 1e150


class Term(NamedTuple):
    """A kernel by its number, and its scale in the unit of the coordinates that it is applied to."""

    code: int
    sigma: float


def space_term(kernel: KernelName, sigma: float | None, scale: float, automatic: float) -> Term:
    """The kernel of distances.

    Args:
        kernel: its name.
        sigma: its scale in mesh units; None for the automatic one.
        scale: how long one mesh unit is in the coordinates that the kernel is applied to.
        automatic: the automatic sigma, in these coordinates.
    """
    check_choice("space_kernel", kernel, KERNEL_NAMES)
    return Term(KERNEL_CODES[kernel], _scaled("space_sigma", sigma, scale, automatic))


def range_term(kernel: KernelName, sigma: float | None, scale: float, heights: Floats, share: float) -> Term:
    """The kernel of heights; arguments as `space_term`.

    The automatic sigma is a share of `SIGMA_IN_DEVIATIONS` times the deviation of the heights of neighbours. Most of a surface
    being smooth, the median of their sizes is that of noise, not of features. A term with sigma 0 comes from heights that are all
    0 but for the rounding of coordinates, of which the largest are about 1: there is nothing to remove.
    """
    check_choice("range_kernel", kernel, KERNEL_NAMES)
    deviation = robust_deviation(heights) if sigma is None and len(heights) else 0.0
    if deviation < np.finfo(np.float64).eps:
        deviation = 0.0
    return Term(KERNEL_CODES[kernel], _scaled("range_sigma", sigma, scale, share * SIGMA_IN_DEVIATIONS[kernel] * deviation))


def _scaled(name: str, sigma: float | None, scale: float, automatic: float) -> float:
    if sigma is None:
        return automatic
    scaled = check_positive(name, sigma, note="; None takes it from the mesh") * scale
    if not 1.0 / _EXTREME < scaled < _EXTREME:
        raise FilterInputError(f"{name} {sigma} is out of all proportion to the mesh; None takes it from the mesh")
    return scaled

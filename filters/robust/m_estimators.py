"""Nine M-estimators: the cost of a deviation x, and the weight of a sample with that deviation.

An estimate that minimises sum rho(x_i) satisfies sum psi(x_i) = 0 with psi = rho', so it is a mean with the weights
g = psi / x of its own residuals. As range kernels these weights suppress neighbours that lie across a feature.
With the scale sigma, in the normalisation of [yadav2021] and with rho(0) = 0:

============  ===============================================  =====================================================
kernel        rho(x)                                           weight g(x)
============  ===============================================  =====================================================
l2            x^2                                              2
l1            |x|                                              1 / |x|
truncated_l2  min(x^2, sigma^2)                                2, and 0 from sigma on
truncated_l1  min(|x|, sigma)                                  1 / |x|, and 0 from sigma on
huber         x^2 / (2 sigma), then |x| - sigma / 2            1 / sigma, and 1 / |x| from sigma on
lorentzian    log(1 + x^2 / (2 sigma^2))                       2 / (x^2 + 2 sigma^2)
gaussian      sigma^2 / 2 (1 - exp(-x^2 / sigma^2))            exp(-x^2 / sigma^2)
tukey         sigma^2 / 12 (1 - (1 - x^2 / sigma^2)^3)         (1 - x^2 / sigma^2)^2 / 2, and 0 from sigma on
hampel        three parts, see `HAMPEL_KNOTS`                  1; a1 / |x|; a1 (a3 - |x|) / ((a3 - a2) |x|); 0
============  ===============================================  =====================================================

Lectures and papers print the Lorentzian weight as 2 x / (x^2 + 2 sigma^2). That is its psi: as a weight it would be 0 for samples
that fit exactly and negative for negative deviations. Here psi / x is used.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_choice, check_positive
from ..compilation import compiled
from ..mesh import Floats
from .kernel_weights import (
    A1,
    A2,
    A3,
    GAUSSIAN,
    HAMPEL,
    HUBER,
    KERNEL_CODES,
    KERNEL_NAMES,
    L1,
    LORENTZIAN,
    TRUNCATED_L1,
    TRUNCATED_L2,
    TUKEY,
    KernelName,
    kernel_weight,
)


def rho(name: KernelName, x: ArrayLike, sigma: float) -> Floats:
    """The cost of deviations; even, 0 at 0, never falling with |x|.

    Args:
        name: the kernel; see the table above.
        x: deviations, any shape and sign, in the unit of sigma.
        sigma: the scale, above 0. Larger tolerates larger deviations; of "l2" and "l1" it changes nothing.

    Raises:
        FilterInputError: no such kernel, or a scale that is not finite and above 0.
    """
    return _evaluated(name, x, sigma, cost=True)


def psi(name: KernelName, x: ArrayLike, sigma: float) -> Floats:
    """The influence of deviations, the derivative of `rho`; odd. Arguments and errors as there.

    Of "l1" and "truncated_l1" it passes through 0 on a straight line of the width 2 `SMALLEST_DEVIATION` sigma.
    """
    return np.asarray(x, dtype=np.float64) * weight(name, x, sigma)


def weight(name: KernelName, x: ArrayLike, sigma: float) -> Floats:
    """The weight psi(x) / x of samples that deviate by x; even, at least 0, never rising with |x|. Arguments as `rho`."""
    return _evaluated(name, x, sigma, cost=False)


def kernel_code(name: KernelName) -> int:
    """The number of a kernel for compiled code.

    Raises:
        FilterInputError: no such kernel.
    """
    check_choice("kernel", name, KERNEL_NAMES)
    return KERNEL_CODES[name]


@compiled
def _rho(code: int, x: float, sigma: float) -> float:
    size, u = abs(x), abs(x) / sigma
    result = x * x
    if code == L1:
        result = size
    elif code == TRUNCATED_L2:
        result = min(x * x, sigma * sigma)
    elif code == TRUNCATED_L1:
        result = min(size, sigma)
    elif code == HUBER:
        result = 0.5 * x * x / sigma if size < sigma else size - 0.5 * sigma
    elif code == LORENTZIAN:
        result = math.log1p(0.5 * u * u)
    elif code == GAUSSIAN:
        result = -0.5 * sigma * sigma * math.expm1(-u * u)
    elif code == TUKEY:
        result = sigma * sigma / 12.0 * (1.0 - (1.0 - u * u) ** 3 if u < 1.0 else 1.0)
    elif code == HAMPEL:
        if u <= A1:
            result = 0.5 * u * u
        elif u <= A2:
            result = A1 * (u - 0.5 * A1)
        else:
            rest = max(A3 - u, 0.0)
            result = A1 * (A2 - 0.5 * A1 + 0.5 * ((A3 - A2) - rest * rest / (A3 - A2)))
        result *= sigma * sigma
    return result


@compiled
def _evaluate(code: int, x: Floats, sigma: float, cost: bool, result: Floats) -> None:
    for i in range(x.shape[0]):
        result[i] = _rho(code, x[i], sigma) if cost else kernel_weight(code, x[i], sigma)


def _evaluated(name: KernelName, x: ArrayLike, sigma: float, *, cost: bool) -> Floats:
    """The costs or the weights of deviations of any shape."""
    code, scale = kernel_code(name), check_positive("sigma", sigma)
    deviations = np.asarray(x, dtype=np.float64)
    result = np.empty(deviations.shape)
    _evaluate(code, deviations.ravel(), scale, cost, result.reshape(-1))
    return result

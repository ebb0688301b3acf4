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
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_choice, check_positive
from ..compilation import compiled
from ..mesh import Floats

KernelName: TypeAlias = Literal["l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"]
KERNEL_NAMES: tuple[KernelName, ...] = get_args(KernelName)
#: The number of each kernel in compiled code.
KERNEL_CODES: dict[KernelName, int] = {name: code for code, name in enumerate(KERNEL_NAMES)}
#: Hampel's a1, a2, a3 in units of sigma: psi is x up to a1, level up to a2, and falls to 0 at a3. His 2, 4, 8 in proportion.
HAMPEL_KNOTS = (1.0, 2.0, 4.0)
#: 1 / |x| is bounded by 1 / (SMALLEST_DEVIATION sigma), so that a sample that fits exactly has a weight that can be summed.
SMALLEST_DEVIATION = 1e-6

_L2, _L1, _TRUNCATED_L2, _TRUNCATED_L1, _HUBER, _LORENTZIAN, _GAUSSIAN, _TUKEY, _HAMPEL = range(len(KERNEL_NAMES))
_A1, _A2, _A3 = HAMPEL_KNOTS


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
def kernel_weight(code: int, x: float, sigma: float) -> float:
    """The weight of one deviation, for compiled code: the kernel by its `KERNEL_CODES`, sigma above 0."""
    size = abs(x)
    result = 2.0
    if code == _L1:
        result = 1.0 / max(size, SMALLEST_DEVIATION * sigma)
    elif code == _TRUNCATED_L2:
        result = 2.0 if size < sigma else 0.0
    elif code == _TRUNCATED_L1:
        result = 1.0 / max(size, SMALLEST_DEVIATION * sigma) if size < sigma else 0.0
    elif code == _HUBER:
        result = 1.0 / max(size, sigma)
    elif code == _LORENTZIAN:
        result = 2.0 / (x * x + 2.0 * sigma * sigma)
    elif code == _GAUSSIAN:
        result = math.exp(-(x / sigma) * (x / sigma))
    elif code == _TUKEY:
        rest = 1.0 - (x / sigma) * (x / sigma)
        result = 0.5 * rest * rest if size < sigma else 0.0
    elif code == _HAMPEL:
        u = size / sigma
        if u <= _A1:
            result = 1.0
        elif u <= _A2:
            result = _A1 / u
        elif u < _A3:
            result = _A1 * (_A3 - u) / ((_A3 - _A2) * u)
        else:
            result = 0.0
    return result


@compiled
def _rho(code: int, x: float, sigma: float) -> float:
    size, u = abs(x), abs(x) / sigma
    result = x * x
    if code == _L1:
        result = size
    elif code == _TRUNCATED_L2:
        result = min(x * x, sigma * sigma)
    elif code == _TRUNCATED_L1:
        result = min(size, sigma)
    elif code == _HUBER:
        result = 0.5 * x * x / sigma if size < sigma else size - 0.5 * sigma
    elif code == _LORENTZIAN:
        result = math.log1p(0.5 * u * u)
    elif code == _GAUSSIAN:
        result = -0.5 * sigma * sigma * math.expm1(-u * u)
    elif code == _TUKEY:
        result = sigma * sigma / 12.0 * (1.0 - (1.0 - u * u) ** 3 if u < 1.0 else 1.0)
    elif code == _HAMPEL:
        if u <= _A1:
            result = 0.5 * u * u
        elif u <= _A2:
            result = _A1 * (u - 0.5 * _A1)
        else:
            rest = max(_A3 - u, 0.0)
            result = _A1 * (_A2 - 0.5 * _A1 + 0.5 * ((_A3 - _A2) - rest * rest / (_A3 - _A2)))
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

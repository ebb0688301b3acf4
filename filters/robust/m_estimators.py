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
from collections.abc import Callable
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
#: The numbers of the kernels and Hampel's, as compiled code reads them.
L2, L1, TRUNCATED_L2, TRUNCATED_L1, HUBER, LORENTZIAN, GAUSSIAN, TUKEY, HAMPEL = range(len(KERNEL_NAMES))
A1, A2, A3 = HAMPEL_KNOTS
# ln 2 as a sum: the first has so few digits that its multiples by whole numbers up to 2^20 are exact.
_LN2_HIGH, _LN2_LOW = 0.69314718036912381649, 1.90821492927058770002e-10
_PER_LN2 = 1.4426950408889634
# Numbers of about this size are 1 apart: what is added is rounded to a whole number, which the last bits of the sum are.
_WHOLE = 1.5 * 2.0**52
# The exponent of 2^0 in the bits of a number, and how many bits stand below it.
_BIAS, _BELOW = 1023, 52
# Its exponential is the smallest number that has all of its digits.
_LEAST = -708.0


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


@compiled
def kernel_weight(code: int, x: float, sigma: float) -> float:
    """The weight of one deviation, for compiled code: the kernel by its `KERNEL_CODES`, sigma above 0."""
    size = abs(x)
    result = _l2(size, sigma)
    if code == L1:
        result = _l1(size, sigma)
    elif code == TRUNCATED_L2:
        result = _truncated_l2(size, sigma)
    elif code == TRUNCATED_L1:
        result = _truncated_l1(size, sigma)
    elif code == HUBER:
        result = _huber(size, sigma)
    elif code == LORENTZIAN:
        result = _lorentzian(size, sigma)
    elif code == GAUSSIAN:
        result = _gaussian(size, sigma)
    elif code == TUKEY:
        result = _tukey(size, sigma)
    elif code == HAMPEL:
        result = _hampel(size, sigma)
    return result


# Each of a size |x|. Both sides of a condition are computed and one is taken, a division by 0 is infinite and no error, and
# `max`, which looks for what is no number, is avoided: a loop without branches is done for several samples at once.
@compiled(error_model="numpy")
def _l2(_size: float, _sigma: float) -> float:
    return 2.0


@compiled(error_model="numpy")
def _l1(size: float, sigma: float) -> float:
    return 1.0 / (size if size > SMALLEST_DEVIATION * sigma else SMALLEST_DEVIATION * sigma)


@compiled(error_model="numpy")
def _truncated_l2(size: float, sigma: float) -> float:
    return 2.0 if size < sigma else 0.0


@compiled(error_model="numpy")
def _truncated_l1(size: float, sigma: float) -> float:
    inside = _l1(size, sigma)
    return inside if size < sigma else 0.0


@compiled(error_model="numpy")
def _huber(size: float, sigma: float) -> float:
    return 1.0 / (size if size > sigma else sigma)


@compiled(error_model="numpy")
def _lorentzian(size: float, sigma: float) -> float:
    return 2.0 / (size * size + 2.0 * sigma * sigma)


@compiled(error_model="numpy")
def _gaussian(size: float, sigma: float) -> float:
    return exponential(-(size / sigma) * (size / sigma))


@compiled(error_model="numpy")
def _tukey(size: float, sigma: float) -> float:
    rest = 1.0 - (size / sigma) * (size / sigma)
    inside = 0.5 * rest * rest
    return inside if size < sigma else 0.0


@compiled(error_model="numpy")
def _hampel(size: float, sigma: float) -> float:
    u = size / sigma
    level, falling = A1 / u, A1 * (A3 - u) / ((A3 - A2) * u)
    beyond = falling if u < A3 else 0.0
    farther = level if u <= A2 else beyond
    return 1.0 if u <= A1 else farther


# Compiled for each kernel by itself: of many loops in one function none would be done for several samples at once.
def _loop(kernel: Callable[[float, float], float]) -> Callable[[Floats, float, Floats, float, Floats, float, int], None]:
    @compiled(nogil=True, error_model="numpy")
    def loop(
        weights: Floats, sigma: float, squares: Floats, floor: float, distances: Floats, per_distance: float, count: int
    ) -> None:
        for k in range(count):
            size = math.sqrt(squares[k])
            size = size if size > floor else floor
            weights[k] *= kernel(size, sigma) * exponential(-distances[k] * per_distance)

    return loop


_by_l2 = _loop(_l2)


_by_l1 = _loop(_l1)


_by_truncated_l2 = _loop(_truncated_l2)


_by_truncated_l1 = _loop(_truncated_l1)


_by_huber = _loop(_huber)


_by_lorentzian = _loop(_lorentzian)


_by_gaussian = _loop(_gaussian)


_by_tukey = _loop(_tukey)


_by_hampel = _loop(_hampel)


@compiled(nogil=True)
def weigh(
    weights: Floats, code: int, sigma: float, squares: Floats, floor: float, distances: Floats, per_distance: float, count: int
) -> None:
    """Multiply weights w by g(max(|x|, floor)) exp(-d c), for compiled code: a bilateral filter's, if d are squared distances.

    Args:
        weights: (n,) w.
        code: the kernel g, by its `KERNEL_CODES`.
        sigma: its scale, above 0.
        squares: (n,) x^2 of deviations x.
        floor: smaller deviations count as this one.
        distances: (n,) d, not below 0.
        per_distance: c, not below 0.
        count: how many are multiplied, from the first.
    """
    if code == L2:
        _by_l2(weights, sigma, squares, floor, distances, per_distance, count)
    elif code == L1:
        _by_l1(weights, sigma, squares, floor, distances, per_distance, count)
    elif code == TRUNCATED_L2:
        _by_truncated_l2(weights, sigma, squares, floor, distances, per_distance, count)
    elif code == TRUNCATED_L1:
        _by_truncated_l1(weights, sigma, squares, floor, distances, per_distance, count)
    elif code == HUBER:
        _by_huber(weights, sigma, squares, floor, distances, per_distance, count)
    elif code == LORENTZIAN:
        _by_lorentzian(weights, sigma, squares, floor, distances, per_distance, count)
    elif code == GAUSSIAN:
        _by_gaussian(weights, sigma, squares, floor, distances, per_distance, count)
    elif code == TUKEY:
        _by_tukey(weights, sigma, squares, floor, distances, per_distance, count)
    elif code == HAMPEL:
        _by_hampel(weights, sigma, squares, floor, distances, per_distance, count)


@compiled(nogil=True)
def exponential(x: float) -> float:
    """exp(x) with a relative error below 2^-51, for x from -708 to 709; 0 for x below.

    With the whole number k nearest to x / ln 2 it is 2^k exp(x - k ln 2), whose series needs 14 terms. It has no branches and
    calls nothing: a loop of it is done for several x at once, and has the same bits on all processors.
    """
    rounded = x * _PER_LN2 + _WHOLE
    k = rounded - _WHOLE
    r = (x - k * _LN2_HIGH) - k * _LN2_LOW
    series = 1.0 / 6227020800.0
    series = series * r + 1.0 / 479001600.0
    series = series * r + 1.0 / 39916800.0
    series = series * r + 1.0 / 3628800.0
    series = series * r + 1.0 / 362880.0
    series = series * r + 1.0 / 40320.0
    series = series * r + 1.0 / 5040.0
    series = series * r + 1.0 / 720.0
    series = series * r + 1.0 / 120.0
    series = series * r + 1.0 / 24.0
    series = series * r + 1.0 / 6.0
    series = series * r + 0.5
    series = series * r + 1.0
    series = series * r + 1.0
    bits = np.float64(rounded).view(np.int64) + _BIAS
    power = np.int64(bits << _BELOW).view(np.float64)
    return series * power if x >= _LEAST else 0.0

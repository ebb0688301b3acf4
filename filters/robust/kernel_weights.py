"""The weights of the nine kernels of `m_estimators`, for compiled code: of one deviation, or of many at once."""

import math
from collections.abc import Callable
from typing import Literal, TypeAlias, get_args

from ..compilation import compiled
from ..mesh import Floats
from .exponential import exponential

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

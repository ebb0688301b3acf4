"""M-estimators (cost, influence and weight of deviations), and robust estimates of standard deviation, mean and line."""

import math
from collections.abc import Callable
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from .checks import FilterInputError, check_choice, check_positive
from .compilation import compiled
from .mesh import Floats

__all__ = [
    "KERNEL_CODES",
    "KERNEL_NAMES",
    "SIGMA_IN_DEVIATIONS",
    "KernelName",
    "Line",
    "exponential",
    "kernel_weight",
    "psi",
    "rho",
    "robust_deviation",
    "robust_line",
    "robust_mean",
    "weigh",
    "weight",
]

KernelName: TypeAlias = Literal["l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"]
KERNEL_NAMES: tuple[KernelName, ...] = get_args(KernelName)
#: The code of each kernel in compiled functions.
KERNEL_CODES: dict[KernelName, int] = {name: code for code, name in enumerate(KERNEL_NAMES)}
#: The weight 1 / |x| is bounded by 1 / (SMALLEST_DEVIATION sigma), so that a sample that fits exactly has a finite weight.
SMALLEST_DEVIATION = 1e-6
#: `KERNEL_CODES` as constants.
L2, L1, TRUNCATED_L2, TRUNCATED_L1, HUBER, LORENTZIAN, GAUSSIAN, TUKEY, HAMPEL = range(len(KERNEL_NAMES))
#: Hampel's a1, a2, a3 in sigmas: psi is x up to a1, constant up to a2, and falls to 0 at a3. Sigma 2 gives Hampel's 2, 4, 8.
A1, A2, A3 = 1.0, 2.0, 4.0
# ln 2 as a sum. The first term has few digits, so its products with whole numbers up to 2^20 are exact.
_LN2_HIGH, _LN2_LOW = 0.69314718036912381649, 1.90821492927058770002e-10
_PER_LN2 = 1.4426950408889634
# Floats of about this size are 1 apart. Adding this number to x rounds x to a whole number, in the last bits of the sum.
_WHOLE = 1.5 * 2.0**52
# The exponent bits of 1, the number of bits below the exponent, and the least x whose exp(x) has full precision.
_BIAS, _BELOW, _LEAST = 1023, 52, -708.0


def rho(name: KernelName, x: ArrayLike, sigma: float) -> Floats:
    """Returns the cost rho of deviations: even, 0 at 0, non-decreasing with |x|.

    Args:
        name: the kernel; `_rho` has the formulas.
        x: deviations, any shape and sign, in the unit of sigma.
        sigma: the scale, above 0. Larger tolerates larger deviations; "l2" and "l1" do not depend on it.

    Raises:
        FilterInputError: no such kernel, or a scale that is not finite and above 0.
    """
    return _evaluated(name, x, sigma, cost=True)


def psi(name: KernelName, x: ArrayLike, sigma: float) -> Floats:
    """Returns the influence psi of deviations, the derivative of `rho`; odd. Arguments and errors: see `rho`.

    For "l1" and "truncated_l1" it is linear where |x| is below `SMALLEST_DEVIATION` sigma.
    """
    return np.asarray(x, dtype=np.float64) * weight(name, x, sigma)


def weight(name: KernelName, x: ArrayLike, sigma: float) -> Floats:
    """Returns the weight psi(x) / x of deviations: even, at least 0, non-increasing with |x|. Arguments and errors: see `rho`."""
    return _evaluated(name, x, sigma, cost=False)


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
            remaining = max(A3 - u, 0.0)
            result = A1 * (A2 - 0.5 * A1 + 0.5 * ((A3 - A2) - remaining * remaining / (A3 - A2)))
        result *= sigma * sigma
    return result


@compiled
def _evaluate(code: int, x: Floats, sigma: float, cost: bool, result: Floats) -> None:
    for i in range(x.shape[0]):
        result[i] = _rho(code, x[i], sigma) if cost else kernel_weight(code, x[i], sigma)


def _evaluated(name: KernelName, x: ArrayLike, sigma: float, *, cost: bool) -> Floats:
    check_choice("kernel", name, KERNEL_NAMES)
    scale = check_positive("sigma", sigma)
    deviations = np.asarray(x, dtype=np.float64)
    result = np.empty(deviations.shape)
    _evaluate(KERNEL_CODES[name], deviations.ravel(), scale, cost, result.reshape(-1))
    return result


# Loops over this function must be vectorised. So loops pass a constant `code`, which leaves one branch; a division by 0 gives
# infinity without an error; and `max`, which tests for NaN, is avoided.
@compiled(error_model="numpy")
def kernel_weight(code: int, x: float, sigma: float) -> float:
    """Returns the weight of one deviation, for compiled functions; `code` is from `KERNEL_CODES`, sigma is above 0."""
    size = abs(x)
    u = size / sigma
    result = 2.0
    if code in (L1, TRUNCATED_L1):
        result = 1.0 / (size if size > SMALLEST_DEVIATION * sigma else SMALLEST_DEVIATION * sigma)
    elif code == HUBER:
        result = 1.0 / (size if size > sigma else sigma)
    elif code == LORENTZIAN:
        result = 2.0 / (size * size + 2.0 * sigma * sigma)
    elif code == GAUSSIAN:
        result = exponential(-u * u)
    elif code == TUKEY:
        result = 0.5 * (1.0 - u * u) * (1.0 - u * u)
    elif code == HAMPEL:
        level, falling = A1 / u, A1 * (A3 - u) / ((A3 - A2) * u)
        beyond = falling if u < A3 else 0.0
        farther = level if u <= A2 else beyond
        result = 1.0 if u <= A1 else farther
    if code in (TRUNCATED_L1, TRUNCATED_L2, TUKEY):
        result = result if size < sigma else 0.0
    return result


# One function for each kernel: several loops in one function are not vectorised.
def _loop(code: int) -> Callable[[Floats, float, Floats, float, Floats, float, int], None]:
    @compiled(nogil=True, error_model="numpy")
    def loop(
        weights: Floats, sigma: float, squares: Floats, floor: float, distances: Floats, per_distance: float, count: int
    ) -> None:
        for k in range(count):
            size = math.sqrt(squares[k])
            size = size if size > floor else floor
            weights[k] *= kernel_weight(code, size, sigma) * exponential(-distances[k] * per_distance)

    return loop


_by_l2, _by_l1, _by_truncated_l2, _by_truncated_l1 = _loop(L2), _loop(L1), _loop(TRUNCATED_L2), _loop(TRUNCATED_L1)
_by_huber, _by_lorentzian, _by_gaussian, _by_tukey, _by_hampel = map(_loop, (HUBER, LORENTZIAN, GAUSSIAN, TUKEY, HAMPEL))


@compiled(nogil=True)
def weigh(
    weights: Floats, code: int, sigma: float, squares: Floats, floor: float, distances: Floats, per_distance: float, count: int
) -> None:
    """Multiplies the first `count` weights by g(max(|x|, floor)) exp(-d c).

    g is `kernel_weight` for `code` and `sigma`; `squares` are x^2, `distances` squared distances d, `per_distance` c >= 0.
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
    """Returns exp(x) with a relative error below 2^-51, for x from -708 to 709; 0 for smaller x.

    It computes 2^k exp(x - k ln 2) with the whole number k nearest to x / ln 2. Loops over it are vectorised, since it has no
    branches and no calls; the bits are the same on all processors.
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


#: The standard deviation of normally distributed residuals, divided by their median absolute value.
_MEDIAN_TO_DEVIATION = 1.4826022185056018

#: The sigma, in standard deviations of the noise, for which the robust mean of normally distributed samples has 95 % of the
#: efficiency of the plain mean. "truncated_l1" cannot reach 95 % and has the sigma of "truncated_l2"; "hampel" has Hampel's a1.
#: "l2" and "l1" do not depend on sigma.
SIGMA_IN_DEVIATIONS: dict[KernelName, float] = dict(
    zip(KERNEL_NAMES, (1.0, 1.0, 2.795, 2.795, 1.345, 1.686, 2.985, 4.685, 2.0), strict=True)
)

_ITERATIONS, _TOLERANCE = 2000, 1e-13  # the largest number of iterations, and the relative change of a fit that ends them


class Line(NamedTuple):
    """The line y = slope x + intercept."""

    slope: float
    intercept: float


def robust_deviation(residuals: ArrayLike) -> float:
    """Estimates the standard deviation of Gaussian residuals r of mean 0 by 1.4826 median |r|; fewer than half may be outliers.

    If more than half of the residuals are exactly 0, the result is the mean of |r|.

    Args:
        residuals: r, at least one, any shape.
    """
    sizes = np.abs(np.asarray(residuals, dtype=np.float64))
    return float(_MEDIAN_TO_DEVIATION * np.median(sizes) or sizes.mean())


def robust_mean(x: ArrayLike, *, kernel: KernelName = "huber", sigma: float | None = None) -> float:
    """Returns a local minimum m of sum rho(x_i - m) [huber1964], by reweighted means that start from the median.

    Args:
        x: (n,) at least one sample.
        kernel: the kernel of rho; "l2" gives the mean, "l1" the median.
        sigma: the scale in the unit of x. Larger gives more weight to distant samples. None: `robust_deviation` of the
            samples from their median, times `SIGMA_IN_DEVIATIONS`.

    Raises:
        FilterInputError: no samples, samples that are not finite, no such kernel, a scale that is not finite and above 0.
    """
    samples = _samples(x, "x").ravel()
    return float(_reweighted(np.ones((len(samples), 1)), samples, np.array([np.median(samples)]), kernel, sigma)[0])


def robust_line(x: ArrayLike, y: ArrayLike, *, kernel: KernelName = "huber", sigma: float | None = None) -> Line:
    """Returns the line that minimises sum rho(y_i - slope x_i - intercept), by iteratively reweighted least squares.

    All kernels but "l2" start with the line of "l1". The result is the global minimum for convex rho ("l2", "l1", "huber"), and
    the local minimum near the start for other kernels.

    Args:
        x: (n,) at least two values, not all equal.
        y: (n,) the samples at x.
        kernel: the kernel of rho; "l2" is the plain least squares fit.
        sigma: the scale in the unit of y. Larger gives more weight to distant samples. None: `robust_deviation` of the samples
            from the line of "l1", times `SIGMA_IN_DEVIATIONS`.

    Raises:
        FilterInputError: as for `robust_mean`, or x and y do not define a line.
    """
    places, values = _samples(x, "x").ravel(), _samples(y, "y").ravel()
    if len(places) != len(values):
        raise FilterInputError(f"x has {len(places)} values and y {len(values)}: a line needs one y for each x")
    if np.ptp(places) == 0.0:
        raise FilterInputError(f"all {len(places)} samples are at x = {places[0]:g}: a line needs at least two different x")
    middle = (places / len(places)).sum()
    spread = np.abs(places - middle).max()
    design = np.column_stack([(places - middle) / spread, np.ones(len(places))])
    start = np.linalg.lstsq(design, values, rcond=None)[0]
    if kernel != "l2":
        start = _reweighted(design, values, start, "l1", None)
    slope, level = _reweighted(design, values, start, kernel, sigma)
    return Line(float(slope / spread), float(level - slope * (middle / spread)))


def _reweighted(design: Floats, values: Floats, start: Floats, kernel: KernelName, sigma: float | None) -> Floats:
    """Minimises sum rho(values - design @ result) by least squares, reweighted by the residuals of each solution."""
    check_choice("kernel", kernel, KERNEL_NAMES)
    factor = SIGMA_IN_DEVIATIONS[kernel]
    scale = factor * robust_deviation(values - design @ start) if sigma is None else check_positive("sigma", sigma)
    if scale == 0.0:  # the start fits all samples exactly
        return start
    for _ in range(_ITERATIONS):
        # The unit of the residuals is the scale, since squares of very small or large residuals would under- or overflow.
        roots, before = np.sqrt(weight(kernel, (values - design @ start) / scale, 1.0)), start
        if np.count_nonzero(roots) < design.shape[1]:  # too few samples have a weight above 0
            break
        start = np.asarray(np.linalg.lstsq(design * roots[:, None], values * roots, rcond=None)[0], dtype=np.float64)
        if np.abs(design @ (start - before)).max() <= _TOLERANCE * np.abs(values).max():
            break
    return start


def _samples(x: ArrayLike, name: str) -> Floats:
    samples = np.asarray(x, dtype=np.float64)
    if samples.size == 0 or not np.isfinite(samples).all():
        what = "is empty" if samples.size == 0 else f"has {int((~np.isfinite(samples)).sum())} values that are not finite"
        raise FilterInputError(f"{name} {what}: a robust estimate needs at least one sample, and only finite ones")
    return samples

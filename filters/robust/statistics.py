"""Robust estimates of a deviation, a mean and a line: a few outliers among the samples hardly change them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice
from ..mesh import Floats
from .m_estimators import KERNEL_NAMES, KernelName, weight

#: The median of |x| for a standard normal x is 1 / 1.4826: the median size of residuals times this is their standard deviation.
_MEDIAN_TO_DEVIATION = 1.4826022185056018

#: The sigma, in standard deviations of the noise, with which a mean of normal samples has 95 % of the efficiency of the plain
#: mean. "truncated_l1" cannot reach that and takes the sigma of "truncated_l2"; Hampel's is his own a1 = 2; "l2" and "l1" do not
#: depend on theirs.
SIGMA_IN_DEVIATIONS: dict[KernelName, float] = dict(
    zip(KERNEL_NAMES, (1.0, 1.0, 2.795, 2.795, 1.345, 1.686, 2.985, 4.685, 2.0), strict=True)
)

_ITERATIONS = 2000
_TOLERANCE = 1e-13


class Line(NamedTuple):
    """y = slope x + intercept."""

    slope: float
    intercept: float


def robust_deviation(residuals: ArrayLike) -> float:
    """The standard deviation of normal residuals of mean 0, of which fewer than half may be outliers: 1.4826 median |r|.

    Where more than half of the residuals are exactly 0 it is the mean of |r|.

    Args:
        residuals: r, at least one, any shape.
    """
    sizes = np.abs(np.asarray(residuals, dtype=np.float64))
    return float(_MEDIAN_TO_DEVIATION * np.median(sizes) or sizes.mean())


def robust_mean(x: ArrayLike, *, kernel: KernelName = "huber", sigma: float | None = None) -> float:
    """The m that minimises sum rho(x_i - m) [huber1964], by m <- sum g_i x_i / sum g_i from the median.

    Args:
        x: (n,) at least one sample.
        kernel: of rho; "l2" gives the mean, "l1" the median.
        sigma: the scale in the unit of x. Larger gives more weight to distant samples. None: `robust_deviation` of the
            samples from their median, times `SIGMA_IN_DEVIATIONS`.

    Raises:
        FilterInputError: no samples, some that are not finite, no such kernel, a scale that is not finite and above 0.
    """
    samples = _samples(x, "x").ravel()
    return float(_reweighted(np.ones((len(samples), 1)), samples, np.array([np.median(samples)]), kernel, sigma)[0])


def robust_line(x: ArrayLike, y: ArrayLike, *, kernel: KernelName = "huber", sigma: float | None = None) -> Line:
    """The line that minimises sum rho(y_i - slope x_i - intercept), by iteratively reweighted least squares.

    The start is the line of "l1". Where rho is convex ("l2", "l1", "huber") the minimum is the global one, with other kernels
    the one near the start.

    Args:
        x: (n,) at least two places, not all the same.
        y: (n,) the samples there.
        kernel: of rho; "l2" is the plain least squares fit.
        sigma: the scale in the unit of y. Larger gives more weight to distant samples. None: `robust_deviation` of the samples
            from the line of "l1", times `SIGMA_IN_DEVIATIONS`.

    Raises:
        FilterInputError: as for `robust_mean`, or x and y do not define a line.
    """
    places, values = _samples(x, "x").ravel(), _samples(y, "y").ravel()
    if len(places) != len(values):
        raise FilterInputError(f"x has {len(places)} values and y {len(values)}: a line takes pairs of them")
    if np.ptp(places) == 0.0:
        raise FilterInputError(f"all {len(places)} samples are at x = {places[0]:g}: a line takes at least two places")
    middle = places.mean()
    design = np.column_stack([places - middle, np.ones(len(places))])
    start = np.linalg.lstsq(design, values, rcond=None)[0]
    if kernel != "l2":
        start = _reweighted(design, values, start, "l1", None)
    slope, level = _reweighted(design, values, start, kernel, sigma)
    return Line(float(slope), float(level - slope * middle))


def _reweighted(design: Floats, values: Floats, start: Floats, kernel: KernelName, sigma: float | None) -> Floats:
    """Minimises sum rho(values - design @ result) by least squares, weighted anew by the residuals of each solution."""
    check_choice("kernel", kernel, KERNEL_NAMES)
    scale = robust_deviation(values - design @ start) * SIGMA_IN_DEVIATIONS[kernel] if sigma is None else sigma
    if scale == 0.0 and sigma is None:  # every sample is met exactly
        return start
    result: Floats = start
    for _ in range(_ITERATIONS):
        roots = np.sqrt(weight(kernel, values - design @ result, scale))
        if np.count_nonzero(roots) < design.shape[1]:  # too few samples within reach of sigma
            return result
        following: Floats = np.asarray(np.linalg.lstsq(design * roots[:, None], values * roots, rcond=None)[0], dtype=np.float64)
        change = np.abs(design @ (following - result)).max()
        result = following
        if change <= _TOLERANCE * np.abs(values).max():
            break
    return result


def _samples(x: ArrayLike, name: str) -> Floats:
    samples = np.asarray(x, dtype=np.float64)
    if samples.size == 0 or not np.isfinite(samples).all():
        what = "is empty" if samples.size == 0 else f"has {int((~np.isfinite(samples)).sum())} values that are not finite"
        raise FilterInputError(f"{name} {what}: a robust estimate takes at least one sample, and finite ones")
    return samples

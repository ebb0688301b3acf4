"""Estimates that a few wild samples do not spoil: a scale, a mean and a line, by iteratively reweighted least squares."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..mesh import Floats
from .m_estimators import KERNEL_NAMES, KernelName, weight

#: The median of |x| for a standard normal x is 1 / 1.4826: times this, the median deviation estimates the standard deviation.
MAD_TO_DEVIATION = 1.4826022185056018

#: sigma in standard deviations of the noise with which a mean of purely normal samples has 95 % of the efficiency of the plain
#: one. Of "truncated_l1", which cannot reach that, the sigma of "truncated_l2"; Hampel's is his own a1 = 2; those of "l2" and
#: "l1" are without effect.
SIGMA_IN_DEVIATIONS: dict[KernelName, float] = dict(
    zip(KERNEL_NAMES, (1.0, 1.0, 2.795, 2.795, 1.345, 1.686, 2.985, 4.685, 2.0), strict=True)
)

_ITERATIONS = 2000
_TOLERANCE = 1e-13


class Line(NamedTuple):
    """y = slope x + intercept."""

    slope: float
    intercept: float


def mad_scale(x: ArrayLike) -> float:
    """1.4826 times the median of |x - median x|: the standard deviation of normal samples, whatever up to half of them are.

    Args:
        x: at least one sample, any shape.

    Raises:
        FilterInputError: no samples, or some that are not finite.
    """
    samples = _samples(x, "x").ravel()
    return float(MAD_TO_DEVIATION * np.median(np.abs(samples - np.median(samples))))


def robust_mean(x: ArrayLike, *, kernel: KernelName = "huber", sigma: float | None = None) -> float:
    """The m that minimises sum rho(x_i - m) [huber1964], from the median on by m <- sum g_i x_i / sum g_i.

    Args:
        x: (n,) at least one sample.
        kernel: of rho; "l2" gives the mean, "l1" the median.
        sigma: the scale in the unit of x; larger listens to more distant samples. None: `mad_scale` of the samples times
            `SIGMA_IN_DEVIATIONS`.

    Raises:
        FilterInputError: no samples, some that are not finite, no such kernel, a scale that is not above 0.
    """
    samples = _samples(x, "x").ravel()
    return float(_reweighted(np.ones((len(samples), 1)), samples, np.array([np.median(samples)]), kernel, sigma)[0])


def robust_line(x: ArrayLike, y: ArrayLike, *, kernel: KernelName = "huber", sigma: float | None = None) -> Line:
    """The line that minimises sum rho(y_i - slope x_i - intercept), by iteratively reweighted least squares.

    It starts at the line of "l1". Where rho is convex ("l2", "l1", "huber") the minimum is the global one, of the other kernels
    the one near that start.

    Args:
        x: (n,) at least two places, not all the same.
        y: (n,) the samples there.
        kernel: of rho; "l2" is the plain least squares fit.
        sigma: the scale in the unit of y; larger listens to more distant samples. None: `mad_scale` of the deviations from the
            line of "l1" times `SIGMA_IN_DEVIATIONS`.

    Raises:
        FilterInputError: as `robust_mean`; or the x and y do not define a line.
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
    """Minimise sum rho(values - design @ result): solve the least squares problem that the last residuals weight, repeatedly."""
    residuals = values - design @ start
    scale = _scale_of(residuals) * SIGMA_IN_DEVIATIONS[kernel] if sigma is None and kernel in SIGMA_IN_DEVIATIONS else sigma
    if scale == 0.0 and sigma is None:  # every sample is met exactly
        return start
    result: Floats = start
    for _ in range(_ITERATIONS):
        roots = np.sqrt(weight(kernel, values - design @ result, 1.0 if scale is None else scale))
        if np.count_nonzero(roots) < design.shape[1]:  # too few samples within reach of sigma
            return result
        following: Floats = np.asarray(np.linalg.lstsq(design * roots[:, None], values * roots, rcond=None)[0], dtype=np.float64)
        change = np.abs(design @ (following - result)).max()
        result = following
        if change <= _TOLERANCE * np.abs(values).max():
            break
    return result


def _scale_of(residuals: Floats) -> float:
    """The deviation of residuals: their MAD or, if more than half are 0, their mean size."""
    return float(MAD_TO_DEVIATION * np.median(np.abs(residuals)) or np.abs(residuals).mean())


def _samples(x: ArrayLike, name: str) -> Floats:
    samples = np.asarray(x, dtype=np.float64)
    if samples.size == 0 or not np.isfinite(samples).all():
        what = "is empty" if samples.size == 0 else f"has {int((~np.isfinite(samples)).sum())} values that are not finite"
        raise FilterInputError(f"{name} {what}: a robust estimate takes at least one sample, and finite ones")
    return samples

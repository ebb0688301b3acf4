"""Colour maps whose lightness changes evenly, and the limits of the values that they cover.

The diverging and the sequential map are paths through the perceptual space Oklab [ottosson2020]. Colour-blind people can read
the diverging map: it goes from blue to orange, not from red to green.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..mesh import Floats

ENCLOSED = 0.98  # The share of the values between the limits: with outliers inside the limits, all other values would look alike.
_STEPS = 1024  # The number of colours of a map: more than the 256 levels of a channel.
#: The stops of the two maps: position from 0 to 1, lightness, chroma, hue in degrees.
_DIVERGING = (
    (0.0, 0.40, 0.13, 258.0),
    (0.25, 0.685, 0.12, 250.0),
    (0.5, 0.97, 0.0, 0.0),
    (0.75, 0.685, 0.15, 55.0),
    (1.0, 0.40, 0.12, 40.0),
)
_SEQUENTIAL = ((0.0, 0.38, 0.12, 285.0), (0.35, 0.57, 0.10, 225.0), (0.7, 0.77, 0.14, 150.0), (1.0, 0.93, 0.16, 105.0))


class Limits(NamedTuple):
    """The values at the two ends of a colour map; a value beyond an end has the colour of this end, NaN that of the middle."""

    low: float
    high: float


def robust_limits(values: Floats) -> Limits:
    """Limits of the middle 98 % of the finite values, or of all finite values if these limits are equal; (0, 0) without any."""
    halves = 0.5 * values[np.isfinite(values)]
    if not len(halves):
        return Limits(0.0, 0.0)
    # Halves, since quantiles interpolate by a difference, which overflows for large values of opposite signs.
    low, high = 2.0 * np.quantile(halves, [(1.0 - ENCLOSED) / 2, (1.0 + ENCLOSED) / 2], overwrite_input=True)
    if low == high:
        low, high = 2.0 * halves.min(), 2.0 * halves.max()
    return Limits(float(low), float(high))


def symmetric_limits(values: Floats, negligible: float = 0.0) -> Limits:
    """Limits -x and x of 98 % of the finite values, or of all if 98 % are 0; sizes up to `negligible` count as 0."""
    sizes = np.abs(values[np.isfinite(values)])
    sizes[sizes <= negligible] = 0.0
    if not len(sizes):
        return Limits(0.0, 0.0)
    limit = float(np.quantile(sizes, ENCLOSED, overwrite_input=True)) or float(sizes.max())
    return Limits(0.0 - limit, limit)


def diverging_colors(values: Floats, limits: Limits) -> Floats:
    """(n, 4) RGBA from 0 to 1: blue below the middle of the limits, nearly white at the middle, orange above."""
    return _DIVERGING_TABLE[_places(values, limits)]


def sequential_colors(values: Floats, limits: Limits) -> Floats:
    """(n, 4) RGBA from 0 to 1: dark violet at the lower limit, then green, bright yellow at the upper limit."""
    return _SEQUENTIAL_TABLE[_places(values, limits)]


def _places(values: Floats, limits: Limits) -> NDArray[np.intp]:
    low, high = limits
    # Halved against overflow, as in `robust_limits`.
    half = 0.5 * high - 0.5 * low
    shares = np.full(len(values), 0.5)
    if half > 0.0:
        with np.errstate(over="ignore"):
            shares = np.clip((0.5 * values - 0.5 * low) / half, 0.0, 1.0)
        shares[np.isnan(values)] = 0.5
    return np.asarray(np.rint(shares * (_STEPS - 1)), dtype=np.intp)


def _table(stops: Iterable[tuple[float, float, float, float]]) -> Floats:
    """(k, 4) gamma-encoded colours, interpolated linearly in Oklab between the stops."""
    at, lightness, chroma, hue = np.array(list(stops)).T
    angle = np.radians(hue)
    lab = (lightness, chroma * np.cos(angle), chroma * np.sin(angle))
    oklab = np.column_stack([np.interp(np.linspace(0.0, 1.0, _STEPS), at, channel) for channel in lab])
    to_cones = np.array(
        [[1.0, 0.3963377774, 0.2158037573], [1.0, -0.1055613458, -0.0638541728], [1.0, -0.0894841775, -1.2914855480]]
    )
    to_linear = np.array(
        [
            [4.0767416621, -3.3077115913, 0.2309699292],
            [-1.2684380046, 2.6097574011, -0.3413193965],
            [-0.0041960863, -0.7034186147, 1.7076147010],
        ]
    )
    linear = np.clip((oklab @ to_cones.T) ** 3 @ to_linear.T, 0.0, 1.0)
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.column_stack([coded, np.ones(len(coded))])


_DIVERGING_TABLE = _table(_DIVERGING)
_SEQUENTIAL_TABLE = _table(_SEQUENTIAL)

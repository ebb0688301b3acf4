"""Chebyshev series of scalar functions, with a bound of the truncation error."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..libraries import fft
from ..mesh import Floats

#: The fewest samples, and the samples per 1 / width.
_FIRST_SAMPLES, _SAMPLES_A_WIDTH = 64, 16
#: Coefficients below this share of the largest are rounding.
_ROUNDING = 1e-15


@dataclass(frozen=True, eq=False)
class ChebyshevSeries:
    """p(t) = sum_k coefficients_k T_k(t), an approximation of a function on [-1, 1].

    Attributes:
        coefficients: (degree + 1,).
        error: a bound of |p - f| on [-1, 1]: the sum of the sizes of the computed coefficients that were left out.
    """

    coefficients: Floats
    error: float

    @property
    def degree(self) -> int:
        """The degree of the polynomial."""
        return len(self.coefficients) - 1

    def __call__(self, t: Floats) -> Floats:
        """p(t)."""
        return np.asarray(np.polynomial.chebyshev.chebval(t, self.coefficients), dtype=np.float64)


def chebyshev_series(
    function: Callable[[Floats], Floats], *, tolerance: float, width: float, largest_degree: int
) -> ChebyshevSeries:
    """The shortest Chebyshev series of a smooth function whose error is bounded by the tolerance.

    The coefficients come from samples at the roots of a T_N, by a cosine transform. N doubles until the sum of the second half of
    the coefficients is below a hundredth of the tolerance, so that aliasing into the kept ones is negligible.

    Args:
        function: of (N,) t in (-1, 1).
        tolerance: of |p - f|, above 0.
        width: the smallest angle theta, t = cos theta, in which the function changes: samples farther apart could miss it.
        largest_degree: the series has at most this degree. Its `error` is then larger than the tolerance, infinite if unknown.
    """
    if not width * largest_degree > 1.0:
        return ChebyshevSeries(np.zeros(1), math.inf)
    samples = max(_FIRST_SAMPLES, math.ceil(_SAMPLES_A_WIDTH / width))
    while True:
        nodes = np.cos(np.pi * (np.arange(samples) + 0.5) / samples)
        coefficients: Floats = fft.dct(function(nodes), type=2) / samples
        coefficients[0] *= 0.5
        sizes = np.abs(coefficients)
        second_half = float(sizes[samples // 2 :].sum())
        floor = _ROUNDING * samples * float(sizes.max())
        if second_half <= max(0.01 * tolerance, floor) or samples > 4 * largest_degree:
            break
        samples *= 2
    # tails[k] is the error of a series of degree k - 1; the coefficients beyond the samples sum to less than their second half.
    tails = np.append(np.cumsum(sizes[::-1])[::-1], 0.0) + second_half
    degree = int(np.argmax(tails[1:] <= max(tolerance, tails[-1])))
    degree = min(degree, largest_degree)
    return ChebyshevSeries(coefficients[: degree + 1].copy(), float(tails[degree + 1]))

"""The exponential function for compiled loops over arrays."""

import numpy as np

from ..compilation import compiled

# ln 2 as a sum: the first has so few digits that its multiples by whole numbers up to 2^20 are exact.
_LN2_HIGH, _LN2_LOW = 0.69314718036912381649, 1.90821492927058770002e-10
_PER_LN2 = 1.4426950408889634
# Numbers of about this size are 1 apart: what is added is rounded to a whole number, which the last bits of the sum are.
_WHOLE = 1.5 * 2.0**52
# The exponent of 2^0 in the bits of a number, and how many bits stand below it.
_BIAS, _BELOW = 1023, 52
# Its exponential is the smallest number that has all of its digits.
_LEAST = -708.0


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

"""Equality of arrays, and numbers for the different rows of one."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..filters.compilation import compiled


def are_equal(a: NDArray[Any] | None, b: NDArray[Any] | None) -> bool:
    """Whether two arrays have the same numbers, NaN at the same places, or neither is there."""
    if a is None or b is None:
        return a is b
    return np.array_equal(a, b, equal_nan=a.dtype.kind == "f")


def numbered(rows: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The (u,) first rows of different ones among (n, k), in order, and the (n,) number of each row; NaN equals nothing."""
    values = np.ascontiguousarray(rows, np.float64) + 0.0  # -0 becomes 0
    firsts, numbers = np.empty(len(values), np.int64), np.empty(len(values), np.int64)
    size = 1 << max(2 * len(values) - 1, 1).bit_length()
    count = _number(values, values.view(np.uint64), np.full(size, -1, np.int64), firsts, numbers)
    return firsts[:count].copy(), numbers


@compiled
def _number(values: Any, bits: Any, table: Any, firsts: Any, numbers: Any) -> int:
    """Fill the arrays through a hash table, whose size is a power of two; how many numbers there are."""
    count, mask = 0, np.uint64(len(table) - 1)
    for i in range(len(values)):
        key = np.uint64(0)
        for k in range(values.shape[1]):
            key = (key ^ bits[i, k]) * np.uint64(0x9E3779B97F4A7C15)
            key ^= key >> np.uint64(29)
        place = key & mask
        while True:
            number = table[place]
            if number < 0:
                table[place] = numbers[i] = count
                firsts[count] = i
                count += 1
                break
            same = True
            for k in range(values.shape[1]):
                same = same and values[firsts[number], k] == values[i, k]
            if same:
                numbers[i] = number
                break
            place = (place + np.uint64(1)) & mask
    return count

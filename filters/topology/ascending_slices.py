"""Sorting a slice of a list in place, and finding a number in a sorted one: for kernels over lists by vertex."""

from ..compilation import compiled
from ..mesh import Ints, Longs

# Up to this, an insertion sort is faster; above, its quadratic time would show at the hub of a large fan.
_SHORT = 48


@compiled
def sort_slice(values: Ints | Longs, start: int, stop: int) -> None:
    """Sort ``values[start:stop]`` in place: by insertion if it is short, else by a heap."""
    if stop - start <= _SHORT:
        for k in range(start + 1, stop):
            value = values[k]
            j = k - 1
            while j >= start and values[j] > value:
                values[j + 1] = values[j]
                j -= 1
            values[j + 1] = value
        return
    size = stop - start
    parent = size // 2
    while size > 1:
        if parent > 0:
            parent -= 1
        else:
            size -= 1
            values[start], values[start + size] = values[start + size], values[start]
        node = parent
        while 2 * node + 1 < size:
            child = 2 * node + 1
            if child + 1 < size and values[start + child + 1] > values[start + child]:
                child += 1
            if values[start + node] >= values[start + child]:
                break
            values[start + node], values[start + child] = values[start + child], values[start + node]
            node = child


@compiled
def position(neighbours: Ints, start: int, stop: int, j: int) -> int:
    """The index of j in ``neighbours[start:stop]``, which is ascending and contains it."""
    while stop - start > 1:
        middle = (start + stop) // 2
        if neighbours[middle] <= j:
            start = middle
        else:
            stop = middle
    return start

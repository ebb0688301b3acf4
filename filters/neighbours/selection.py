"""Hoare's selection, of the rows of a tree and of the candidates of a search."""

import numpy as np

from ..compilation import compiled
from ..mesh import Floats, Ints

#: Beyond any squared distance of a tree's coordinates, and below the infinite distance of a point to itself.
FAR = 1e300
#: Above every index: no candidate at the bound itself counts any more.
ANY_INDEX = 2**62
#: Guesses at a threshold before the exact selection takes over: with ties no guess succeeds.
_GUESSES = 6


@compiled(nogil=True)
def partition(rows: Floats, start: int, stop: int, middle: int, column: int) -> None:
    """Moves the rows from `start` to before `stop` so that none before `middle` is above one after it."""
    low, high = start, stop - 1
    seed = np.uint64(start + stop)
    while low < high:
        # The median of three at pseudo-random places: the patterns in a scan's order make fixed places take quadratic time.
        seed = seed * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
        size = np.uint64(high - low + 1)
        a = rows[low + np.int64((seed >> np.uint64(43)) % size), column]
        b = rows[low + np.int64((seed >> np.uint64(22) & np.uint64(0x1FFFFF)) % size), column]
        c = rows[(low + high) // 2, column]
        pivot = max(min(a, b), min(max(a, b), c))
        i, j = low, high
        while i <= j:
            while rows[i, column] < pivot:
                i += 1
            while rows[j, column] > pivot:
                j -= 1
            if i <= j:
                for d in range(4):
                    rows[i, d], rows[j, d] = rows[j, d], rows[i, d]
                i += 1
                j -= 1
        low, high = _side_of_middle(low, high, i, j, middle)


@compiled(nogil=True)
def keep_nearest(found: Floats, found_at: Ints, count: int, k: int, bound: float, indices: Ints) -> tuple[float, int]:
    """Moves the k nearest of `count` candidates to the front; returns their bound and the index below which a tie counts."""
    if count == k:
        return bound, ANY_INDEX
    # Guess the distance of the k-th as if all were spread evenly, and count: that is faster than sorting.
    low, high = 0.0, bound
    n_low, n_high = 0, count
    if bound == FAR:
        high = 0.0
        for i in range(count):
            high = found[i] if found[i] > high else high
    for _ in range(_GUESSES):
        guess = low + (high - low) * ((k - n_low) / (n_high - n_low))
        n = 0
        for i in range(count):
            n += 1 if found[i] <= guess else 0
        if n in (n_low, n_high):
            break  # probably ties
        if n > k:
            high, n_high = guess, n
        else:
            low, n_low = guess, n
        if n == k:
            break
    if n_low == k:
        _move_to_front(found, found_at, count, low)
        return low, ANY_INDEX
    _move_to_front(found, found_at, count, high)
    if n_low > 0:
        _move_to_front(found, found_at, n_high, low)
    _select(found, found_at, n_low, n_high, k - 1, indices)
    return found[k - 1], int(indices[found_at[k - 1]])


@compiled(nogil=True)
def _move_to_front(found: Floats, found_at: Ints, count: int, limit: float) -> None:
    """Moves the candidates up to a distance to the front, without a branch."""
    front = 0
    for i in range(count):
        distance, at = found[i], found_at[i]
        found[i], found_at[i] = found[front], found_at[front]
        found[front], found_at[front] = distance, at
        front += 1 if distance <= limit else 0


@compiled(nogil=True)
def _select(found: Floats, found_at: Ints, low: int, high: int, middle: int, indices: Ints) -> None:
    """Moves the nearer ones of the candidates from `low` to before `high` to before the `middle`."""
    high -= 1
    while low < high:
        pivot = found[(low + high) // 2]
        pivot_index = indices[found_at[(low + high) // 2]]
        i, j = low, high
        while i <= j:
            while found[i] < pivot or (found[i] == pivot and indices[found_at[i]] < pivot_index):
                i += 1
            while found[j] > pivot or (found[j] == pivot and indices[found_at[j]] > pivot_index):
                j -= 1
            if i <= j:
                found[i], found[j] = found[j], found[i]
                found_at[i], found_at[j] = found_at[j], found_at[i]
                i += 1
                j -= 1
        low, high = _side_of_middle(low, high, i, j, middle)


@compiled(nogil=True)
def _side_of_middle(low: int, high: int, i: int, j: int, middle: int) -> tuple[int, int]:
    """The part that still has to be split around the `middle`, after a split into `low` to j and i to `high`; else no part."""
    if middle <= j:
        return low, j
    if middle >= i:
        return i, high
    return middle, middle

"""The triangles at every vertex put into their order round it, and the kind of star that they form.

A triangle at a vertex is the pair of its other two vertices in the `ends` of `ring_ends`.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..compilation import compiled, prange
from ..mesh import Ints, Longs
from .ascending_slices import sort_slice

Kinds: TypeAlias = NDArray[np.uint8]

#: the kinds of star: no triangle; a closed ring; a fan from border to border; anything else
NO_STAR, CLOSED, OPEN, IRREGULAR = 0, 1, 2, 3

# Sorting the triangles round a vertex takes quadratic time; the hub of a fan larger than this counts as irregular.
_LARGEST_WALK = 64


@compiled(parallel=True)
def order_ends(end_offsets: Longs, ends: Ints, kinds: Kinds, sizes: Ints) -> None:
    """Order the pairs at every vertex in place; write the kinds of the stars, and the number of neighbours unless irregular."""
    for i in prange(kinds.shape[0]):
        start, stop = end_offsets[i], end_offsets[i + 1]
        if stop == start:
            kinds[i] = NO_STAR
            sizes[i] = 0
            continue
        kind = IRREGULAR
        if stop - start <= 2 * _LARGEST_WALK:
            kind = _chain(ends, start, stop)
        kinds[i] = kind
        if kind == CLOSED:
            sizes[i] = (stop - start) // 2
        elif kind == OPEN:
            sizes[i] = (stop - start) // 2 + 1


@compiled
def _chain(ends: Ints, start: int, stop: int) -> int:
    """Order the pairs from `start` to `stop` as a walk ab, bc, cd ... in place; the kind of the star."""
    reversed_once = False
    k = start + 2
    while k < stop:
        end = ends[k - 1]
        m = k
        while m < stop and ends[m] != end and ends[m + 1] != end:
            m += 2
        if m < stop:
            a, b = ends[m], ends[m + 1]
            ends[m], ends[m + 1] = ends[k], ends[k + 1]
            if a == end:
                ends[k], ends[k + 1] = a, b
            else:
                ends[k], ends[k + 1] = b, a
            k += 2
        elif not reversed_once:
            # The walk has reached a border: reverse it, and extend it at its other end.
            for j in range((k - start) // 2):
                ends[start + j], ends[k - 1 - j] = ends[k - 1 - j], ends[start + j]
            reversed_once = True
        else:
            return IRREGULAR
    for k in range(start, stop, 2):
        for m in range(start, k, 2):
            if ends[m] == ends[k]:
                return IRREGULAR
    if ends[start] == ends[stop - 1] and stop - start > 2:
        return CLOSED
    for m in range(start, stop, 2):
        if ends[m] == ends[stop - 1]:
            return IRREGULAR
    return OPEN


@compiled
def measure_irregular(end_offsets: Longs, ends: Ints, irregular: Ints, sizes: Ints) -> None:
    """Write the number of neighbours of the vertices with an irregular star."""
    for i in irregular:
        sizes[i] = distinct_ends(ends, end_offsets[i], end_offsets[i + 1]).shape[0]


@compiled
def distinct_ends(ends: Ints, start: int, stop: int) -> Ints:
    """The vertices in ``ends[start:stop]``, each once, ascending."""
    found = ends[start:stop].copy()
    sort_slice(found, 0, found.shape[0])
    count = 0
    for end in found:
        if count == 0 or end != found[count - 1]:
            found[count] = end
            count += 1
    return found[:count]

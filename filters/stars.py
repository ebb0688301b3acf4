"""The triangles around a vertex in the order in which one meets them walking round it.

Where a surface is a manifold this order is a closed ring, or on a border a fan from border to border. Then a kernel that needs
the two triangles of every edge gets them by looking at each neighbour once.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from .parallel import threads_for
from .topology import Ints, Longs, ring_ends

#: the kinds of star: of an unreferenced vertex; a closed ring; a fan from border to border; anything else
NO_STAR, CLOSED, OPEN, IRREGULAR = 0, 1, 2, 3

# Sorting the triangles round a vertex takes quadratic time; the hub of a fan larger than this counts as irregular.
_LARGEST_WALK = 64


class Stars(NamedTuple):
    """The neighbours of every vertex i: ``neighbours[offsets[i]:offsets[i + 1]]``, each once.

    Neither the order of the faces nor their orientation makes a difference to a star.

    Attributes:
        kinds: (n,) uint8, one of `NO_STAR`, `CLOSED`, `OPEN`, `IRREGULAR`.
        offsets: (n + 1,) int64.
        neighbours: (2 e,) int32. Closed: round the vertex from the lowest neighbour, by way of the lower of its two sides. Open:
            from border to border, the lower end first. Irregular (non-manifold edges, several fans, very many triangles):
            ascending.
        corner_offsets: (n + 1,) int64.
        corners: (6 m,) int32, for every vertex the other two vertices of each of its faces, the pairs in no certain order.
    """

    kinds: NDArray[np.uint8]
    offsets: Longs
    neighbours: Ints
    corner_offsets: Longs
    corners: Ints


def stars(faces: Ints, n_vertices: int) -> Stars:
    """The star of every vertex."""
    with threads_for(n_vertices):
        corner_offsets, corners = ring_ends(faces, n_vertices)
        kinds = np.empty(n_vertices, dtype=np.uint8)
        offsets = np.zeros(n_vertices + 1, dtype=np.int64)
        _walk(corner_offsets, corners, kinds, offsets)
        np.cumsum(offsets, out=offsets)
        neighbours = np.empty(offsets[-1], dtype=np.int32)
        _write(corner_offsets, corners, kinds, offsets, neighbours)
    return Stars(kinds, offsets, neighbours, corner_offsets, corners)


@njit(cache=True)
def _chain(corners: Ints, start: int, stop: int) -> int:
    """Reorder the pairs into a walk a-b, b-c, c-d ... in place; the kind of star that it is."""
    turned = False
    k = start + 2
    while k < stop:
        end = corners[k - 1]
        m = k
        while m < stop and corners[m] != end and corners[m + 1] != end:
            m += 2
        if m < stop:
            a, b = corners[m], corners[m + 1]
            corners[m], corners[m + 1] = corners[k], corners[k + 1]
            if a == end:
                corners[k], corners[k + 1] = a, b
            else:
                corners[k], corners[k + 1] = b, a
            k += 2
        elif not turned:
            # The walk met a border: turn it round and go on from where it began.
            corners[start:k] = corners[start:k][::-1].copy()
            turned = True
        else:
            return IRREGULAR
    for k in range(start, stop, 2):
        for m in range(start, k, 2):
            if corners[m] == corners[k]:
                return IRREGULAR
    if corners[start] == corners[stop - 1] and stop - start > 2:
        return CLOSED
    for m in range(start, stop, 2):
        if corners[m] == corners[stop - 1]:
            return IRREGULAR
    return OPEN


@njit(cache=True, parallel=True)
def _walk(corner_offsets: Longs, corners: Ints, kinds: NDArray[np.uint8], sizes: Longs) -> None:
    for i in prange(kinds.shape[0]):
        start, stop = corner_offsets[i], corner_offsets[i + 1]
        if stop == start:
            kinds[i] = NO_STAR
            continue
        kind = IRREGULAR
        if stop - start <= 2 * _LARGEST_WALK:
            kind = _chain(corners, start, stop)
        kinds[i] = kind
        if kind == CLOSED:
            sizes[i + 1] = (stop - start) // 2
        elif kind == OPEN:
            sizes[i + 1] = (stop - start) // 2 + 1
        else:
            sizes[i + 1] = np.unique(corners[start:stop]).shape[0]


@njit(cache=True, parallel=True)
def _write(corner_offsets: Longs, corners: Ints, kinds: NDArray[np.uint8], offsets: Longs, neighbours: Ints) -> None:
    for i in prange(kinds.shape[0]):
        start, stop = corner_offsets[i], corner_offsets[i + 1]
        at, end = offsets[i], offsets[i + 1]
        if kinds[i] == CLOSED:
            lowest = start
            for k in range(start, stop, 2):
                if corners[k] < corners[lowest]:
                    lowest = k
            before = lowest - 2 if lowest > start else stop - 2
            forward = corners[lowest + 1] <= corners[before]
            k = lowest
            for m in range(at, end):
                neighbours[m] = corners[k]
                k += 2 if forward else -2
                if k == stop:
                    k = start
                elif k < start:
                    k = stop - 2
        elif kinds[i] == OPEN:
            if corners[start] < corners[stop - 1]:
                for m in range(at, end - 1):
                    neighbours[m] = corners[start + 2 * (m - at)]
                neighbours[end - 1] = corners[stop - 1]
            else:
                for m in range(at, end - 1):
                    neighbours[m] = corners[stop - 1 - 2 * (m - at)]
                neighbours[end - 1] = corners[start]
        elif kinds[i] == IRREGULAR:
            neighbours[at:end] = np.unique(corners[start:stop])

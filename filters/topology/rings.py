"""The neighbours of every vertex, gathered in time linear in the mesh."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from ..execution import threads_for
from ..mesh import Ints, Longs

# Up to this, an insertion sort is faster; above, its quadratic time would show at the hub of a large fan.
_SHORT = 48


class OneRings(NamedTuple):
    """The neighbours of every vertex: those of vertex i are ``neighbours[offsets[i]:offsets[i + 1]]``, ascending, each once.

    Attributes:
        offsets: (n + 1,) int64.
        neighbours: (2 e,) int32 for e edges.
        face_counts: (2 e,) int32, how many faces the edge to that neighbour has: 1 on a border, more than 2 if non-manifold.
    """

    offsets: Longs
    neighbours: Ints
    face_counts: Ints


def one_rings(faces_or_edges: Ints, n_vertices: int) -> OneRings:
    """The one-ring of every vertex, and the number of faces at each of its edges.

    Args:
        faces_or_edges: (m, 3) triangles; or (e, 2) edges, which count as faces.
        n_vertices: n.
    """
    cells = np.ascontiguousarray(faces_or_edges, dtype=np.int32)
    if cells.shape[1] == 3:
        offsets, ends = ring_ends(cells, n_vertices)
    else:
        offsets, ends = _gather_ends(cells, n_vertices, _count_ends_of_edges, _fill_ends_of_edges)
    ring_offsets = np.zeros(n_vertices + 1, dtype=np.int64)
    with threads_for(n_vertices):
        _sort_and_count(offsets, ends, ring_offsets)
        np.cumsum(ring_offsets, out=ring_offsets)
        neighbours = np.empty(ring_offsets[-1], dtype=np.int32)
        face_counts = np.empty(ring_offsets[-1], dtype=np.int32)
        _compress(offsets, ends, ring_offsets, neighbours, face_counts)
    return OneRings(ring_offsets, neighbours, face_counts)


def ring_ends(faces: Ints, n_vertices: int) -> tuple[Longs, Ints]:
    """For every vertex the two other vertices of each of its faces, in the order of the faces, orientation kept.

    Those of vertex i are the pairs in ``ends[offsets[i]:offsets[i + 1]]``: for a face (i, a, b) the two entries a, b.

    Returns:
        offsets: (n + 1,) int64, even numbers.
        ends: (6 m,) int32, less those of faces that name a vertex twice.
    """
    return _gather_ends(np.ascontiguousarray(faces, dtype=np.int32), n_vertices, _count_ends, _fill_ends)


def _gather_ends(
    cells: Ints, n_vertices: int, count: Callable[[Ints, Longs], None], fill: Callable[[Ints, Longs, Ints], None]
) -> tuple[Longs, Ints]:
    # Large arrays come from numpy, never from a kernel: numpy asks the system for large pages, which makes them twice as fast.
    offsets = np.zeros(n_vertices + 2, dtype=np.int64)
    count(cells, offsets)
    np.cumsum(offsets, out=offsets)
    ends = np.empty(offsets[-1], dtype=np.int32)
    fill(cells, offsets, ends)
    return offsets[:-1], ends


@njit(cache=True)
def _count_ends(faces: Ints, offsets: Longs) -> None:
    """Count at ``offsets[i + 2]``, so that after summing up vertex i's entries begin at ``offsets[i + 1]``."""
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            offsets[a + 2] += 2
            offsets[b + 2] += 2
            offsets[c + 2] += 2


@njit(cache=True)
def _fill_ends(faces: Ints, offsets: Longs, ends: Ints) -> None:
    """Write at ``offsets[i + 1]`` and move it on, so that in the end vertex i's entries begin at ``offsets[i]``."""
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            k = offsets[a + 1]
            ends[k], ends[k + 1] = b, c
            offsets[a + 1] = k + 2
            k = offsets[b + 1]
            ends[k], ends[k + 1] = c, a
            offsets[b + 1] = k + 2
            k = offsets[c + 1]
            ends[k], ends[k + 1] = a, b
            offsets[c + 1] = k + 2


@njit(cache=True)
def _count_ends_of_edges(pairs: Ints, offsets: Longs) -> None:
    for e in range(pairs.shape[0]):
        a, b = pairs[e, 0], pairs[e, 1]
        if a != b:
            offsets[a + 2] += 1
            offsets[b + 2] += 1


@njit(cache=True)
def _fill_ends_of_edges(pairs: Ints, offsets: Longs, ends: Ints) -> None:
    for e in range(pairs.shape[0]):
        a, b = pairs[e, 0], pairs[e, 1]
        if a != b:
            ends[offsets[a + 1]] = b
            offsets[a + 1] += 1
            ends[offsets[b + 1]] = a
            offsets[b + 1] += 1


@njit(cache=True)
def sort_slice(values: Ints | Longs, start: int, stop: int) -> None:
    """Sort ``values[start:stop]`` in place: by insertion, or if it is long by a heap."""
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


@njit(cache=True)
def position(neighbours: Ints, start: int, stop: int, j: int) -> int:
    """Where j is in ``neighbours[start:stop]``, which is ascending and has it."""
    while stop - start > 1:
        middle = (start + stop) // 2
        if neighbours[middle] <= j:
            start = middle
        else:
            stop = middle
    return start


@njit(cache=True, parallel=True)
def _sort_and_count(offsets: Longs, ends: Ints, ring_sizes: Longs) -> None:
    for i in prange(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        sort_slice(ends, start, stop)
        size = 0
        for k in range(start, stop):
            if k == start or ends[k] != ends[k - 1]:
                size += 1
        ring_sizes[i + 1] = size


@njit(cache=True, parallel=True)
def _compress(offsets: Longs, ends: Ints, ring_offsets: Longs, neighbours: Ints, face_counts: Ints) -> None:
    for i in prange(offsets.shape[0] - 1):
        at = ring_offsets[i] - 1
        for k in range(offsets[i], offsets[i + 1]):
            if k == offsets[i] or ends[k] != ends[k - 1]:
                at += 1
                neighbours[at] = ends[k]
                face_counts[at] = 1
            else:
                face_counts[at] += 1

"""The faces on both sides of every edge."""

import numpy as np
from numba import njit

from ..mesh import Ints, Longs
from .edge_lists import vertex_bound
from .rings import sort_slice


def face_adjacency(faces: Ints) -> tuple[Ints, Ints]:
    """(k, 2) the pairs of faces that share an edge with exactly two faces, lower face first; and (k, 2) that edge.

    The rows are in ascending order of the edge. Two faces that share two edges appear twice.
    """
    offsets, keys = _faces_by_edge(np.ascontiguousarray(faces, dtype=np.int32), vertex_bound(faces))
    pairs, shared = _two_faced_edges(offsets, keys)
    return pairs, shared


@njit(cache=True)
def _faces_by_edge(faces: Ints, n_vertices: int) -> tuple[Longs, Longs]:
    """The half-edges by their lower vertex; each key is (higher vertex) * 2^32 + face, ascending."""
    offsets = np.zeros(n_vertices + 1, dtype=np.int64)
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            offsets[min(a, b) + 1] += 1
            offsets[min(b, c) + 1] += 1
            offsets[min(c, a) + 1] += 1
    for i in range(n_vertices):
        offsets[i + 1] += offsets[i]
    cursor = offsets[:-1].copy()
    keys = np.empty(offsets[n_vertices], dtype=np.int64)
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            for u, v in ((a, b), (b, c), (c, a)):
                low = min(u, v)
                keys[cursor[low]] = (np.int64(max(u, v)) << 32) | f
                cursor[low] += 1
    for i in range(n_vertices):
        sort_slice(keys, offsets[i], offsets[i + 1])
    return offsets, keys


@njit(cache=True)
def _two_faced_edges(offsets: Longs, keys: Longs) -> tuple[Ints, Ints]:
    pairs = np.empty((keys.shape[0] // 2, 2), dtype=np.int32)
    shared = np.empty((keys.shape[0] // 2, 2), dtype=np.int32)
    found = 0
    for i in range(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        while start < stop:
            end = start + 1
            while end < stop and keys[end] >> 32 == keys[start] >> 32:
                end += 1
            if end - start == 2:
                pairs[found, 0] = keys[start] & 0xFFFFFFFF
                pairs[found, 1] = keys[start + 1] & 0xFFFFFFFF
                shared[found, 0] = i
                shared[found, 1] = keys[start] >> 32
                found += 1
            start = end
    return pairs[:found].copy(), shared[:found].copy()

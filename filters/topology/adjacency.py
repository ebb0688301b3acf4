"""The two faces of every interior edge."""

import numpy as np

from ..compilation import compiled
from ..mesh import Ints, Longs
from .ascending_slices import sort_slice
from .edge_lists import vertex_bound


def face_adjacency(faces: Ints) -> tuple[Ints, Ints]:
    """(k, 2) the pairs of faces that share an edge with exactly two faces, lower face first; and (k, 2) that edge.

    The rows are in ascending order of the edge. Two faces that share two edges appear twice.
    """
    offsets, keys = _faces_by_edge(np.ascontiguousarray(faces, dtype=np.int32), vertex_bound(faces))
    pairs, shared = _two_faced_edges(offsets, keys)
    return pairs, shared


def faces_across(faces: Ints) -> Ints:
    """(m, 3) int32 the face across edge k of every face, the edge from its corner k to the next.

    -1 where the edge has other than two faces, and where its two faces are not coherently oriented.
    """
    triangles = np.ascontiguousarray(faces, dtype=np.int32)
    pairs, shared = face_adjacency(triangles)
    across = np.full(triangles.shape, -1, dtype=np.int32)
    _link(triangles, pairs, shared, across)
    return across


@compiled
def _faces_by_edge(faces: Ints, n_vertices: int) -> tuple[Longs, Longs]:
    """The edges of all faces by their lower vertex; the key of each is (higher vertex) * 2^32 + face, ascending at a vertex."""
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


@compiled
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


@compiled
def _link(faces: Ints, pairs: Ints, shared: Ints, across: Ints) -> None:
    for p in range(pairs.shape[0]):
        f, g = pairs[p, 0], pairs[p, 1]
        u, v = shared[p, 0], shared[p, 1]
        j, k = _edge_from(faces, f, u, v), _edge_from(faces, g, v, u)
        if j < 0:
            j, k = _edge_from(faces, f, v, u), _edge_from(faces, g, u, v)
        if k >= 0:
            across[f, j], across[g, k] = g, f


@compiled
def _edge_from(faces: Ints, f: int, u: int, v: int) -> int:
    """Which edge of face f goes from u to v; -1 if none does."""
    for k in range(3):
        if faces[f, k] == u and faces[f, (k + 1) % 3] == v:
            return k
    return -1

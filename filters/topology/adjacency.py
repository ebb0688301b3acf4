"""The two faces of every interior edge."""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..mesh import Ints, Longs
from .edge_keys import count_edges, end_of_edge, faces_by_edge, listed_edges
from .edge_lists import vertex_bound


def face_adjacency(faces: Ints) -> tuple[Ints, Ints]:
    """(k, 2) the pairs of faces that share an edge with exactly two faces, lower face first; and (k, 2) that edge.

    The rows are in ascending order of the edge. Two faces that share two edges appear twice.
    """
    offsets, keys = faces_by_edge(np.ascontiguousarray(faces, dtype=np.int32), vertex_bound(faces))
    return _two_faced(offsets, keys)


class EdgeFaces(NamedTuple):
    """Every edge of a triangle list, and the faces at those with two.

    Attributes:
        pairs: (e, 2) every edge once, lower vertex first, rows ascending.
        counts: (e,) the number of faces at each.
        neighbours: (k, 2) the faces of the edges with exactly two, lower face first.
        shared: (k, 2) these edges.
    """

    pairs: Ints
    counts: Ints
    neighbours: Ints
    shared: Ints


def edge_faces(faces: Ints) -> EdgeFaces:
    """What `edge_face_counts` and `face_adjacency` give, in one go."""
    offsets, keys = faces_by_edge(np.ascontiguousarray(faces, dtype=np.int32), vertex_bound(faces))
    pairs, counts = listed_edges(offsets, keys)
    neighbours, shared = _two_faced(offsets, keys)
    return EdgeFaces(pairs, counts, neighbours, pairs if len(shared) == len(pairs) else shared)  # the same, kept once


def faces_across(faces: Ints) -> Ints:
    """(m, 3) int32 the face across edge k of every face, the edge from its corner k to the next.

    -1 where the edge has other than two faces, and where its two faces are not coherently oriented.
    """
    triangles = np.ascontiguousarray(faces, dtype=np.int32)
    pairs, shared = face_adjacency(triangles)
    across = np.full(triangles.shape, -1, dtype=np.int32)
    _link(triangles, pairs, shared, across)
    return across


def _two_faced(offsets: Longs, keys: Longs) -> tuple[Ints, Ints]:
    """The pairs of faces at edges with two, and these edges."""
    count = count_edges(offsets, keys)[1]
    pairs, shared = np.empty((count, 2), dtype=np.int32), np.empty((count, 2), dtype=np.int32)
    _two_faced_edges(offsets, keys, pairs, shared)
    return pairs, shared


@compiled(nogil=True)
def _two_faced_edges(offsets: Longs, keys: Longs, pairs: Ints, shared: Ints) -> None:
    found = 0
    for i in range(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        while start < stop:
            end = end_of_edge(keys, start, stop)
            if end - start == 2:
                pairs[found, 0] = keys[start] & 0xFFFFFFFF
                pairs[found, 1] = keys[start + 1] & 0xFFFFFFFF
                shared[found, 0] = i
                shared[found, 1] = keys[start] >> 32
                found += 1
            start = end


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

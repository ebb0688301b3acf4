"""The edges of a triangle list and the faces at each, in time linear in the mesh.

A face that names a vertex twice is not proper: it has no edges and references no vertex, so the faces on both sides of a
collapsed triangle share an edge. An edge with exactly one face is a border edge, one with more than two is non-manifold.
"""

from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from ..compilation import compiled
from ..mesh import Bools, Ints, Longs, mask_of
from .rings import sort_slice

#: "fixed": border vertices stay. "along": only neighbours on the border count for them, so the border is smoothed as a curve.
#: "free": they are vertices like any other, and the border shrinks.
BorderPolicy: TypeAlias = Literal["fixed", "along", "free"]
BORDER_POLICIES: tuple[BorderPolicy, ...] = get_args(BorderPolicy)


def edges(faces: Ints) -> Ints:
    """(e, 2) every edge once, lower vertex first, rows ascending."""
    return edge_face_counts(faces)[0]


def edge_face_counts(faces: Ints) -> tuple[Ints, Ints]:
    """(e, 2) every edge once, lower vertex first, rows ascending; and (e,) the number of faces at each."""
    return listed_edges(*faces_by_edge(np.ascontiguousarray(faces, dtype=np.int32), vertex_bound(faces)))


def non_manifold_edges(faces: Ints) -> Ints:
    """(k, 2) the edges with more than two faces, lower vertex first, rows ascending."""
    return _crowded_edges(*faces_by_edge(np.ascontiguousarray(faces, dtype=np.int32), vertex_bound(faces)))


def referenced_vertices(faces: Ints, n_vertices: int) -> Bools:
    """(n,) whether the vertex belongs to a proper face."""
    return mask_of(faces[proper_faces(faces)], n_vertices)


def proper_faces(faces: Ints | Longs) -> Bools:
    """(m,) whether the face names three different vertices."""
    a, b, c = faces.T
    return np.asarray((a != b) & (b != c) & (c != a))


def vertex_bound(faces: Ints) -> int:
    """One more than the highest vertex that a face names."""
    return int(faces.max()) + 1 if faces.size else 0


def faces_by_edge(faces: Ints, n_vertices: int) -> tuple[Longs, Longs]:
    """The edges of all faces by their lower vertex; the key of each is (higher vertex) * 2^32 + face, ascending at a vertex."""
    offsets = np.zeros(n_vertices + 2, dtype=np.int64)  # see `listed_by_vertex`
    _count_keys(faces, offsets)
    np.cumsum(offsets, out=offsets)
    keys = np.empty(offsets[-1], dtype=np.int64)
    _fill_keys(faces, offsets, keys)
    return offsets[:-1], keys


def listed_edges(offsets: Longs, keys: Longs) -> tuple[Ints, Ints]:
    """(e, 2) every edge once, lower vertex first, rows ascending; and (e,) the number of faces at each."""
    count = count_edges(offsets, keys)[0]
    pairs, counts = np.empty((count, 2), dtype=np.int32), np.empty(count, dtype=np.int32)
    _list_edges(offsets, keys, pairs, counts)
    return pairs, counts


@compiled(nogil=True)
def _count_keys(faces: Ints, offsets: Longs) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            offsets[min(a, b) + 2] += 1
            offsets[min(b, c) + 2] += 1
            offsets[min(c, a) + 2] += 1


@compiled(nogil=True)
def _fill_keys(faces: Ints, offsets: Longs, keys: Longs) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            for u, v in ((a, b), (b, c), (c, a)):
                low = min(u, v)
                keys[offsets[low + 1]] = (np.int64(max(u, v)) << 32) | f
                offsets[low + 1] += 1
    for i in range(offsets.shape[0] - 2):
        sort_slice(keys, offsets[i], offsets[i + 1])


@compiled(nogil=True)
def end_of_edge(keys: Longs, start: int, stop: int) -> int:
    """The place after the last key of the edge whose first key is at `start`; the keys of its lower vertex end before `stop`."""
    end = start + 1
    while end < stop and keys[end] >> 32 == keys[start] >> 32:
        end += 1
    return end


@compiled(nogil=True)
def count_edges(offsets: Longs, keys: Longs) -> tuple[int, int]:
    """The number of edges, and of those with two faces."""
    count, two_faced = 0, 0
    for i in range(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        while start < stop:
            end = end_of_edge(keys, start, stop)
            count += 1
            two_faced += int(end - start == 2)
            start = end
    return count, two_faced


@compiled(nogil=True)
def _crowded_edges(offsets: Longs, keys: Longs) -> Ints:
    """The edges with more than two faces."""
    pairs = np.empty((keys.shape[0] // 3, 2), dtype=np.int32)  # of which the system gives what is written to
    count = 0
    for i in range(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        while start < stop:
            end = end_of_edge(keys, start, stop)
            if end - start > 2:
                pairs[count, 0], pairs[count, 1] = i, keys[start] >> 32
                count += 1
            start = end
    return pairs[:count].copy()


@compiled(nogil=True)
def _list_edges(offsets: Longs, keys: Longs, pairs: Ints, counts: Ints) -> None:
    at = -1
    for i in range(offsets.shape[0] - 1):
        for k in range(offsets[i], offsets[i + 1]):
            if k == offsets[i] or keys[k] >> 32 != keys[k - 1] >> 32:
                at += 1
                pairs[at, 0] = i
                pairs[at, 1] = keys[k] >> 32
                counts[at] = 1
            else:
                counts[at] += 1


def border_edges(faces: Ints) -> Ints:
    """(b, 2) the edges with exactly one face, lower vertex first, rows ascending."""
    pairs, counts = edge_face_counts(faces)
    border: Ints = pairs[counts == 1]
    return border


def border_vertices(faces: Ints, n_vertices: int) -> Bools:
    """(n,) whether a vertex lies on a border edge."""
    return mask_of(border_edges(faces), n_vertices)


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
    """The results of `edge_face_counts` and `face_adjacency`, in one pass."""
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
    row = 0
    for i in range(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        while start < stop:
            end = end_of_edge(keys, start, stop)
            if end - start == 2:
                pairs[row, 0] = keys[start] & 0xFFFFFFFF
                pairs[row, 1] = keys[start + 1] & 0xFFFFFFFF
                shared[row, 0] = i
                shared[row, 1] = keys[start] >> 32
                row += 1
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

"""The edges of a triangle list and the faces at each, in time linear in the mesh.

A face that names a vertex twice is not proper: it has no edges and references no vertex, so the faces on both sides of a
collapsed triangle share an edge. An edge with exactly one face is a border edge, one with more than two is non-manifold.
"""

from typing import Literal, TypeAlias, get_args

import numpy as np

from ..compilation import compiled
from ..mesh import Bools, Ints, Longs, mask_of
from .rings import listed_by_vertex, sort_slice

#: "fixed": border vertices stay. "along": only neighbours on the border count for them, so the border is smoothed as a curve.
#: "free": they are vertices like any other, and the border shrinks.
BorderPolicy: TypeAlias = Literal["fixed", "along", "free"]
BORDER_POLICIES: tuple[BorderPolicy, ...] = get_args(BorderPolicy)
#: More faces than an edge can have.
_ANY = 1 << 31


def edges(faces: Ints) -> Ints:
    """(e, 2) every edge once, lower vertex first, rows ascending."""
    return edge_face_counts(faces)[0]


def edge_face_counts(faces: Ints) -> tuple[Ints, Ints]:
    """(e, 2) every edge once, lower vertex first, rows ascending; and (e,) the number of faces at each."""
    pairs, counts = listed_edges(*faces_by_edge(faces))
    return pairs, counts.ravel()


def non_manifold_edges(faces: Ints) -> Ints:
    """(k, 2) the edges with more than two faces, lower vertex first, rows ascending."""
    return listed_edges(*faces_by_edge(faces), 3)[0]


def referenced_vertices(faces: Ints, n_vertices: int) -> Bools:
    """(n,) whether the vertex belongs to a proper face."""
    return mask_of(faces[proper_faces(faces)], n_vertices)


def proper_faces(faces: Ints | Longs) -> Bools:
    """(m,) whether the face names three different vertices."""
    a, b, c = faces.T
    return np.asarray((a != b) & (b != c) & (c != a))


def faces_by_edge(faces: Ints, n_vertices: int | None = None) -> tuple[Longs, Longs]:
    """The edges of all faces by their lower vertex; the key of each is (higher vertex) * 2^32 + face, ascending at a vertex."""
    triangles = np.ascontiguousarray(faces, dtype=np.int32)
    count = int(faces.max(initial=-1)) + 1 if n_vertices is None else n_vertices
    return listed_by_vertex(triangles, count, _count_keys, _fill_keys, np.int64)


def listed_edges(offsets: Longs, keys: Longs, least: int = 1, most: int = _ANY, *, columns: int = 1) -> tuple[Ints, Ints]:
    """(e, 2) every edge with `least` to `most` faces once, lower vertex first, rows ascending; and its faces.

    In one column (e, 1) their number, in two columns (e, 2) the first and the last of them.
    """
    count = _list_edges(offsets, keys, least, most, np.empty((0, 2), dtype=np.int32), np.empty((0, columns), dtype=np.int32))
    pairs, more = np.empty((count, 2), dtype=np.int32), np.empty((count, columns), dtype=np.int32)
    if count:
        _list_edges(offsets, keys, least, most, pairs, more)
    return pairs, more


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
def _list_edges(offsets: Longs, keys: Longs, least: int, most: int, pairs: Ints, more: Ints) -> int:
    """See `listed_edges`; writes those for which there is room, and returns how many they are."""
    count = 0
    for i in range(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        while start < stop:
            end = start + 1
            while end < stop and keys[end] >> 32 == keys[start] >> 32:
                end += 1
            if least <= end - start <= most:
                if count < pairs.shape[0]:
                    pairs[count, 0], pairs[count, 1] = i, keys[start] >> 32
                    if more.shape[1] == 1:
                        more[count, 0] = end - start
                    else:
                        more[count, 0], more[count, 1] = keys[start] & 0xFFFFFFFF, keys[end - 1] & 0xFFFFFFFF
                count += 1
            start = end
    return count


def border_edges(faces: Ints) -> Ints:
    """(b, 2) the edges with exactly one face, lower vertex first, rows ascending."""
    return listed_edges(*faces_by_edge(faces), 1, 1)[0]


def border_vertices(faces: Ints, n_vertices: int) -> Bools:
    """(n,) whether a vertex lies on a border edge."""
    return mask_of(border_edges(faces), n_vertices)


def face_adjacency(faces: Ints) -> tuple[Ints, Ints]:
    """(k, 2) the pairs of faces that share an edge with exactly two faces, lower face first; and (k, 2) that edge.

    The rows are in ascending order of the edge. Two faces that share two edges appear twice.
    """
    shared, pairs = listed_edges(*faces_by_edge(faces), 2, 2, columns=2)
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

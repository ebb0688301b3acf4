"""Incidence of vertices, edges and faces of a triangle list, as compressed sparse rows in linear time; edge flips.

A proper face has three different vertices. All other faces are ignored. A border edge has exactly one face, a non-manifold edge
has more than two.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from ..compilation import compiled, prange
from ..execution import threads_for
from ..mesh import Bools, Index, Ints, Longs, mask_of

#: "fixed": border vertices stay. "along": they are smoothed as a curve, by their neighbours along border edges alone. "free":
#: they are treated like all other vertices, and the border shrinks.
BorderPolicy: TypeAlias = Literal["fixed", "along", "free"]
BORDER_POLICIES: tuple[BorderPolicy, ...] = get_args(BorderPolicy)
#: More faces than an edge can have.
_ANY = 1 << 31
# Insertion sort is faster than merge sort up to this length.
_SHORT = 48


def edges(faces: Ints) -> Ints:
    """(e, 2) every edge once, lower vertex first, rows ascending."""
    return edge_face_counts(faces)[0]


def edge_face_counts(faces: Ints) -> tuple[Ints, Ints]:
    """(e, 2) every edge once, lower vertex first, rows ascending; and (e,) the number of faces at each edge."""
    pairs, counts = listed_edges(*faces_by_edge(faces))
    return pairs, counts.ravel()


def border_edges(faces: Ints) -> Ints:
    """(b, 2) the edges with exactly one face, lower vertex first, rows ascending."""
    return listed_edges(*faces_by_edge(faces), 1, 1)[0]


def non_manifold_edges(faces: Ints) -> Ints:
    """(k, 2) the edges with more than two faces, lower vertex first, rows ascending."""
    return listed_edges(*faces_by_edge(faces), 3)[0]


def face_adjacency(faces: Ints) -> tuple[Ints, Ints]:
    """(k, 2) the two faces of each edge with exactly two faces, lower face first; and (k, 2) the edges.

    The rows are in ascending order of the edges. Two faces that share two edges appear twice.
    """
    shared, pairs = listed_edges(*faces_by_edge(faces), 2, 2, columns=2)
    return pairs, shared


def border_vertices(faces: Ints, n_vertices: int) -> Bools:
    """(n,) whether the vertex lies on a border edge."""
    return mask_of(border_edges(faces), n_vertices)


def referenced_vertices(faces: Ints, n_vertices: int) -> Bools:
    """(n,) whether the vertex belongs to a proper face."""
    return mask_of(faces[proper_faces(faces)], n_vertices)


def proper_faces(faces: Ints | Longs) -> Bools:
    """(m,) whether the face names three different vertices."""
    a, b, c = faces.T
    return np.asarray((a != b) & (b != c) & (c != a))


def faces_by_edge(faces: Ints, n_vertices: int | None = None) -> tuple[Longs, Longs]:
    """(n + 1,) offsets, and keys: vertex i has the ascending keys j * 2^32 + f for the edges (i, j), j > i, of each face f."""
    count = int(faces.max(initial=-1)) + 1 if n_vertices is None else n_vertices
    return _listed_by_vertex(faces, count, _count_keys, _fill_keys, np.int64)


def listed_edges(offsets: Longs, keys: Longs, least: int = 1, most: int = _ANY, *, columns: int = 1) -> tuple[Ints, Ints]:
    """(e, 2) the edges with `least` to `most` faces, each once, lower vertex first, rows ascending; and (e, `columns`) integers.

    One column is the number of faces at each edge, two columns are its first and its last face. For keys see `faces_by_edge`.
    """
    # Arrays that are too long cost no memory: the system allocates only the pages that are written.
    pairs, edge_faces = np.empty((len(keys), 2), dtype=np.int32), np.empty((len(keys), columns), dtype=np.int32)
    count = _list_edges(offsets, keys, least, most, pairs, edge_faces)
    return pairs[:count], edge_faces[:count]


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
    count = 0
    for i in range(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        while start < stop:
            end = start + 1
            while end < stop and keys[end] >> 32 == keys[start] >> 32:
                end += 1
            if least <= end - start <= most:
                pairs[count, 0], pairs[count, 1] = i, keys[start] >> 32
                if more.shape[1] == 1:
                    more[count, 0] = end - start
                else:
                    more[count, 0], more[count, 1] = keys[start] & 0xFFFFFFFF, keys[end - 1] & 0xFFFFFFFF
                count += 1
            start = end
    return count


class OneRings(NamedTuple):
    """The neighbours of each vertex i: ``neighbours[offsets[i]:offsets[i + 1]]``, ascending, each once."""

    offsets: Longs  # (n + 1,)
    neighbours: Ints  # (2 e,) for e edges
    face_counts: Ints  # (2 e,) number of faces at the edge to each neighbour

    def along_border(self) -> "OneRings":
        """Neighbours along border edges; empty on a closed mesh."""
        border = self.face_counts == 1
        before = np.concatenate(([0], np.cumsum(border, dtype=np.int64)))
        return OneRings(before[self.offsets], self.neighbours[border], self.face_counts[border])


def one_rings(faces_or_edges: Ints, n_vertices: int) -> OneRings:
    """Returns the one-ring of every vertex, with the number of faces at each edge; a row of (e, 2) edges counts as one face."""
    if faces_or_edges.shape[1] == 2:
        pairs = np.asarray(faces_or_edges[faces_or_edges[:, 0] != faces_or_edges[:, 1]], dtype=np.int32)
        offsets = np.concatenate([[0], np.cumsum(np.bincount(pairs.ravel(), minlength=n_vertices))])
        ends = np.empty(2 * len(pairs), dtype=np.int32)
        _fill_edges(pairs, offsets[:-1].copy(), ends)
    else:
        offsets, ends = ring_ends(faces_or_edges, n_vertices)
    ring_offsets = np.zeros(n_vertices + 1, dtype=np.int64)
    with threads_for(n_vertices):
        _sort_and_count(offsets, ends, ring_offsets)
        np.cumsum(ring_offsets, out=ring_offsets)
        neighbours, face_counts = (np.empty(ring_offsets[-1], dtype=np.int32) for _ in range(2))
        _compress(offsets, ends, ring_offsets, neighbours, face_counts)
    return OneRings(ring_offsets, neighbours, face_counts)


@compiled
def _fill_edges(pairs: Ints, at: Longs, ends: Ints) -> None:
    for e in range(pairs.shape[0]):
        for k in range(2):
            ends[at[pairs[e, k]]] = pairs[e, 1 - k]
            at[pairs[e, k]] += 1


@compiled(parallel=True)
def _sort_and_count(offsets: Longs, ends: Ints, ring_sizes: Longs) -> None:
    for i in prange(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        sort_slice(ends, start, stop)
        size = 0
        for k in range(start, stop):
            if k == start or ends[k] != ends[k - 1]:
                size += 1
        ring_sizes[i + 1] = size


@compiled(parallel=True)
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


class VertexFaces(NamedTuple):
    """The faces at each vertex i: ``rows[offsets[i]:offsets[i + 1]]``, in ascending order of the faces."""

    offsets: Longs  # (n + 1,)
    rows: Ints  # (3 m, 3); a face f = (i, a, b), up to rotation, has the row (f, a, b) at vertex i


def vertex_faces(faces: Ints, n_vertices: int) -> VertexFaces:
    """Returns the proper faces at every vertex."""
    offsets, entries = _faces_by_vertex(faces, n_vertices, 3)
    return VertexFaces(offsets // 3, entries.reshape(-1, 3))


def ring_ends(faces: Ints, n_vertices: int) -> tuple[Longs, Ints]:
    """Returns `vertex_faces` without the face numbers: (n + 1,) offsets and (6 m,) ends.

    The ends of vertex i are ``ends[offsets[i]:offsets[i + 1]]``: a face (i, a, b) has the two entries a, b.
    """
    return _faces_by_vertex(faces, n_vertices, 2)


def _listed_by_vertex(
    faces: Ints, n_vertices: int, count: Callable[[Ints, Longs], None], fill: Callable[[Ints, Longs, Any], None], kind: Any
) -> tuple[Longs, Any]:
    """Returns (n + 1,) int64 offsets, and the entries of all vertices in one array.

    `count` adds the number of entries of vertex i to ``offsets[i + 2]``. After a cumulative sum these entries start at
    ``offsets[i + 1]``. `fill` writes each entry there and increments that offset; then the entries start at ``offsets[i]``.
    """
    triangles = np.ascontiguousarray(faces, dtype=np.int32)
    # Large arrays are allocated by numpy, not in kernels: numpy requests huge pages, which are twice as fast.
    offsets = np.zeros(n_vertices + 2, dtype=np.int64)
    count(triangles, offsets)
    np.cumsum(offsets, out=offsets)
    entries = np.empty(offsets[-1], dtype=kind)
    fill(triangles, offsets, entries)
    return offsets[:-1], entries


def _faces_by_vertex(faces: Ints, n_vertices: int, width: int) -> tuple[Longs, Ints]:
    return _listed_by_vertex(faces, n_vertices, partial(_count_faces, width), partial(_fill_faces, width), np.int32)


# A face has `width` entries at each of its vertices: the other two vertices, and before them the face number if `width` is 3.
@compiled
def _count_faces(width: int, faces: Ints, offsets: Longs) -> None:
    for f in range(faces.shape[0]):
        a, b, c = Index(faces[f, 0]), Index(faces[f, 1]), Index(faces[f, 2])
        if a != b and b != c and c != a:
            offsets[a + Index(2)] += width
            offsets[b + Index(2)] += width
            offsets[c + Index(2)] += width


@compiled
def _fill_faces(width: int, faces: Ints, offsets: Longs, entries: Ints) -> None:
    for f in range(faces.shape[0]):
        a, b, c = Index(faces[f, 0]), Index(faces[f, 1]), Index(faces[f, 2])
        if a != b and b != c and c != a:
            for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):
                at = Index(offsets[i + Index(1)])
                if width == 3:
                    entries[at] = f
                    at += Index(1)
                entries[at], entries[at + Index(1)] = np.int32(j), np.int32(k)
                offsets[i + Index(1)] = np.int64(at + Index(2))


@compiled
def sort_slice(values: Ints | Longs, start: int, stop: int) -> None:
    """Sorts ``values[start:stop]`` in place."""
    if stop - start > _SHORT:
        part = values[start:stop]
        part[:] = part[np.argsort(part, kind="mergesort")]
        return
    for k in range(start + 1, stop):
        value = values[k]
        j = k - 1
        while j >= start and values[j] > value:
            values[j + 1] = values[j]
            j -= 1
        values[j + 1] = value


@compiled
def position(neighbours: Ints, start: int, stop: int, j: int) -> int:
    """The index of j in `neighbours` by binary search in ``neighbours[start:stop]``, which is ascending and contains j."""
    while stop - start > 1:
        middle = (start + stop) // 2
        if neighbours[middle] <= j:
            start = middle
        else:
            stop = middle
    return start


def faces_across(faces: Ints) -> Ints:
    """(m, 3) int32 the face across each edge k of each face; edge k goes from corner k to the next.

    The entry is -1 if the edge does not have exactly two faces, or if its two faces are not coherently oriented.
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
    """The edge of face f that goes from u to v, 0 to 2; -1 if none does."""
    for k in range(3):
        if faces[f, k] == u and faces[f, (k + 1) % 3] == v:
            return k
    return -1


@compiled
def corner_at(faces: Ints, f: int, vertex: int) -> int:
    """The corner, 0 to 2, of face f at `vertex`."""
    if faces[f, 0] == vertex:
        return 0
    return 1 if faces[f, 1] == vertex else 2


@compiled
def diamond(faces: Ints, across: Ints, f: int, k: int) -> tuple[int, int, int, int]:
    """(a, b, c, d) for edge k from a to b of face f = (a, b, c) and the face (b, a, d) across, which must exist."""
    a, b, c = faces[f, k], faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
    g = across[f, k]
    return a, b, c, faces[g, (corner_at(faces, g, b) + 2) % 3]


@compiled
def fan_size(faces: Ints, across: Ints, f: int, k: int, other: int) -> int:
    """The number of faces in the fan round corner k of face f; -1 if one of these faces contains the vertex `other`."""
    vertex = faces[f, k]
    size, g, closed = 0, f, False
    for direction in range(2):
        while g >= 0 and not closed:
            size += 1
            i = corner_at(faces, g, vertex)
            if faces[g, (i + 1) % 3] == other or faces[g, (i + 2) % 3] == other:
                return -1
            g = across[g, i] if direction == 0 else across[g, (i + 2) % 3]
            closed = g == f
        if direction == 0 and not closed:
            g = across[f, (k + 2) % 3]
    return size


@compiled
def flip(faces: Ints, across: Ints, f: int, k: int) -> None:
    """Replaces the edge of a `diamond` by the other diagonal: f and the face across become (a, d, c) and (d, b, c)."""
    a, b, c, d = diamond(faces, across, f, k)
    g = across[f, k]
    j = corner_at(faces, g, b)
    ad, db = across[g, (j + 1) % 3], across[g, (j + 2) % 3]
    bc, ca = across[f, (k + 1) % 3], across[f, (k + 2) % 3]
    faces[f, 0], faces[f, 1], faces[f, 2] = a, d, c
    across[f, 0], across[f, 1], across[f, 2] = ad, g, ca
    faces[g, 0], faces[g, 1], faces[g, 2] = d, b, c
    across[g, 0], across[g, 1], across[g, 2] = db, bc, f
    _relink(faces, across, ad, a, d, f)
    _relink(faces, across, bc, b, c, g)


@compiled
def _relink(faces: Ints, across: Ints, f: int, a: int, b: int, now: int) -> None:
    """Sets the face across the edge from b to a of face f to `now`; does nothing if f is -1."""
    if f >= 0:
        across[f, _edge_from(faces, f, b, a)] = now

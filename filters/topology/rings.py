"""One-rings and faces of every vertex, as compressed rows, in time linear in the mesh."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..compilation import compiled, prange
from ..execution import threads_for
from ..mesh import Ints, Longs

# Indices are taken as unsigned numbers: for signed ones the compiler adds the test whether they count from the end.
_U: Any = np.uint64
# Up to this, an insertion sort is faster; above, its quadratic time would show at the hub of a large fan.
_SHORT = 48


class OneRings(NamedTuple):
    """The neighbours of every vertex: those of vertex i are ``neighbours[offsets[i]:offsets[i + 1]]``, ascending, each once."""

    offsets: Longs  # (n + 1,)
    neighbours: Ints  # (2 e,) for e edges
    face_counts: Ints  # (2 e,) how many faces the edge to that neighbour has: 1 on a border, more than 2 if non-manifold

    def along_border(self) -> "OneRings":
        """Neighbours along border edges; empty on a closed mesh."""
        border = self.face_counts == 1
        before = np.concatenate(([0], np.cumsum(border, dtype=np.int64)))
        return OneRings(before[self.offsets], self.neighbours[border], self.face_counts[border])


def one_rings(faces_or_edges: Ints, n_vertices: int) -> OneRings:
    """The one-ring of every vertex, and the number of faces at each of its edges; (e, 2) edges count as faces."""
    cells = np.ascontiguousarray(faces_or_edges, dtype=np.int32)
    if cells.shape[1] == 3:
        offsets, ends = ring_ends(cells, n_vertices)
    else:
        offsets, ends = listed_by_vertex(cells, n_vertices, _count_edges, _fill_edges)
    ring_offsets = np.zeros(n_vertices + 1, dtype=np.int64)
    with threads_for(n_vertices):
        _sort_and_count(offsets, ends, ring_offsets)
        np.cumsum(ring_offsets, out=ring_offsets)
        neighbours = np.empty(ring_offsets[-1], dtype=np.int32)
        face_counts = np.empty(ring_offsets[-1], dtype=np.int32)
        _compress(offsets, ends, ring_offsets, neighbours, face_counts)
    return OneRings(ring_offsets, neighbours, face_counts)


@compiled
def _count_edges(pairs: Ints, offsets: Longs) -> None:
    for e in range(pairs.shape[0]):
        a, b = pairs[e, 0], pairs[e, 1]
        if a != b:
            offsets[a + 2] += 1
            offsets[b + 2] += 1


@compiled
def _fill_edges(pairs: Ints, offsets: Longs, ends: Ints) -> None:
    for e in range(pairs.shape[0]):
        a, b = pairs[e, 0], pairs[e, 1]
        if a != b:
            ends[offsets[a + 1]] = b
            offsets[a + 1] += 1
            ends[offsets[b + 1]] = a
            offsets[b + 1] += 1


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
    """The faces at every vertex i: ``rows[offsets[i]:offsets[i + 1]]``, in ascending order of the faces."""

    offsets: Longs  # (n + 1,)
    rows: Ints  # (3 m, 3); face f with the vertices i, a, b in this cyclic order has the row (f, a, b) at vertex i


def vertex_faces(faces: Ints, n_vertices: int) -> VertexFaces:
    """The faces at every vertex; a face that names a vertex twice is left out."""
    offsets, entries = _faces_by_vertex(faces, n_vertices, 3)
    return VertexFaces(offsets // 3, entries.reshape(-1, 3))


def ring_ends(faces: Ints, n_vertices: int) -> tuple[Longs, Ints]:
    """`vertex_faces` without the numbers of the faces: at every vertex the two other vertices of each of its faces.

    Those of vertex i are the pairs in ``ends[offsets[i]:offsets[i + 1]]``: a face (i, a, b) has the two entries a, b.

    Returns:
        offsets: (n + 1,) int64, even numbers.
        ends: (6 m,) int32, fewer if faces name a vertex twice.
    """
    return _faces_by_vertex(faces, n_vertices, 2)


def listed_by_vertex(
    cells: Ints,
    n_vertices: int,
    count: Callable[[Ints, Longs], None],
    fill: Callable[[Ints, Longs, Any], None],
    kind: Any = np.int32,
) -> tuple[Longs, Any]:
    """One list of entries for every vertex.

    Args:
        cells: (m, 3) triangles or (e, 2) edges.
        n_vertices: n.
        count: adds the number of entries of vertex i to ``offsets[i + 2]``. Summed up, they begin at ``offsets[i + 1]``.
        fill: writes an entry of vertex i at ``offsets[i + 1]`` and increases that, so that in the end they begin at
            ``offsets[i]``.
        kind: the type of the entries.

    Returns:
        (n + 1,) int64 offsets and the entries.
    """
    # Large arrays come from numpy, never from a kernel: numpy asks the system for large pages, which makes them twice as fast.
    offsets = np.zeros(n_vertices + 2, dtype=np.int64)
    count(cells, offsets)
    np.cumsum(offsets, out=offsets)
    entries = np.empty(offsets[-1], dtype=kind)
    fill(cells, offsets, entries)
    return offsets[:-1], entries


def _faces_by_vertex(faces: Ints, n_vertices: int, width: int) -> tuple[Longs, Ints]:
    """The faces at every vertex by `width` entries each: 2 for the other vertices, 3 for the face and these."""
    triangles = np.ascontiguousarray(faces, dtype=np.int32)
    return listed_by_vertex(triangles, n_vertices, partial(_count_faces, width), partial(_fill_faces, width))


@compiled
def _count_faces(width: int, faces: Ints, offsets: Longs) -> None:
    for f in range(faces.shape[0]):
        a, b, c = _U(faces[f, 0]), _U(faces[f, 1]), _U(faces[f, 2])
        if a != b and b != c and c != a:
            offsets[a + _U(2)] += width
            offsets[b + _U(2)] += width
            offsets[c + _U(2)] += width


@compiled
def _fill_faces(width: int, faces: Ints, offsets: Longs, entries: Ints) -> None:
    for f in range(faces.shape[0]):
        a, b, c = _U(faces[f, 0]), _U(faces[f, 1]), _U(faces[f, 2])
        if a != b and b != c and c != a:
            for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):
                at = _U(offsets[i + _U(1)])
                if width == 3:
                    entries[at] = f
                    at += _U(1)
                entries[at], entries[at + _U(1)] = np.int32(j), np.int32(k)
                offsets[i + _U(1)] = np.int64(at + _U(2))


@compiled
def sort_slice(values: Ints | Longs, start: int, stop: int) -> None:
    """Sort ``values[start:stop]`` in place: by insertion if it is short, else by a heap."""
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


@compiled
def position(neighbours: Ints, start: int, stop: int, j: int) -> int:
    """The index of j in ``neighbours[start:stop]``, which is ascending and contains it."""
    while stop - start > 1:
        middle = (start + stop) // 2
        if neighbours[middle] <= j:
            start = middle
        else:
            stop = middle
    return start

"""The neighbours of every vertex, found in time linear in the mesh."""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled, prange
from ..execution import threads_for
from ..mesh import Ints, Longs
from .ascending_slices import sort_slice
from .lists_by_vertex import listed_by_vertex, ring_ends


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

    def along_border(self) -> "OneRings":
        """The neighbours along the edges with exactly one face; nobody has any on a closed mesh."""
        border = self.face_counts == 1
        before = np.concatenate(([0], np.cumsum(border, dtype=np.int64)))
        return OneRings(before[self.offsets], self.neighbours[border], self.face_counts[border])


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

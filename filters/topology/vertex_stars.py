"""The star of a vertex: its triangles in their order round it.

At a manifold vertex they form a closed ring, or on the border a fan from one border edge to the other. A kernel that needs both
triangles of every edge then visits each neighbour once.
"""

from typing import NamedTuple

import numpy as np

from ..execution import threads_for
from ..mesh import Ints, Longs
from .lists_by_vertex import ring_ends
from .star_lists import find_ends, write_stars
from .star_order import IRREGULAR, OPEN, Kinds, measure_irregular, order_ends


class Stars(NamedTuple):
    """The neighbours of every vertex i: ``neighbours[offsets[i]:offsets[i + 1]]``, each once.

    A star depends neither on the order of the faces nor on their orientation.

    Attributes:
        kinds: (n,) uint8, one of `NO_STAR`, `CLOSED`, `OPEN`, `IRREGULAR`.
        offsets: (n + 1,) int64.
        neighbours: (2 e,) int32. Closed: round the vertex from its lowest neighbour, towards the lower of the two beside that.
            Open: from border to border, the lower end first. Irregular (non-manifold edges, several fans, more than 64
            triangles): ascending. Low and high by the names of the vertices.
        irregular: int32 the vertices with an irregular star.
        end_offsets: int64, one more than irregular vertices.
        ends: int64, for each face of vertex ``irregular[k]`` the indices in `neighbours` of its other two vertices, from
            ``end_offsets[k]`` to ``end_offsets[k + 1]``.
    """

    kinds: Kinds
    offsets: Longs
    neighbours: Ints
    irregular: Ints
    end_offsets: Longs
    ends: Longs

    def face_counts(self) -> Ints:
        """(2 e,) the number of faces at the edge to each neighbour."""
        counts = np.full(len(self.neighbours), 2, dtype=np.int32)
        on_border = np.flatnonzero(self.kinds == OPEN)
        counts[self.offsets[on_border]] = counts[self.offsets[on_border + 1] - 1] = 1
        places, faces = np.unique(self.ends, return_counts=True)
        counts[places] = faces
        return counts

    def border_edges(self) -> Ints:
        """(b, 2) the edges with exactly one face, lower vertex first."""
        on_border = np.flatnonzero(self.kinds == OPEN)
        places, faces = np.unique(self.ends, return_counts=True)
        single = places[faces == 1]
        owners = np.concatenate([on_border, on_border, np.searchsorted(self.offsets, single, side="right") - 1])
        entries = np.concatenate([self.offsets[on_border], self.offsets[on_border + 1] - 1, single])
        pairs = np.column_stack([owners, self.neighbours[entries]]).astype(np.int32)
        # Each is found from both of its ends.
        edges: Ints = pairs[pairs[:, 0] < pairs[:, 1]]
        return edges


def stars(faces: Ints, n_vertices: int, *, names: Ints | None = None) -> Stars:
    """The star of every vertex, empty at vertices that no face uses.

    Args:
        faces: (m, 3) triangles.
        n_vertices: n.
        names: (n,) int32, a different one for every vertex, from which each star's first vertex and direction follow; None for
            the numbers of the vertices. Vertices that are numbered anew and keep their names keep their stars.
    """
    ring_offsets, ring = ring_ends(faces, n_vertices)
    del faces  # a list that nobody else holds makes room for what follows
    kinds: Kinds = np.empty(n_vertices, dtype=np.uint8)
    sizes: Ints = np.empty(n_vertices, dtype=np.int32)
    with threads_for(n_vertices):
        order_ends(ring_offsets, ring, kinds, sizes)
        irregular = np.flatnonzero(kinds == IRREGULAR).astype(np.int32)
        measure_irregular(ring_offsets, ring, irregular, sizes)
        offsets = np.zeros(n_vertices + 1, dtype=np.int64)
        np.cumsum(sizes, out=offsets[1:])
        neighbours = np.empty(offsets[-1], dtype=np.int32)
        write_stars(ring_offsets, ring, kinds, np.empty(0, dtype=np.int32) if names is None else names, offsets, neighbours)
    end_offsets = np.zeros(len(irregular) + 1, dtype=np.int64)
    np.cumsum(ring_offsets[irregular + 1] - ring_offsets[irregular], out=end_offsets[1:])
    ends = np.empty(end_offsets[-1], dtype=np.int64)
    find_ends(irregular, ring_offsets, ring, offsets[irregular], neighbours, end_offsets, ends)
    return Stars(kinds, offsets, neighbours, irregular, end_offsets, ends)

"""The star of a vertex: its triangles in their order round it.

At a manifold vertex they form a closed ring, or on the border a fan from one border edge to the other. A kernel that needs both
triangles of every edge then visits each neighbour once.
"""

from typing import NamedTuple

import numpy as np

from ..execution import threads_for
from ..mesh import Ints, Longs
from .lists_by_vertex import ring_ends
from .star_lists import find_ends, write_breadth_first, write_stars
from .star_order import IRREGULAR, OPEN, Kinds, measure_irregular, order_ends


class Stars(NamedTuple):
    """The neighbours of every vertex i: ``neighbours[offsets[i]:offsets[i + 1]]``, each once.

    A star depends neither on the order of the faces, nor on their orientation, nor on `order`.

    Attributes:
        order: None, or (n,) a permutation: vertex i here is vertex ``order[i]`` of the faces.
        kinds: (n,) uint8, one of `NO_STAR`, `CLOSED`, `OPEN`, `IRREGULAR`.
        offsets: (n + 1,) int64.
        neighbours: (2 e,) int32. Closed: round the vertex from its lowest neighbour, towards the lower of the two beside that.
            Open: from border to border, the lower end first. Irregular (non-manifold edges, several fans, more than 64
            triangles): ascending. Low and high by the numbers in the faces.
        irregular: int32 the vertices with an irregular star.
        end_offsets: int64, one more than irregular vertices.
        ends: int64, for each face of vertex ``irregular[k]`` the indices in `neighbours` of its other two vertices, from
            ``end_offsets[k]`` to ``end_offsets[k + 1]``.
    """

    order: Ints | None
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


def stars(faces: Ints, n_vertices: int, *, reorder: bool = False) -> Stars:
    """The star of every vertex, empty at vertices that no face uses.

    Args:
        faces: (m, 3) triangles.
        n_vertices: n.
        reorder: whether to renumber the vertices breadth first, so that neighbours lie near each other in memory. See
            `worth_reordering`.
    """
    ring_offsets, ring = ring_ends(faces, n_vertices)
    own_kinds: Kinds = np.empty(n_vertices, dtype=np.uint8)
    own_sizes: Ints = np.empty(n_vertices, dtype=np.int32)
    with threads_for(n_vertices):
        order_ends(ring_offsets, ring, own_kinds, own_sizes)
        measure_irregular(ring_offsets, ring, np.flatnonzero(own_kinds == IRREGULAR).astype(np.int32), own_sizes)
        offsets = np.zeros(n_vertices + 1, dtype=np.int64)
        neighbours = np.empty(own_sizes.sum(dtype=np.int64), dtype=np.int32)
        order, kinds = None, own_kinds
        if reorder:
            order, places = np.empty(n_vertices, dtype=np.int32), np.full(n_vertices, -1, dtype=np.int32)
            write_breadth_first(ring_offsets, ring, own_kinds, own_sizes, order, places, offsets, neighbours)
            kinds = own_kinds[order]
        else:
            np.cumsum(own_sizes, out=offsets[1:])
            write_stars(ring_offsets, ring, kinds, offsets, neighbours)
    irregular = np.flatnonzero(kinds == IRREGULAR).astype(np.int32)
    own = irregular if order is None else order[irregular]
    end_offsets = np.zeros(len(own) + 1, dtype=np.int64)
    np.cumsum(np.diff(ring_offsets)[own], out=end_offsets[1:])
    ends = np.empty(end_offsets[-1], dtype=np.int64)
    find_ends(own, ring_offsets, ring, offsets[irregular], end_offsets, ends)
    return Stars(order, kinds, offsets, neighbours, irregular, end_offsets, ends)

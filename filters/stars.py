"""The triangles around a vertex in the order in which one meets them walking round it.

Where a surface is a manifold this order is a closed ring, or on a border a fan from border to border. Then a kernel that needs
the two triangles of every edge gets them by looking at each neighbour once.
"""

from typing import NamedTuple, TypeAlias

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from .parallel import threads_for
from .topology import Ints, Longs, ring_ends

_Kinds: TypeAlias = NDArray[np.uint8]

#: the kinds of star: of an unreferenced vertex; a closed ring; a fan from border to border; anything else
NO_STAR, CLOSED, OPEN, IRREGULAR = 0, 1, 2, 3

# Sorting the triangles round a vertex takes quadratic time; the hub of a fan larger than this counts as irregular.
_LARGEST_WALK = 64


class Stars(NamedTuple):
    """The neighbours of every vertex i: ``neighbours[offsets[i]:offsets[i + 1]]``, each once.

    Neither the order of the faces nor their orientation makes a difference to a star.

    Attributes:
        kinds: (n,) uint8, one of `NO_STAR`, `CLOSED`, `OPEN`, `IRREGULAR`.
        offsets: (n + 1,) int64.
        neighbours: (2 e,) int32. Closed: round the vertex from the lowest neighbour, by way of the lower of its two sides. Open:
            from border to border, the lower end first. Irregular (non-manifold edges, several fans, very many triangles):
            ascending.
        irregular: int32 the vertices with an irregular star, ascending.
        corner_offsets: int64, one more than irregular vertices.
        corners: int32, ``corners[corner_offsets[k]:corner_offsets[k + 1]]`` are, for each face of vertex ``irregular[k]``, its
            other two vertices.
    """

    kinds: _Kinds
    offsets: Longs
    neighbours: Ints
    irregular: Ints
    corner_offsets: Longs
    corners: Ints

    def face_counts(self) -> Ints:
        """(2 e,) the number of faces at the edge to each neighbour."""
        counts = np.full(len(self.neighbours), 2, dtype=np.int32)
        on_border = np.flatnonzero(self.kinds == OPEN)
        counts[self.offsets[on_border]] = counts[self.offsets[on_border + 1] - 1] = 1
        _count_faces(self.irregular, self.offsets, self.corner_offsets, self.corners, counts)
        return counts

    def border_edges(self) -> Ints:
        """(b, 2) the edges with exactly one face, lower vertex first."""
        on_border = np.flatnonzero(self.kinds == OPEN)
        owners = np.concatenate([on_border, on_border])
        entries = np.concatenate([self.offsets[on_border], self.offsets[on_border + 1] - 1])
        if len(self.irregular):
            sizes = np.diff(self.offsets)
            candidates = np.flatnonzero(np.repeat(self.kinds == IRREGULAR, sizes))
            single = self.face_counts()[candidates] == 1
            owners = np.concatenate([owners, np.repeat(self.irregular, sizes[self.irregular])[single]])
            entries = np.concatenate([entries, candidates[single]])
        pairs = np.column_stack([owners, self.neighbours[entries]]).astype(np.int32)
        # Each is found from both of its ends.
        edges: Ints = pairs[pairs[:, 0] < pairs[:, 1]]
        return edges


def stars(faces: Ints, n_vertices: int, order: Ints | None = None) -> Stars:
    """The star of every vertex, those of vertices that no face uses empty.

    Args:
        faces: (m, 3) triangles.
        n_vertices: n.
        order: (n,) a permutation; if given, vertex k of the result is vertex ``order[k]`` of the faces.
    """
    corner_offsets, corners = ring_ends(faces, n_vertices)
    own_kinds: _Kinds = np.empty(n_vertices, dtype=np.uint8)
    own_sizes: Ints = np.empty(n_vertices, dtype=np.int32)
    new = np.empty(0, dtype=np.int32) if order is None else inverse(order)
    with threads_for(n_vertices):
        _walk(corner_offsets, corners, own_kinds, own_sizes)
        kinds, sizes = (own_kinds, own_sizes) if order is None else (own_kinds[order], own_sizes[order])
        offsets = np.zeros(n_vertices + 1, dtype=np.int64)
        np.cumsum(sizes, out=offsets[1:])
        neighbours = np.empty(offsets[-1], dtype=np.int32)
        _write(new if order is None else order, new, corner_offsets, corners, kinds, offsets, neighbours)
    irregular = np.flatnonzero(kinds == IRREGULAR).astype(np.int32)
    own = irregular if order is None else order[irregular]
    kept_offsets = np.zeros(len(own) + 1, dtype=np.int64)
    np.cumsum(np.diff(corner_offsets)[own] if len(own) else [], out=kept_offsets[1:])
    kept = np.empty(kept_offsets[-1], dtype=np.int32)
    _copy_corners(own, corner_offsets, corners, kept_offsets, kept)
    return Stars(kinds, offsets, neighbours, irregular, kept_offsets, kept if order is None else new[kept])


def inverse(order: Ints) -> Ints:
    """(n,) where each vertex comes in the permutation."""
    places = np.empty_like(order)
    places[order] = np.arange(len(order), dtype=order.dtype)
    return places


@njit(cache=True)
def _chain(corners: Ints, start: int, stop: int) -> int:
    """Reorder the pairs into a walk a-b, b-c, c-d ... in place; the kind of star that it is."""
    turned = False
    k = start + 2
    while k < stop:
        end = corners[k - 1]
        m = k
        while m < stop and corners[m] != end and corners[m + 1] != end:
            m += 2
        if m < stop:
            a, b = corners[m], corners[m + 1]
            corners[m], corners[m + 1] = corners[k], corners[k + 1]
            if a == end:
                corners[k], corners[k + 1] = a, b
            else:
                corners[k], corners[k + 1] = b, a
            k += 2
        elif not turned:
            # The walk met a border: turn it round and go on from where it began.
            corners[start:k] = corners[start:k][::-1].copy()
            turned = True
        else:
            return IRREGULAR
    for k in range(start, stop, 2):
        for m in range(start, k, 2):
            if corners[m] == corners[k]:
                return IRREGULAR
    if corners[start] == corners[stop - 1] and stop - start > 2:
        return CLOSED
    for m in range(start, stop, 2):
        if corners[m] == corners[stop - 1]:
            return IRREGULAR
    return OPEN


@njit(cache=True, parallel=True)
def _walk(corner_offsets: Longs, corners: Ints, kinds: _Kinds, sizes: Ints) -> None:
    for i in prange(kinds.shape[0]):
        start, stop = corner_offsets[i], corner_offsets[i + 1]
        if stop == start:
            kinds[i] = NO_STAR
            sizes[i] = 0
            continue
        kind = IRREGULAR
        if stop - start <= 2 * _LARGEST_WALK:
            kind = _chain(corners, start, stop)
        kinds[i] = kind
        if kind == CLOSED:
            sizes[i] = (stop - start) // 2
        elif kind == OPEN:
            sizes[i] = (stop - start) // 2 + 1
        else:
            sizes[i] = np.unique(corners[start:stop]).shape[0]


@njit(cache=True, parallel=True)
def _write(order: Ints, new: Ints, corner_offsets: Longs, corners: Ints, kinds: _Kinds, offsets: Longs, neighbours: Ints) -> None:
    for i in prange(kinds.shape[0]):
        own = order[i] if order.shape[0] else np.int32(i)
        _write_star(corners, corner_offsets[own], corner_offsets[own + 1], kinds[i], neighbours, offsets[i], offsets[i + 1])
        if new.shape[0]:
            for k in range(offsets[i], offsets[i + 1]):
                neighbours[k] = new[neighbours[k]]
            if kinds[i] == IRREGULAR:
                neighbours[offsets[i] : offsets[i + 1]].sort()


@njit(cache=True)
def _write_star(corners: Ints, start: int, stop: int, kind: int, neighbours: Ints, at: int, end: int) -> None:
    if kind == CLOSED:
        lowest = start
        for k in range(start, stop, 2):
            if corners[k] < corners[lowest]:
                lowest = k
        before = lowest - 2 if lowest > start else stop - 2
        forward = corners[lowest + 1] <= corners[before]
        k = lowest
        for m in range(at, end):
            neighbours[m] = corners[k]
            k += 2 if forward else -2
            if k == stop:
                k = start
            elif k < start:
                k = stop - 2
    elif kind == OPEN:
        forward = corners[start] < corners[stop - 1]
        for m in range(at, end - 1):
            neighbours[m] = corners[start + 2 * (m - at)] if forward else corners[stop - 1 - 2 * (m - at)]
        neighbours[end - 1] = corners[stop - 1] if forward else corners[start]
    elif kind == IRREGULAR:
        neighbours[at:end] = np.unique(corners[start:stop])


@njit(cache=True)
def _copy_corners(vertices: Ints, from_offsets: Longs, corners: Ints, to_offsets: Longs, kept: Ints) -> None:
    for k in range(vertices.shape[0]):
        i = vertices[k]
        kept[to_offsets[k] : to_offsets[k + 1]] = corners[from_offsets[i] : from_offsets[i + 1]]


@njit(cache=True)
def _count_faces(vertices: Ints, offsets: Longs, corner_offsets: Longs, corners: Ints, counts: Ints) -> None:
    for k in range(vertices.shape[0]):
        ends = np.sort(corners[corner_offsets[k] : corner_offsets[k + 1]])
        at = offsets[vertices[k]] - 1
        for m in range(ends.shape[0]):
            if m == 0 or ends[m] != ends[m - 1]:
                at += 1
                counts[at] = 0
            counts[at] += 1

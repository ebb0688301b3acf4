"""The triangles around a vertex in the order in which one meets them walking round it.

Where a surface is a manifold this order is a closed ring, or on a border a fan from border to border. Then a kernel that needs
the two triangles of every edge gets them by looking at each neighbour once.
"""

from typing import NamedTuple, TypeAlias

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from ..execution import threads_for
from ..mesh import Ints, Longs
from .rings import position, ring_ends, sort_slice

_Kinds: TypeAlias = NDArray[np.uint8]

#: the kinds of star: of an unreferenced vertex; a closed ring; a fan from border to border; anything else
NO_STAR, CLOSED, OPEN, IRREGULAR = 0, 1, 2, 3

# Sorting the triangles round a vertex takes quadratic time; the hub of a fan larger than this counts as irregular.
_LARGEST_WALK = 64


class Stars(NamedTuple):
    """The neighbours of every vertex i: ``neighbours[offsets[i]:offsets[i + 1]]``, each once.

    Neither the order of the faces nor their orientation makes a difference to a star, nor does `order`.

    Attributes:
        order: None, or (n,) a permutation: vertex i here is vertex ``order[i]`` of the faces.
        kinds: (n,) uint8, one of `NO_STAR`, `CLOSED`, `OPEN`, `IRREGULAR`.
        offsets: (n + 1,) int64.
        neighbours: (2 e,) int32. Closed: round the vertex from the lowest neighbour, by way of the lower of its two sides. Open:
            from border to border, the lower end first. Irregular (non-manifold edges, several fans, very many triangles):
            ascending. Low and high by the numbers in the faces.
        irregular: int32 the vertices with an irregular star.
        corner_offsets: int64, one more than irregular vertices.
        corners: int64, for each face of vertex ``irregular[k]`` the places of its other two vertices in `neighbours`, from
            ``corner_offsets[k]`` to ``corner_offsets[k + 1]``.
    """

    order: Ints | None
    kinds: _Kinds
    offsets: Longs
    neighbours: Ints
    irregular: Ints
    corner_offsets: Longs
    corners: Longs

    def face_counts(self) -> Ints:
        """(2 e,) the number of faces at the edge to each neighbour."""
        counts = np.full(len(self.neighbours), 2, dtype=np.int32)
        on_border = np.flatnonzero(self.kinds == OPEN)
        counts[self.offsets[on_border]] = counts[self.offsets[on_border + 1] - 1] = 1
        places, faces = np.unique(self.corners, return_counts=True)
        counts[places] = faces
        return counts

    def border_edges(self) -> Ints:
        """(b, 2) the edges with exactly one face, lower vertex first."""
        on_border = np.flatnonzero(self.kinds == OPEN)
        places, faces = np.unique(self.corners, return_counts=True)
        single = places[faces == 1]
        owners = np.concatenate([on_border, on_border, np.searchsorted(self.offsets, single, side="right") - 1])
        entries = np.concatenate([self.offsets[on_border], self.offsets[on_border + 1] - 1, single])
        pairs = np.column_stack([owners, self.neighbours[entries]]).astype(np.int32)
        # Each is found from both of its ends.
        edges: Ints = pairs[pairs[:, 0] < pairs[:, 1]]
        return edges


def stars(faces: Ints, n_vertices: int, *, reorder: bool = False) -> Stars:
    """The star of every vertex, those of vertices that no face uses empty.

    Args:
        faces: (m, 3) triangles.
        n_vertices: n.
        reorder: whether to renumber the vertices breadth first, so that neighbours lie near each other in memory. See
            `worth_reordering`.
    """
    corner_offsets, corners = ring_ends(faces, n_vertices)
    own_kinds: _Kinds = np.empty(n_vertices, dtype=np.uint8)
    own_sizes: Ints = np.empty(n_vertices, dtype=np.int32)
    with threads_for(n_vertices):
        _walk(corner_offsets, corners, own_kinds, own_sizes)
        _measure_irregular(corner_offsets, corners, np.flatnonzero(own_kinds == IRREGULAR).astype(np.int32), own_sizes)
        offsets = np.zeros(n_vertices + 1, dtype=np.int64)
        neighbours = np.empty(own_sizes.sum(dtype=np.int64), dtype=np.int32)
        order, kinds = None, own_kinds
        if reorder:
            order, places = np.empty(n_vertices, dtype=np.int32), np.full(n_vertices, -1, dtype=np.int32)
            _write_breadth_first(corner_offsets, corners, own_kinds, own_sizes, order, places, offsets, neighbours)
            kinds = own_kinds[order]
        else:
            np.cumsum(own_sizes, out=offsets[1:])
            _write(corner_offsets, corners, kinds, offsets, neighbours)
    irregular = np.flatnonzero(kinds == IRREGULAR).astype(np.int32)
    own = irregular if order is None else order[irregular]
    place_offsets = np.zeros(len(own) + 1, dtype=np.int64)
    np.cumsum(np.diff(corner_offsets)[own], out=place_offsets[1:])
    corner_places = np.empty(place_offsets[-1], dtype=np.int64)
    _find_corners(own, corner_offsets, corners, offsets[irregular], place_offsets, corner_places)
    return Stars(order, kinds, offsets, neighbours, irregular, place_offsets, corner_places)


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
            for j in range((k - start) // 2):
                corners[start + j], corners[k - 1 - j] = corners[k - 1 - j], corners[start + j]
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


@njit(cache=True)
def _measure_irregular(corner_offsets: Longs, corners: Ints, irregular: Ints, sizes: Ints) -> None:
    for i in irregular:
        sizes[i] = _distinct(corners, corner_offsets[i], corner_offsets[i + 1]).shape[0]


@njit(cache=True)
def _distinct(corners: Ints, start: int, stop: int) -> Ints:
    """The vertices in ``corners[start:stop]``, each once, ascending."""
    ends = corners[start:stop].copy()
    sort_slice(ends, 0, ends.shape[0])
    count = 0
    for end in ends:
        if count == 0 or end != ends[count - 1]:
            ends[count] = end
            count += 1
    return ends[:count]


@njit(cache=True, parallel=True)
def _write(corner_offsets: Longs, corners: Ints, kinds: _Kinds, offsets: Longs, neighbours: Ints) -> None:
    for i in prange(kinds.shape[0]):
        start, stop = corner_offsets[i], corner_offsets[i + 1]
        _write_star(corners, start, stop, kinds[i], neighbours, offsets[i], offsets[i + 1])


@njit(cache=True)
def _write_breadth_first(
    corner_offsets: Longs,
    corners: Ints,
    kinds: _Kinds,
    sizes: Ints,
    order: Ints,
    places: Ints,
    offsets: Longs,
    neighbours: Ints,
) -> None:
    """The stars in the order in which a front reaches them that starts at the lowest vertex, component by component."""
    reached = lowest = 0
    for k in range(order.shape[0]):
        if k == reached:
            while places[lowest] >= 0:
                lowest += 1
            order[reached] = lowest
            places[lowest] = reached
            reached += 1
        i = order[k]
        at, end = offsets[k], offsets[k] + sizes[i]
        offsets[k + 1] = end
        _write_star(corners, corner_offsets[i], corner_offsets[i + 1], kinds[i], neighbours, at, end)
        for m in range(at, end):
            j = neighbours[m]
            if places[j] < 0:
                order[reached] = j
                places[j] = reached
                reached += 1
            neighbours[m] = places[j]


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
        ring = _distinct(corners, start, stop)
        for m in range(at, end):
            neighbours[m] = ring[m - at]


@njit(cache=True)
def _find_corners(
    vertices: Ints, corner_offsets: Longs, corners: Ints, starts: Longs, place_offsets: Longs, places: Longs
) -> None:
    """Where each corner of the listed vertices is in their ascending stars, which begin at `starts`."""
    for k in range(vertices.shape[0]):
        start, stop = corner_offsets[vertices[k]], corner_offsets[vertices[k] + 1]
        ring = _distinct(corners, start, stop)
        for m in range(start, stop):
            places[place_offsets[k] + m - start] = starts[k] + position(ring, 0, ring.shape[0], corners[m])

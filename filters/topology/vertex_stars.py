"""Stars of vertices: the neighbours of each vertex in their order round it.

At a manifold vertex the triangles form a closed ring, or on the border a fan between two border edges. With this order, a kernel
that needs both triangles of each edge visits each neighbour once. For a face (i, a, b), a and b are "ends" at i, (a, b) a "pair".
"""

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..compilation import compiled, prange
from ..execution import threads_for
from ..mesh import Index, Ints, Longs
from .incidence import ring_ends, sort_slice

Kinds: TypeAlias = NDArray[np.uint8]
#: The kinds of stars: no triangle; a closed ring; a fan from border to border; anything else.
NO_STAR, CLOSED, OPEN, IRREGULAR = 0, 1, 2, 3
# Ordering the triangles round a vertex may take quadratic time: a star with more triangles than this counts as irregular.
_LARGEST_WALK = 64
# The number of vertices that share a hash table.
_BLOCK = 1024
_SLOT_BITS = 10
#: The size of the hash table in which kernels look up vertices, see `slot_of`.
SLOTS = 1 << _SLOT_BITS
# The fields of a table entry of `_walk_round`, from the lowest bit on: slot, tag, place, vertex.
_TAG, _PLACE, _VERTEX = Index(_SLOT_BITS), Index(20), Index(32)
_SLOTS, _TAGS, _PLACES = Index(SLOTS - 1), Index((_BLOCK - 1) << _SLOT_BITS), Index(2 * _LARGEST_WALK - 1)
_NOTHING = Index(2**64 - 1)


class Stars(NamedTuple):
    """The neighbours of each vertex i: ``neighbours[offsets[i]:offsets[i + 1]]``, each once.

    A closed star starts at the lowest neighbour and goes on to the lower of the two vertices next to it. An open star goes from
    the lower to the higher border vertex. An irregular star (non-manifold edges, several fans, over 64 triangles) is ascending.
    Lower means the lower vertex name, see `stars`.
    """

    kinds: Kinds  # (n,) uint8, one of `NO_STAR`, `CLOSED`, `OPEN`, `IRREGULAR`
    offsets: Longs  # (n + 1,)
    neighbours: Ints  # (2 e,)
    irregular: Ints  # the vertices with an irregular star
    end_offsets: Longs
    # from ``end_offsets[k]`` on, for each face of vertex ``irregular[k]`` the indices in `neighbours` of the other two vertices
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
        """(b, 2) the edges with exactly one face, the lower vertex index first."""
        on_border = np.flatnonzero(self.kinds == OPEN)
        places, faces = np.unique(self.ends, return_counts=True)
        entries = np.concatenate([self.offsets[on_border], self.offsets[on_border + 1] - 1, places[faces == 1]])
        owners = np.searchsorted(self.offsets, entries, side="right") - 1
        pairs = np.column_stack([owners, self.neighbours[entries]]).astype(np.int32)
        return np.asarray(pairs[pairs[:, 0] < pairs[:, 1]])  # `pairs` has each edge in both directions


def stars(faces: Ints, n_vertices: int, *, names: Ints | None = None) -> Stars:
    """Returns the star of every vertex; the star of a vertex that no face uses is empty.

    The (n,) int32 `names`, all different, decide the first vertex and the direction of each star; None takes the vertex indices.
    """
    ring_offsets, ring = ring_ends(faces, n_vertices)
    del faces  # frees memory, unless the caller holds a reference
    walks = np.empty(len(ring) // 2, dtype=np.int32)
    kinds: Kinds = np.empty(n_vertices, dtype=np.uint8)
    with threads_for(n_vertices):
        order_ends(ring_offsets, ring, names, kinds, walks)
        if kinds.max(initial=NO_STAR) <= CLOSED:
            ring_offsets >>= 1  # the walk of a star starts at half its offset in `ring`
            nothing = np.empty(0, dtype=np.int32)
            return Stars(kinds, ring_offsets, walks, nothing, np.zeros(1, dtype=np.int64), nothing.astype(np.int64))
        take_walks(ring_offsets, ring, kinds, walks)
        del walks  # frees memory for the neighbours
        irregular = np.flatnonzero(kinds == IRREGULAR).astype(np.int32)
        offsets = np.zeros(n_vertices + 1, dtype=np.int64)
        sizes = offsets[1:]
        sizes[:] = np.diff(ring_offsets) // 2 + (kinds == OPEN)
        measure_irregular(ring_offsets, ring, irregular, sizes)
        np.cumsum(sizes, out=sizes)
        neighbours = np.empty(offsets[-1], dtype=np.int32)
        write_stars(ring_offsets, ring, kinds, names, offsets, neighbours)
    end_offsets = np.concatenate([[0], np.cumsum(ring_offsets[irregular + 1] - ring_offsets[irregular])])
    ends = np.empty(end_offsets[-1], dtype=np.int64)
    find_ends(irregular, ring_offsets, ring, offsets[irregular], neighbours, end_offsets, ends)
    return Stars(kinds, offsets, neighbours, irregular, end_offsets, ends)


@compiled(parallel=True)
def take_walks(end_offsets: Longs, ends: Ints, kinds: Kinds, walks: Ints) -> None:
    """Copies each closed star from `walks` to the place in `ends` where its pairs start."""
    for i in prange(kinds.shape[0]):
        if kinds[i] == CLOSED:
            start, size = Index(end_offsets[i]), Index((end_offsets[i + 1] - end_offsets[i]) // 2)
            for m in range(size):
                ends[start + m] = walks[start // Index(2) + m]


@compiled(parallel=True)
def write_stars(end_offsets: Longs, ends: Ints, kinds: Kinds, names: Ints | None, offsets: Longs, neighbours: Ints) -> None:
    """Writes the stars of all vertices to `neighbours`, from the ends that `order_ends` and `take_walks` have ordered."""
    for i in prange(kinds.shape[0]):
        start, stop, at, end = Index(end_offsets[i]), Index(end_offsets[i + 1]), Index(offsets[i]), Index(offsets[i + 1])
        if kinds[i] == CLOSED:
            for m in range(end - at):
                neighbours[at + m] = ends[start + m]
        elif kinds[i] == OPEN:
            forward = _name(names, ends[start]) < _name(names, ends[stop - Index(1)])
            for m in range(end - at - Index(1)):
                neighbours[at + m] = ends[start + Index(2) * m] if forward else ends[stop - Index(1) - Index(2) * m]
            neighbours[end - Index(1)] = ends[stop - Index(1)] if forward else ends[start]
        elif kinds[i] == IRREGULAR:
            ring = distinct_ends(ends, end_offsets[i], end_offsets[i + 1])
            if names is not None:
                ring = ring[np.argsort(names[ring])]
            neighbours[offsets[i] : offsets[i + 1]] = ring


@compiled
def find_ends(
    vertices: Ints, end_offsets: Longs, ends: Ints, starts: Longs, neighbours: Ints, place_offsets: Longs, places: Longs
) -> None:
    """Writes to `places` the index in `neighbours` of each end of the listed vertices, whose stars start at `starts`."""
    for k in range(vertices.shape[0]):
        start, stop = end_offsets[vertices[k]], end_offsets[vertices[k] + 1]
        ring = distinct_ends(ends, start, stop)
        place = np.empty(ring.shape[0], dtype=np.int64)
        for m in range(ring.shape[0]):
            place[np.searchsorted(ring, neighbours[starts[k] + m])] = starts[k] + m
        for m in range(start, stop):
            places[place_offsets[k] + m - start] = place[np.searchsorted(ring, ends[m])]


@compiled
def _name(names: Ints | None, i: int) -> int:
    return i if names is None else names[i]


@compiled(parallel=True)
def order_ends(end_offsets: Longs, ends: Ints, names: Ints | None, kinds: Kinds, walks: Ints) -> None:
    """Writes the kinds of all stars, writes closed stars to `walks` at half their offset, and orders the pairs of open stars."""
    n = kinds.shape[0]
    for block in prange((n + _BLOCK - 1) // _BLOCK):
        table = np.full(SLOTS, _NOTHING, dtype=np.uint64)
        for i in range(block * _BLOCK, min((block + 1) * _BLOCK, n)):
            start, stop = end_offsets[i], end_offsets[i + 1]
            size = (stop - start) // 2
            kinds[i] = IRREGULAR if size > 0 else NO_STAR
            if 0 < size <= _LARGEST_WALK:
                if _walk_round(ends, start, stop, names, table, i - block * _BLOCK, walks):
                    kinds[i] = CLOSED
                else:
                    kinds[i] = _chain(ends, start, stop)
                    if kinds[i] == CLOSED:
                        _write_walk(ends, start, size, names, walks)


@compiled
def slot_of(vertex: int) -> int:
    """The hash of a vertex, from 0 to `SLOTS` - 1; neighbours of a vertex mostly have different hashes."""
    slot: int = (Index(vertex) * Index(0x9E3779B97F4A7C15)) >> Index(64 - _SLOT_BITS)
    return slot


@compiled
def _walk_round(ends: Ints, start: int, stop: int, names: Ints | None, table: Any, tag: int, walks: Ints) -> bool:
    """Joins the pairs of a star to a closed walk ab, bc, cd ... za, and writes it to `walks`; returns False if it finds none.

    An entry of the hash `table` has the vertex, the place of its pair, the tag of this star and the slot of the next vertex. The
    walk fails if triangles are oriented differently or two vertices share a slot.
    """
    first, last = Index(start), Index(stop)
    begin, before = ends[first], ends[first]  # the vertex with the lowest name, and the vertex before it
    least, lowest = _name(names, begin), _name(names, ends[first + Index(1)])
    tagged, k = Index(tag) << _TAG, first
    while k < last:
        vertex, after = ends[k], ends[k + Index(1)]
        table[slot_of(vertex)] = Index(vertex) << _VERTEX | (k - first) << _PLACE | tagged | slot_of(after)
        name, name_after = _name(names, vertex), _name(names, after)
        begin, before = vertex if name < least else begin, vertex if name_after < lowest else before
        least, lowest = min(name, least), min(name_after, lowest)
        k += Index(2)
    at, size, wrong = first // Index(2), (last - first) // Index(2), Index(0)
    slot = slot_of(begin)
    # In `walks` the lower neighbour follows `begin`: if `second` is lower, `walks` is filled forwards, else from its last place.
    second = ends[first + (table[slot] >> _PLACE & _PLACES) + Index(1)]
    forward = _name(names, second) <= _name(names, before)
    place, way = (np.int64(at), 1) if forward else (np.int64(at + size), -1)
    vertex, walks[at], k = begin, begin, Index(0)
    while k < size:
        entry = table[slot]
        wrong |= ((entry >> _VERTEX) ^ Index(vertex)) | ((entry ^ tagged) & _TAGS) | Index((k > Index(0)) & (vertex == begin))
        if k > Index(0):
            walks[place] = vertex
        # The entry of another star may point beyond the last pair.
        vertex, slot = ends[min(first + (entry >> _PLACE & _PLACES), last - Index(2)) + Index(1)], entry & _SLOTS
        place += way
        k += Index(1)
    return bool((vertex == begin) & (wrong == Index(0)) & (size > Index(1)))


@compiled
def _write_walk(ends: Ints, start: int, size: int, names: Ints | None, walks: Ints) -> None:
    """Writes to `walks` the walk ab, bc ... za of the `size` pairs from `start` on, in the order of `Stars`."""
    walk = ends[start : start + 2 * size : 2]
    lowest = 0
    for m in range(size):
        lowest = m if _name(names, walk[m]) < _name(names, walk[lowest]) else lowest
    way = 1 if _name(names, walk[(lowest + 1) % size]) <= _name(names, walk[lowest - 1]) else -1
    for m in range(size):
        walks[start // 2 + m] = walk[(lowest + way * m) % size]


@compiled
def _chain(ends: Ints, start: int, stop: int) -> int:
    """Orders the pairs from `start` to `stop` in place as a walk ab, bc, cd ...; returns the kind of the star."""
    reversed_once = False
    k = start + 2
    while k < stop:
        end = ends[k - 1]
        m = k
        while m < stop and ends[m] != end and ends[m + 1] != end:
            m += 2
        if m < stop:
            a, b = ends[m], ends[m + 1]
            ends[m], ends[m + 1] = ends[k], ends[k + 1]
            if a == end:
                ends[k], ends[k + 1] = a, b
            else:
                ends[k], ends[k + 1] = b, a
            k += 2
        elif not reversed_once:
            # The walk has reached a border: reverse it and continue at the other end.
            for j in range((k - start) // 2):
                ends[start + j], ends[k - 1 - j] = ends[k - 1 - j], ends[start + j]
            reversed_once = True
        else:
            return IRREGULAR
    for k in range(start, stop, 2):
        for m in range(start, k, 2):
            if ends[m] == ends[k]:
                return IRREGULAR
    if ends[start] == ends[stop - 1] and stop - start > 2:
        return CLOSED
    for m in range(start, stop, 2):
        if ends[m] == ends[stop - 1]:
            return IRREGULAR
    return OPEN


@compiled
def measure_irregular(end_offsets: Longs, ends: Ints, irregular: Ints, sizes: Longs) -> None:
    """Writes the number of neighbours of each vertex with an irregular star to `sizes`."""
    for i in irregular:
        sizes[i] = distinct_ends(ends, end_offsets[i], end_offsets[i + 1]).shape[0]


@compiled
def distinct_ends(ends: Ints, start: int, stop: int) -> Ints:
    """The vertices in ``ends[start:stop]``, each once, ascending."""
    ring = ends[start:stop].copy()
    sort_slice(ring, 0, ring.shape[0])
    count = 0
    for end in ring:
        if count == 0 or end != ring[count - 1]:
            ring[count] = end
            count += 1
    return ring[:count]

"""The neighbours of every vertex written from its ordered triangles."""

import numpy as np

from ..compilation import compiled, prange
from ..mesh import Ints, Longs
from .star_order import CLOSED, IRREGULAR, OPEN, Kinds, distinct_ends


@compiled(parallel=True)
def write_stars(end_offsets: Longs, ends: Ints, kinds: Kinds, names: Ints, offsets: Longs, neighbours: Ints) -> None:
    """The stars of all vertices; low and high vertices are those of low and high names, or numbers if there are no names."""
    for i in prange(kinds.shape[0]):
        _write_star(ends, end_offsets[i], end_offsets[i + 1], kinds[i], names, neighbours, offsets[i], offsets[i + 1])


@compiled
def find_ends(
    vertices: Ints, end_offsets: Longs, ends: Ints, starts: Longs, neighbours: Ints, place_offsets: Longs, places: Longs
) -> None:
    """The index of every end of the listed vertices in `neighbours`, where their stars begin at `starts`."""
    for k in range(vertices.shape[0]):
        start, stop = end_offsets[vertices[k]], end_offsets[vertices[k] + 1]
        ring = distinct_ends(ends, start, stop)
        place = np.empty(ring.shape[0], dtype=np.int64)
        for m in range(ring.shape[0]):
            place[np.searchsorted(ring, neighbours[starts[k] + m])] = starts[k] + m
        for m in range(start, stop):
            places[place_offsets[k] + m - start] = place[np.searchsorted(ring, ends[m])]


@compiled
def _name(names: Ints, i: int) -> int:
    return names[i] if names.shape[0] else i


@compiled
def _write_star(ends: Ints, start: int, stop: int, kind: int, names: Ints, neighbours: Ints, at: int, end: int) -> None:
    """Write the neighbours of one vertex, whose pairs are ordered, from `at` to `end`, in the order that `Stars` states."""
    if kind == CLOSED:
        lowest = start
        for k in range(start, stop, 2):
            if _name(names, ends[k]) < _name(names, ends[lowest]):
                lowest = k
        before = lowest - 2 if lowest > start else stop - 2
        forward = _name(names, ends[lowest + 1]) <= _name(names, ends[before])
        k = lowest
        for m in range(at, end):
            neighbours[m] = ends[k]
            k += 2 if forward else -2
            if k == stop:
                k = start
            elif k < start:
                k = stop - 2
    elif kind == OPEN:
        forward = _name(names, ends[start]) < _name(names, ends[stop - 1])
        for m in range(at, end - 1):
            neighbours[m] = ends[start + 2 * (m - at)] if forward else ends[stop - 1 - 2 * (m - at)]
        neighbours[end - 1] = ends[stop - 1] if forward else ends[start]
    elif kind == IRREGULAR:
        ring = distinct_ends(ends, start, stop)
        if names.shape[0]:
            ring = ring[np.argsort(names[ring])]
        for m in range(at, end):
            neighbours[m] = ring[m - at]

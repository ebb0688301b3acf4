"""The neighbours of every vertex written from its ordered triangles, in the order of the vertices or breadth first."""

from ..compilation import compiled, prange
from ..mesh import Ints, Longs
from .ascending_slices import position
from .star_order import CLOSED, IRREGULAR, OPEN, Kinds, distinct_ends


@compiled(parallel=True)
def write_stars(end_offsets: Longs, ends: Ints, kinds: Kinds, offsets: Longs, neighbours: Ints) -> None:
    """The stars in the order of the vertices."""
    for i in prange(kinds.shape[0]):
        start, stop = end_offsets[i], end_offsets[i + 1]
        _write_star(ends, start, stop, kinds[i], neighbours, offsets[i], offsets[i + 1])


@compiled
def write_breadth_first(
    end_offsets: Longs,
    ends: Ints,
    kinds: Kinds,
    sizes: Ints,
    order: Ints,
    places: Ints,
    offsets: Longs,
    neighbours: Ints,
) -> None:
    """The stars in breadth-first order from the lowest vertex of each component, and the neighbours numbered in this order."""
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
        _write_star(ends, end_offsets[i], end_offsets[i + 1], kinds[i], neighbours, at, end)
        for m in range(at, end):
            j = neighbours[m]
            if places[j] < 0:
                order[reached] = j
                places[j] = reached
                reached += 1
            neighbours[m] = places[j]


@compiled
def find_ends(vertices: Ints, end_offsets: Longs, ends: Ints, starts: Longs, place_offsets: Longs, places: Longs) -> None:
    """The index of every end of the listed vertices in their ascending stars, which begin at `starts`."""
    for k in range(vertices.shape[0]):
        start, stop = end_offsets[vertices[k]], end_offsets[vertices[k] + 1]
        ring = distinct_ends(ends, start, stop)
        for m in range(start, stop):
            places[place_offsets[k] + m - start] = starts[k] + position(ring, 0, ring.shape[0], ends[m])


@compiled
def _write_star(ends: Ints, start: int, stop: int, kind: int, neighbours: Ints, at: int, end: int) -> None:
    """Write the neighbours of one vertex, whose pairs are ordered, from `at` to `end`, in the order that `Stars` states."""
    if kind == CLOSED:
        lowest = start
        for k in range(start, stop, 2):
            if ends[k] < ends[lowest]:
                lowest = k
        before = lowest - 2 if lowest > start else stop - 2
        forward = ends[lowest + 1] <= ends[before]
        k = lowest
        for m in range(at, end):
            neighbours[m] = ends[k]
            k += 2 if forward else -2
            if k == stop:
                k = start
            elif k < start:
                k = stop - 2
    elif kind == OPEN:
        forward = ends[start] < ends[stop - 1]
        for m in range(at, end - 1):
            neighbours[m] = ends[start + 2 * (m - at)] if forward else ends[stop - 1 - 2 * (m - at)]
        neighbours[end - 1] = ends[stop - 1] if forward else ends[start]
    elif kind == IRREGULAR:
        ring = distinct_ends(ends, start, stop)
        for m in range(at, end):
            neighbours[m] = ring[m - at]

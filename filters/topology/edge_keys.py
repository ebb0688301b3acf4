"""The edges of all faces as sorted keys, in time linear in the mesh: the ground of all lists of edges."""

import numpy as np

from ..compilation import compiled
from ..mesh import Ints, Longs
from .ascending_slices import sort_slice


def faces_by_edge(faces: Ints, n_vertices: int) -> tuple[Longs, Longs]:
    """The edges of all faces by their lower vertex; the key of each is (higher vertex) * 2^32 + face, ascending at a vertex."""
    offsets = np.zeros(n_vertices + 2, dtype=np.int64)  # see `listed_by_vertex`
    _count_keys(faces, offsets)
    np.cumsum(offsets, out=offsets)
    keys = np.empty(offsets[-1], dtype=np.int64)
    _fill_keys(faces, offsets, keys)
    return offsets[:-1], keys


def listed_edges(offsets: Longs, keys: Longs) -> tuple[Ints, Ints]:
    """(e, 2) every edge once, lower vertex first, rows ascending; and (e,) the number of faces at each."""
    count = count_edges(offsets, keys)[0]
    pairs, counts = np.empty((count, 2), dtype=np.int32), np.empty(count, dtype=np.int32)
    _list_edges(offsets, keys, pairs, counts)
    return pairs, counts


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
def end_of_edge(keys: Longs, start: int, stop: int) -> int:
    """The place after the last key of the edge whose first key is at `start`; the keys of its lower vertex end before `stop`."""
    end = start + 1
    while end < stop and keys[end] >> 32 == keys[start] >> 32:
        end += 1
    return end


@compiled(nogil=True)
def count_edges(offsets: Longs, keys: Longs) -> tuple[int, int]:
    """How many edges there are, and how many of them have two faces."""
    count, two_faced = 0, 0
    for i in range(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        while start < stop:
            end = end_of_edge(keys, start, stop)
            count += 1
            two_faced += int(end - start == 2)
            start = end
    return count, two_faced


@compiled(nogil=True)
def _list_edges(offsets: Longs, keys: Longs, pairs: Ints, counts: Ints) -> None:
    at = -1
    for i in range(offsets.shape[0] - 1):
        for k in range(offsets[i], offsets[i + 1]):
            if k == offsets[i] or keys[k] >> 32 != keys[k - 1] >> 32:
                at += 1
                pairs[at, 0] = i
                pairs[at, 1] = keys[k] >> 32
                counts[at] = 1
            else:
                counts[at] += 1

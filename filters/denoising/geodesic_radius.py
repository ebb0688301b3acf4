"""The faces within a distance along the surface, measured by steps from centre to centre."""

import numpy as np

from ..compilation import compiled, prange
from ..mesh import Floats, Ints, Longs
from .compressed_rows import compressed_rows


def within_geodesic_radius(near_offsets: Longs, near: Ints, centres: Floats, radius: float) -> tuple[Longs, Ints]:
    """The faces j around every face i with d(i, j) <= radius, d the length of the shortest path of steps from centre to centre.

    A step goes straight to the centre of a face that shares a vertex. On a plane of equal triangles such paths are up to 3.6 %
    longer than straight lines, 2.2 % in the mean. Across a crease a step is shorter than the path on the surface, at a right
    angle by up to 29 %, at the rim of a thin wall by more. Two sheets that lie close together without being connected nearby are
    as far apart as the path along the surface is long.

    Args:
        near_offsets: (m + 1,) the faces that share a vertex with face i are ``near[near_offsets[i]:near_offsets[i + 1]]``.
        near: those faces.
        centres: (m, 3) the centres of the faces.
        radius: in the unit of the centres, above 0.

    Returns:
        offsets: (m + 1,) int64.
        neighbours: int32, those of face i between its two offsets, each once and without i, in the order of the search.
    """

    def visit(parts: int, offsets: Longs, neighbours: Ints) -> None:
        _visit(near_offsets, near, centres, radius, parts, offsets, neighbours)

    return compressed_rows(len(centres), visit)


@compiled(parallel=True)
def _visit(near_offsets: Longs, near: Ints, centres: Floats, radius: float, parts: int, offsets: Longs, neighbours: Ints) -> None:
    """`compressed_rows` asks for it."""
    for part in prange(parts):
        first, last = part * centres.shape[0] // parts, (part + 1) * centres.shape[0] // parts
        _visit_some(near_offsets, near, centres, radius, first, last, offsets, neighbours)


@compiled
def _visit_some(
    near_offsets: Longs, near: Ints, centres: Floats, radius: float, first: int, last: int, offsets: Longs, neighbours: Ints
) -> None:
    """`_visit` for the faces from `first` to before `last`.

    A face whose path has become shorter passes this on to its neighbours, until none has. With few faces this is faster than a
    queue ordered by length, and the lengths are the same.
    """
    seen = np.full(centres.shape[0], -1, dtype=np.int32)
    place = np.empty(centres.shape[0], dtype=np.int32)
    met, length, shortened = np.empty(64, dtype=np.int32), np.empty(64), np.empty(64, dtype=np.bool_)
    for i in range(first, last):
        seen[i], place[i] = i, 0
        met[0], length[0], shortened[0] = i, 0.0, True
        found, again = 1, True
        while again:
            again = False
            at = 0
            while at < found:
                if shortened[at]:
                    shortened[at] = False
                    g = met[at]
                    for k in range(near_offsets[g], near_offsets[g + 1]):
                        h = near[k]
                        x, y, z = centres[h, 0] - centres[g, 0], centres[h, 1] - centres[g, 1], centres[h, 2] - centres[g, 2]
                        way = length[at] + np.sqrt(x * x + y * y + z * z)
                        if way > radius or (seen[h] == i and way >= length[place[h]]):
                            continue
                        if seen[h] != i:
                            if found == met.shape[0]:
                                met, length = np.concatenate((met, met)), np.concatenate((length, length))
                                shortened = np.concatenate((shortened, shortened))
                            seen[h], place[h], met[found] = i, found, h
                            found += 1
                        length[place[h]], shortened[place[h]] = way, True
                        again = True
                at += 1
        if neighbours.shape[0]:
            neighbours[offsets[i] : offsets[i + 1]] = met[1:found]
        else:
            offsets[i + 1] = found - 1

"""The faces at every vertex."""

from typing import NamedTuple

import numpy as np
from numba import njit

from ..mesh import Ints, Longs


class Corners(NamedTuple):
    """The faces at every vertex i: the rows ``corners[offsets[i]:offsets[i + 1]]``.

    Attributes:
        offsets: (n + 1,) int64.
        corners: (3 m, 3) int32: the face, and its two other vertices in the order in which the face names them after i.
    """

    offsets: Longs
    corners: Ints


def vertex_corners(faces: Ints, n_vertices: int) -> Corners:
    """The faces at every vertex, in ascending order; a face that names a vertex twice is none."""
    offsets = np.zeros(n_vertices + 2, dtype=np.int64)
    _count_corners(faces, offsets)
    np.cumsum(offsets, out=offsets)
    corners = np.empty((offsets[-1], 3), dtype=np.int32)
    _fill_corners(faces, offsets, corners)
    return Corners(offsets[:-1], corners)


@njit(cache=True)
def _count_corners(faces: Ints, offsets: Longs) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            offsets[a + 2] += 1
            offsets[b + 2] += 1
            offsets[c + 2] += 1


@njit(cache=True)
def _fill_corners(faces: Ints, offsets: Longs, corners: Ints) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):
                at = offsets[i + 1]
                corners[at, 0], corners[at, 1], corners[at, 2] = f, j, k
                offsets[i + 1] = at + 1

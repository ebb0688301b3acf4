"""Which moves of single vertices make a surface flatter: those of spikes do, those of clean vertices off an edge do not."""

import math

import numpy as np

from ..compilation import compiled
from ..execution import over_range
from ..geometry import cross_product
from ..mesh import Bools, Floats, Ints, Longs
from ..topology import edges, faces_across, vertex_faces

# Of neighbours the one that gains most moves first: so many passes, or until nobody gains more than rounding.
_PASSES, _ROUNDING = 20, 1e-6


def flattening(points: Floats, moved: Floats, faces: Ints, which: Bools) -> Bools:
    """(n,) those of some vertices whose moves make the surface flatter, each by itself.

    The roughness around a vertex is the sum of |n_f - n_g| over the edges of its faces, f and g the faces at an edge. Rounding an
    edge of the surface does not lower that sum, and denting it raises it; taking a spike away lowers it. Of adjacent vertices the
    one that lowers it most moves, then all are looked at again, those that have moved whether they had better go back.

    Args:
        points: (n, 3) coordinates.
        moved: (n, 3) where vertices would move.
        faces: (m, 3) triangles.
        which: (n,) the vertices that may.
    """
    gone = np.zeros(len(points), dtype=np.bool_)
    candidates = np.flatnonzero(which).astype(np.int32)
    if not len(candidates):
        return gone
    at_vertices, across = vertex_faces(faces, len(points)), faces_across(faces)
    a, b = edges(faces).T
    now, gains = points.copy(), np.zeros(len(points))
    for _ in range(_PASSES):
        other = np.where(gone[:, None], points, moved)
        around = (now, other, faces, at_vertices.offsets, at_vertices.rows, across, candidates)
        over_range(_measure_gains, len(candidates), *around, gains)
        best = gains.copy()
        np.maximum.at(best, a, gains[b])
        np.maximum.at(best, b, gains[a])
        turned = (gains > _ROUNDING) & (gains == best)
        if not turned.any():
            break
        now[turned] = other[turned]
        gone ^= turned
    return gone


@compiled(nogil=True)
def _measure_gains(
    points: Floats,
    moved: Floats,
    faces: Ints,
    offsets: Longs,
    rows: Ints,
    across: Ints,
    which: Ints,
    gains: Floats,
    first: int,
    last: int,
) -> None:
    """By how much moving each of the vertices alone lowers the roughness around it."""
    for at in range(first, last):
        i = which[at]
        gain = 0.0
        for k in range(offsets[i], offsets[i + 1]):
            f = rows[k, 0]
            for edge in range(3):
                g = across[f, edge]
                if g < 0:
                    continue
                inner = faces[g, 0] == i or faces[g, 1] == i or faces[g, 2] == i
                change = _bend(points, points, faces, i, f, g) - _bend(points, moved, faces, i, f, g)
                gain += 0.5 * change if inner else change
        gains[i] = gain


@compiled(nogil=True)
def _bend(points: Floats, places: Floats, faces: Ints, i: int, f: int, g: int) -> float:
    """|n_f - n_g| with vertex i at its place."""
    corners = np.empty((6, 3))
    for corner in range(3):
        for row, face in ((corner, f), (3 + corner, g)):
            j = faces[face, corner]
            for axis in range(3):
                corners[row, axis] = places[j, axis] if j == i else points[j, axis]
    ax, ay, az = cross_product(corners, 0, 1, 2)
    bx, by, bz = cross_product(corners, 3, 4, 5)
    a, b = math.sqrt(ax * ax + ay * ay + az * az), math.sqrt(bx * bx + by * by + bz * bz)
    a, b = 1.0 / a if a > 0.0 else 0.0, 1.0 / b if b > 0.0 else 0.0
    x, y, z = ax * a - bx * b, ay * a - by * b, az * a - bz * b
    return math.sqrt(x * x + y * y + z * z)

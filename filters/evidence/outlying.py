"""Vertices that stand out from all that is around them: impulses, which filters that keep edges keep too."""

import math

import numpy as np

from ..compilation import compiled
from ..execution import over_range
from ..geometry import cross_product
from ..mesh import Bools, Floats, Ints, Longs
from ..topology import OneRings, edges, faces_across, one_rings, referenced_vertices, vertex_faces
from .held_out import with_neighbours
from .quadric_prediction import predicted_heights
from .tuned import CLIP, MEDIAN_OF_NORMAL, NO_NOISE, STANDS_OUT

# Those that stand out most hide others: so many passes, or until hardly any are found.
_PASSES, _HARDLY_ANY = 20, 1e-4
# No move gains less than rounding.
_ROUNDING = 1e-6
# Two rings have a dozen vertices to some dozens.
_MOST = 1024


def outlying_vertices(points: Floats, faces: Ints, normals: Floats) -> Bools:
    """(n,) the vertices that stand out, and without which their neighbours are better known.

    The size of vertex i is s = |h| / sqrt(1 + g^2) of `predicted_heights`, which it has no part in. It stands out if s is the
    largest of its one-ring, more than three times the median of the two rings around, and more than three times the deviation of
    the mesh, median s / 0.6745. It is taken for an outlier if the sum of the s^2 of its neighbours falls when it is left out: the
    tip of a spike tells nothing of the surface, that of a cone does. Then the next ones are looked for, without it.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        normals: (n, 3) unit normals of a smoothed copy.

    Returns:
        Of Gaussian noise about one vertex in a thousand; of vertices that are off by far most, those on borders too.
    """
    rings, pairs = one_rings(faces, len(points)), edges(faces)
    used = referenced_vertices(faces, len(points))
    hidden = np.zeros(len(points), dtype=np.bool_)
    if not used.any():
        return hidden
    sizes = _sizes(points, rings, normals, hidden)
    for _ in range(_PASSES):
        level = max(NO_NOISE, STANDS_OUT / MEDIAN_OF_NORMAL * float(np.median(sizes[used & ~hidden])))
        found = np.zeros_like(hidden)
        over_range(_stand_out, len(points), sizes, rings.offsets, rings.neighbours, hidden | ~used, level, found)
        without = _sizes(points, rings, normals, hidden | found)
        change = np.where(hidden | found, 0.0, without**2 - sizes**2)
        of_rings = np.bincount(pairs[:, 0], change[pairs[:, 1]], len(points))
        of_rings += np.bincount(pairs[:, 1], change[pairs[:, 0]], len(points))
        accepted = found & (of_rings < 0.0)
        hidden |= accepted
        if np.count_nonzero(accepted) <= _HARDLY_ANY * len(points):
            break
        sizes = without if np.array_equal(accepted, found) else _sizes(points, rings, normals, hidden)
    return hidden


def standing_out(heights: Floats, faces: Ints, level: float) -> Bools:
    """(n,) the vertices whose heights differ from those around them by far.

    With m the median of the heights h in the two rings around, and d the median of |h - m| there, a vertex stands out if |h| is
    above the level, and |h - m| above the level and above 4 d. Then the next ones are looked for, without it. Where a filter has
    changed a place as a whole, as by rounding a narrow edge, its vertices do not stand out.

    Args:
        heights: (n,) how far each vertex is from where a filter put it, along its normal.
        faces: (m, 3) triangles.
        level: heights below it never stand out.
    """
    rings = one_rings(faces, len(heights))
    out = np.zeros(len(heights), dtype=np.bool_)
    for _ in range(_PASSES):
        found = np.zeros_like(out)
        over_range(_differ, len(heights), heights, rings.offsets, rings.neighbours, out, level, found)
        out |= found
        if np.count_nonzero(found) <= _HARDLY_ANY * len(heights):
            break
    return out


def sizes_beside(points: Floats, faces: Ints, normals: Floats, outlying: Bools, scored: Bools) -> tuple[float, float]:
    """How far vertices that are no outliers are from where others expect them: those beside an outlier, and all others.

    Spikes strike anywhere, so that both are alike. Uneven noise stands out where it is loud, and all vertices there are off.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        normals: (n, 3) unit normals of a smoothed copy.
        outlying: (n,) the outliers, which nothing is expected by.
        scored: (n,) the vertices that count.

    Returns:
        Both medians of the sizes s of `outlying_vertices`; 0 where no vertex is.
    """
    beside = with_neighbours(outlying, edges(faces))
    sizes, counted = _sizes(points, one_rings(faces, len(points)), normals, outlying), scored & ~outlying
    near, far = (sizes[counted & which] for which in (beside, ~beside))
    return (float(np.median(near)) if len(near) else 0.0), (float(np.median(far)) if len(far) else 0.0)


def put_where_expected(points: Floats, faces: Ints, normals: Floats, which: Ints) -> Floats:
    """(n, 3) the points, some vertices moved along their normals to where the quadric through the others expects them."""
    hidden = np.zeros(len(points), dtype=np.bool_)
    hidden[which] = True
    heights, _ = predicted_heights(points, one_rings(faces, len(points)), normals, which, hidden)
    result = points.copy()
    result[which] += heights[:, None] * normals[which]
    return result


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


def _sizes(points: Floats, rings: OneRings, normals: Floats, hidden: Bools) -> Floats:
    heights, gains = predicted_heights(points, rings, normals, np.arange(len(points), dtype=np.int32), hidden)
    return np.asarray(np.abs(heights) / np.sqrt(1.0 + gains**2))


@compiled(nogil=True)
def _gather_around(i: int, values: Floats, offsets: Longs, neighbours: Ints, ignored: Bools, seen: Ints, around: Floats) -> int:
    """Put the values in the two rings around a vertex, but those that are ignored, into `around`; how many there are."""
    count = 0
    for near in range(offsets[i], offsets[i + 1]):
        g = neighbours[near]
        for far in range(offsets[g] - 1, offsets[g + 1]):
            j = g if far < offsets[g] else neighbours[far]
            if j == i or ignored[j] or count == _MOST or (seen[:count] == j).any():
                continue
            seen[count], around[count] = j, values[j]
            count += 1
    return count


@compiled(nogil=True)
def _stand_out(
    sizes: Floats, offsets: Longs, neighbours: Ints, ignored: Bools, level: float, found: Bools, first: int, last: int
) -> None:
    """Which vertices stand out of those that are not ignored."""
    around, seen = np.empty(_MOST), np.empty(_MOST, dtype=np.int32)
    for i in range(first, last):
        if ignored[i] or sizes[i] <= level:
            continue
        largest = True
        for near in range(offsets[i], offsets[i + 1]):
            g = neighbours[near]
            largest &= ignored[g] or not sizes[g] > sizes[i]
        if not largest:
            continue
        count = _gather_around(i, sizes, offsets, neighbours, ignored, seen, around)
        found[i] = count > 0 and sizes[i] > STANDS_OUT * np.median(around[:count])


@compiled(nogil=True)
def _differ(
    heights: Floats, offsets: Longs, neighbours: Ints, ignored: Bools, level: float, found: Bools, first: int, last: int
) -> None:
    """Which vertices stand out by their heights of those that are not ignored."""
    around, seen = np.empty(_MOST), np.empty(_MOST, dtype=np.int32)
    for i in range(first, last):
        if ignored[i] or not abs(heights[i]) > level:
            continue
        count = _gather_around(i, heights, offsets, neighbours, ignored, seen, around)
        middle = np.median(around[:count]) if count else 0.0
        usual = np.median(np.abs(around[:count] - middle)) if count else 0.0
        found[i] = abs(heights[i] - middle) > max(level, CLIP * usual)


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

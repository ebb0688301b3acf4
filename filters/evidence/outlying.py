"""Vertices that stand out from all that is around them: impulses, which filters that keep edges keep too.

Everywhere here `points` are (n, 3) coordinates with a mean edge of 1, `faces` (m, 3) triangles, `normals` (n, 3) unit normals of
a smoothed copy, and what is true or false of vertices is an (n,) array.
"""

import math

import numpy as np

from ..compilation import compiled
from ..execution import over_range
from ..geometry import cross_product, normal_differences
from ..mesh import Bools, Floats, Ints
from ..topology import OneRings, VertexFaces, edges, faces_across, one_rings, referenced_vertices, vertex_faces
from .held_out import marked, with_neighbours
from .quadric_prediction import MOST, height_residuals, predicted_heights, two_rings
from .tuned import CLIP, MEDIAN_OF_NORMAL, NO_NOISE, STANDS_OUT

# Those that stand out most hide others: so many passes, or until hardly any are found.
_PASSES, _HARDLY_ANY = 20, 1e-4
# No move gains less than rounding.
_ROUNDING = 1e-6


def outlying_vertices(points: Floats, faces: Ints, normals: Floats) -> Bools:
    """(n,) the vertices that stand out, and without which their neighbours are better known.

    The size s of a vertex is that of its `height_residuals`. It stands out if s is the largest of its one-ring, more than three
    times the median of the two rings around, and more than three times the deviation of the mesh, median s / 0.6745. It is taken
    for an outlier if the sum of the s^2 of its neighbours falls when it is left out: the tip of a spike tells nothing of the
    surface, that of a cone does. Then the next ones are looked for, without it.

    Of Gaussian noise it is about one vertex in a thousand; of vertices that are off by far most, those on borders too.
    """
    rings, pairs = one_rings(faces, len(points)), edges(faces)
    used = referenced_vertices(faces, len(points))
    hidden = np.zeros(len(points), dtype=np.bool_)
    if not used.any():
        return hidden
    sizes = np.abs(height_residuals(points, rings, normals, hidden))
    for _ in range(_PASSES):
        level = max(NO_NOISE, STANDS_OUT / MEDIAN_OF_NORMAL * float(np.median(sizes[used & ~hidden])))
        largest = used & ~hidden & (sizes > level)
        a, b = pairs[largest[pairs].all(axis=1)].T
        largest[a[sizes[a] < sizes[b]]] = largest[b[sizes[b] < sizes[a]]] = False
        found = largest & (sizes > STANDS_OUT * _medians_around(sizes, rings, hidden | ~used, largest, np.inf)[0])
        without = np.abs(height_residuals(points, rings, normals, hidden | found))
        change = np.where(hidden | found, 0.0, without**2 - sizes**2)
        of_rings = np.bincount(pairs[:, 0], change[pairs[:, 1]], len(points))
        of_rings += np.bincount(pairs[:, 1], change[pairs[:, 0]], len(points))
        accepted = found & (of_rings < 0.0)
        hidden |= accepted
        if np.count_nonzero(accepted) <= _HARDLY_ANY * len(points):
            break
        sizes = without if np.array_equal(accepted, found) else np.abs(height_residuals(points, rings, normals, hidden))
    return hidden


def standing_out(heights: Floats, faces: Ints, level: float) -> Bools:
    """(n,) the vertices that are by far farther from where a filter put them than those around them, by (n,) heights.

    With m the median of the heights h in the two rings around, and d the median of |h - m| there, a vertex stands out if |h| is
    above the level, and |h - m| above the level and above 4 d. Then the next ones are looked for, without it. Where a filter has
    changed a place as a whole, as by rounding a narrow edge, its vertices do not stand out.
    """
    rings = one_rings(faces, len(heights))
    out = np.zeros(len(heights), dtype=np.bool_)
    for _ in range(_PASSES):
        found = ~out & (np.abs(heights) > level)
        middles, usual = _medians_around(heights, rings, out, found, 0.0)
        found &= np.abs(heights - middles) > np.maximum(level, CLIP * usual)
        out |= found
        if np.count_nonzero(found) <= _HARDLY_ANY * len(heights):
            break
    return out


def sizes_beside(points: Floats, faces: Ints, normals: Floats, outlying: Bools, scored: Bools) -> tuple[float, float]:
    """How far vertices that are no outliers are from where others expect them: those beside an outlier, and all others.

    Spikes strike anywhere, so that both are alike. Uneven noise stands out where it is loud, and all vertices there are off.
    Both are medians of the sizes s of `outlying_vertices` over the vertices that are `scored`, outliers hidden; 0 without any.
    """
    beside = with_neighbours(outlying, edges(faces))
    sizes, counted = np.abs(height_residuals(points, one_rings(faces, len(points)), normals, outlying)), scored & ~outlying
    near, far = (sizes[counted & which] for which in (beside, ~beside))
    return (float(np.median(near)) if len(near) else 0.0), (float(np.median(far)) if len(far) else 0.0)


def put_where_expected(points: Floats, faces: Ints, normals: Floats, which: Ints) -> Floats:
    """(n, 3) the points, some vertices moved along their normals to where the quadric through the others expects them."""
    hidden = marked(which, len(points))
    heights, _ = predicted_heights(points, one_rings(faces, len(points)), normals, which, hidden)
    result = points.copy()
    result[which] += heights[:, None] * normals[which]
    return result


def roughness(points: Floats, faces: Ints) -> float:
    """The mean difference |n_f - n_g| of the unit normals of adjacent faces; 0 without any."""
    differences = normal_differences(points, faces)
    return float(differences.mean()) if len(differences) else 0.0


def flattening(points: Floats, moved: Floats, faces: Ints, which: Bools) -> Bools:
    """(n,) those of some vertices whose moves to the (n, 3) places `moved` make the surface flatter, each by itself.

    The roughness around a vertex is the sum of |n_f - n_g| over the edges of its faces, f and g the faces at an edge. Rounding an
    edge of the surface does not lower that sum, and denting it raises it; taking a spike away lowers it. Of adjacent vertices the
    one that lowers it most moves, then all are looked at again, those that have moved whether they had better go back.
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
        over_range(_measure_gains, len(candidates), now, other, faces, at_vertices, across, candidates, gains)
        best = gains.copy()
        np.maximum.at(best, a, gains[b])
        np.maximum.at(best, b, gains[a])
        turned = (gains > _ROUNDING) & (gains == best)
        if not turned.any():
            break
        now[turned] = other[turned]
        gone ^= turned
    return gone


def _medians_around(values: Floats, rings: OneRings, ignored: Bools, wanted: Bools, none: float) -> tuple[Floats, Floats]:
    """(n,) around wanted vertices the median of the values in the two rings that are not ignored, and that of the deviations.

    Both are `none` where there is no such value.
    """
    middles, spreads = np.full(len(values), none), np.full(len(values), none)
    over_range(_find_medians, len(values), values, rings, ignored, wanted, middles, spreads)
    return middles, spreads


@compiled(nogil=True)
def _find_medians(
    values: Floats, rings: OneRings, ignored: Bools, wanted: Bools, middles: Floats, spreads: Floats, first: int, last: int
) -> None:
    seen, around = np.full(values.shape[0], -1, dtype=np.int32), np.empty(MOST, dtype=np.int32)
    for i in range(first, last):
        count = two_rings(rings, i, ignored, seen, around) if wanted[i] else 0
        if count > 0:
            found = values[around[:count]]
            middles[i] = np.median(found)
            spreads[i] = np.median(np.abs(found - middles[i]))


@compiled(nogil=True)
def _measure_gains(
    points: Floats, moved: Floats, faces: Ints, at: VertexFaces, across: Ints, which: Ints, gains: Floats, first: int, last: int
) -> None:
    """By how much moving each of the vertices alone lowers the roughness around it."""
    for i in which[first:last]:
        gains[i] = 0.0
        for f in at.rows[at.offsets[i] : at.offsets[i + 1], 0]:
            for g in across[f]:
                if g >= 0:
                    change = _bend(points, points, faces, i, f, g) - _bend(points, moved, faces, i, f, g)
                    # An edge at the vertex is met from both of its faces.
                    inner = faces[g, 0] == i or faces[g, 1] == i or faces[g, 2] == i
                    gains[i] += 0.5 * change if inner else change


@compiled(nogil=True)
def _bend(points: Floats, places: Floats, faces: Ints, i: int, f: int, g: int) -> float:
    """|n_f - n_g| with vertex i at its place."""
    corners = np.empty((6, 3))
    for corner in range(6):
        j = faces[f, corner] if corner < 3 else faces[g, corner - 3]
        corners[corner] = places[j] if j == i else points[j]
    ax, ay, az = cross_product(corners, 0, 1, 2)
    bx, by, bz = cross_product(corners, 3, 4, 5)
    a, b = math.sqrt(ax * ax + ay * ay + az * az), math.sqrt(bx * bx + by * by + bz * bz)
    a, b = 1.0 / a if a > 0.0 else 0.0, 1.0 / b if b > 0.0 else 0.0
    x, y, z = ax * a - bx * b, ay * a - by * b, az * a - bz * b
    return math.sqrt(x * x + y * y + z * z)

"""Impulse noise taken away: few vertices that are off by far, as those of stray measurements. Filters that keep edges keep them.

`points` are vertices in mean edges, `normals` those of a smoothed copy; what is true or false of vertices is an (n,) array.
"""

import math
from collections.abc import Callable
from typing import Literal, TypeAlias

import numpy as np

from ..checks import check_choice
from ..compilation import compiled
from ..evidence import height_residuals, means_of_others, medians_around, put_where_expected, tuned, with_neighbours
from ..execution import over_range
from ..geometry import cross_product, mean_edge_length
from ..mesh import Bools, Floats, Ints
from ..topology import VertexFaces, edges, faces_across, one_rings, referenced_vertices, vertex_faces
from .noise_level import smooth_normals

#: "keep": vertices that stand out are filtered like the others. "replace": they are put where the others say, and all filtered.
#: "only": the same, and nothing but they moves.
Outliers: TypeAlias = Literal["keep", "replace", "only"]

# Outliers are looked for again up to so many times, or until at most this share of them changes.
_LOOKS, _HARDLY_ANY = 4, 0.02
# Those that stand out most hide others: so many passes, or until at most this share of all vertices is found.
_PASSES, _HARDLY_MORE = 20, 1e-4
_ROUNDING = 1e-6


def without_outliers(
    vertices: Floats,
    faces: Ints,
    outliers: Outliers,
    smooth: Callable[[Floats, Bools | None], Floats],
    *,
    movable: Bools | None = None,
    certain: Bools | None = None,
) -> Floats:
    """Filter a mesh, its outliers no evidence; with `outliers` "keep" `smooth` filters once.

    1. Put the vertices that stand out where a quadric expects them, `replace_outlying`, and filter: z. 2. At edges a quadric
    takes vertices for outliers that are none, and misses others; a filter that keeps edges does not. So those count that are
    `far_from` z, or were outliers before, since a filter that takes details is far from all, and that are `flattening` on z. Put
    them there, also along the surface, `put_back_along`, all others where they were, and filter again, a few times, since
    outliers that were missed mislead the filter. Vertices that are `certain` are outliers in any case: then the mesh is a trial,
    and the others are looked for but once.
    """
    check_choice("outliers", outliers, Outliers)
    if outliers == "keep":
        return smooth(vertices, movable)
    calmed, outlying = replace_outlying(vertices, faces, movable)
    if outlying.any() or outliers == "replace" or certain is not None:
        for _ in range(_LOOKS if certain is None else 1):
            smoothed = smooth(calmed, movable)
            if np.array_equal(smoothed, calmed):
                return calmed  # without a filter there is nothing to find them by again
            before, normals = outlying, smooth_normals(smoothed, faces)
            found = far_from(vertices, faces, smoothed, normals, before)
            if movable is not None:
                found &= movable
            smoothed = put_back_along(smoothed, faces, normals, found)
            outlying = flattening(vertices, smoothed, faces, found | before)
            outlying = outlying if certain is None else outlying | certain
            calmed = np.where(outlying[:, None], smoothed, vertices)
            if np.count_nonzero(outlying != before) <= _HARDLY_ANY * np.count_nonzero(outlying):
                break
    return smooth(calmed, outlying if outliers == "only" else movable)


def far_from(vertices: Floats, faces: Ints, smoothed: Floats, normals: Floats, outlying: Bools) -> Bools:
    """(n,) the vertices that are by far farther from the (n, 3) smoothed ones, along the normals, than those around them.

    The level is three deviations of vertices that are not `outlying`, (n,), at least 0.05 edges. With m the median of the heights
    h in the two rings around, and d that of |h - m|, a vertex is far if |h| is above the level, and |h - m| above it and 4 d: not
    where a filter changes a place as a whole, as by rounding a narrow edge. Then the next ones are looked for, without it.
    """
    heights = np.einsum("ij,ij->i", vertices - smoothed, normals)
    rings, used = one_rings(faces, len(vertices)), referenced_vertices(faces, len(vertices))
    usual = np.abs(heights[used & ~outlying])
    deviation = float(np.median(usual)) / tuned.MEDIAN_OF_NORMAL if len(usual) else 0.0
    level = max(tuned.STANDS_OUT * deviation, tuned.WEAK * mean_edge_length(vertices, faces))
    far = np.zeros(len(vertices), dtype=np.bool_)
    for _ in range(_PASSES):
        found = ~far & (np.abs(heights) > level)
        middles, spreads = medians_around(heights, rings, far, found, 0.0)
        found &= np.abs(heights - middles) > np.maximum(level, tuned.CLIP * spreads)
        far |= found
        if np.count_nonzero(found) <= _HARDLY_MORE * len(heights):
            break
    return used & far


def replace_outlying(vertices: Floats, faces: Ints, movable: Bools | None = None) -> tuple[Floats, Bools]:
    """Put the vertices that stand out where a quadric through those around them expects them; the others keep every bit.

    Returns the (n, 3) vertices, and (n,) which are `outlying_vertices` and, so moved, `flattening`.
    """
    edge = mean_edge_length(vertices, faces)
    used = referenced_vertices(faces, len(vertices))
    if edge == 0.0 or not used.any():
        return vertices.copy(), np.zeros(len(vertices), dtype=np.bool_)
    points = (vertices - vertices[used].mean(axis=0)) / edge
    normals = smooth_normals(vertices, faces)
    outlying = outlying_vertices(points, faces, normals)
    if movable is not None:
        outlying &= movable
    others = put_back_along(points, faces, normals, outlying)
    expected = put_where_expected(others, faces, normals, np.flatnonzero(outlying).astype(np.int32))
    outlying = flattening(points, expected, faces, outlying)
    result = vertices.copy()
    result[outlying] += edge * (expected - points)[outlying]
    return result, outlying


def put_back_along(vertices: Floats, faces: Ints, normals: Floats, outlying: Bools) -> Floats:
    """(n, 3) the vertices, outliers put back along the surface by a share of the way to the mean of their neighbours.

    That is (s^2 - t^2) / s^2, the best of all shares [james1961], for ways s of outliers and t of others in the root mean square.
    """
    others = referenced_vertices(faces, len(vertices)) & ~outlying
    if not others.any() or not outlying.any():
        return vertices.copy()
    rings, every = one_rings(faces, len(vertices)), np.arange(len(vertices), dtype=np.int32)
    border = rings.along_border()
    inside, along = (means_of_others(vertices, near, every, outlying) for near in (rings, border))
    ways = np.where(np.diff(border.offsets)[:, None] > 0, along, inside) - vertices
    ways -= np.einsum("ij,ij->i", ways, normals)[:, None] * normals
    # In mean edges, so that no square is too small or too large for a number.
    lengths = np.linalg.norm(ways / (mean_edge_length(vertices, faces) or 1.0), axis=1)
    of_others, of_outliers = (float(np.mean(lengths[which] ** 2)) for which in (others, outlying))
    # Ways that are hardly longer are by chance.
    share = 1.0 - of_others / of_outliers if tuned.LARGER * of_others < of_outliers else 0.0
    return np.where(outlying[:, None], vertices + share * ways, vertices)


def outlying_vertices(points: Floats, faces: Ints, normals: Floats) -> Bools:
    """(n,) the vertices that stand out, and without which their neighbours are better known.

    The size s of a vertex is that of its `height_residuals`. It stands out if s is the largest of its one-ring, more than three
    times the median of the two rings around, and more than three times the deviation of the mesh, median s / 0.6745. It is an
    outlier if the sum of the s^2 of its neighbours falls without it: the tip of a spike tells nothing of the surface, that of a
    cone does. Then the next ones are looked for, without it. Of Gaussian noise it is about one vertex in a thousand.
    """
    rings, pairs = one_rings(faces, len(points)), edges(faces)
    (first, second), used = pairs.T, referenced_vertices(faces, len(points))
    hidden = np.zeros(len(points), dtype=np.bool_)
    sizes = np.abs(height_residuals(points, rings, normals, hidden))
    for _ in range(_PASSES):
        level = max(tuned.NO_NOISE, tuned.STANDS_OUT / tuned.MEDIAN_OF_NORMAL * float(np.median(sizes[used & ~hidden])))
        largest = used & ~hidden & (sizes > level)
        a, b = pairs[largest[pairs].all(axis=1)].T
        largest[a[sizes[a] < sizes[b]]] = largest[b[sizes[b] < sizes[a]]] = False
        found = largest & (sizes > tuned.STANDS_OUT * medians_around(sizes, rings, hidden | ~used, largest, np.inf)[0])
        without = np.abs(height_residuals(points, rings, normals, hidden | found))
        change = np.where(hidden | found, 0.0, without**2 - sizes**2)
        of_rings = np.bincount(first, change[second], len(points)) + np.bincount(second, change[first], len(points))
        accepted = found & (of_rings < 0.0)
        hidden |= accepted
        if np.count_nonzero(accepted) <= _HARDLY_MORE * len(points):
            break
        sizes = without if np.array_equal(accepted, found) else np.abs(height_residuals(points, rings, normals, hidden))
    return hidden


def sizes_beside(points: Floats, faces: Ints, normals: Floats, outlying: Bools, scored: Bools) -> tuple[float, float]:
    """The median sizes of `height_residuals` beside an outlier and elsewhere: alike with spikes, not where noise is uneven."""
    sizes = np.abs(height_residuals(points, one_rings(faces, len(points)), normals, outlying))
    beside, counted = with_neighbours(outlying, edges(faces)), scored & ~outlying
    near, far = (float(np.median(sizes[which])) if which.any() else 0.0 for which in (counted & beside, counted & ~beside))
    return near, far


def flattening(points: Floats, moved: Floats, faces: Ints, which: Bools) -> Bools:
    """(n,) those of some vertices whose moves to the (n, 3) places `moved` make the surface flatter, each by itself.

    The roughness around a vertex is the sum of |n_f - n_g| over the edges of its faces, f and g the faces at an edge. Taking a
    spike away lowers it, rounding or denting an edge does not. Of adjacent vertices the one that lowers it most moves, then all
    are looked at again, those that have moved whether they had better go back.
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


@compiled(nogil=True)
def _measure_gains(
    points: Floats, moved: Floats, faces: Ints, at: VertexFaces, across: Ints, which: Ints, gains: Floats, first: int, last: int
) -> None:
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

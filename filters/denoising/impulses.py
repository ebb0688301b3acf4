"""Removes impulse noise, a few vertices far off the surface, as from stray measurements; edge-preserving filters keep them.

`points` are in mean edges (in `flattening` any unit), `normals` the vertex normals of a smoothed copy; vertex masks are (n,).
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

#: "keep" filters outliers like other vertices. "replace" first moves outliers to their predicted positions, then filters all
#: vertices. "only" replaces and then filters the outliers; all other vertices stay.
Outliers: TypeAlias = Literal["keep", "replace", "only"]

# The search for outliers repeats until at most `_STEADY_SHARE` of them change between searches, at most `_SEARCHES` times.
_SEARCHES, _STEADY_SHARE = 4, 0.02
# Large outliers hide smaller ones: a search has up to `_PASSES` passes, until a pass finds at most `_LAST_SHARE` of all vertices.
_PASSES, _LAST_SHARE = 20, 1e-4
_ROUNDING = 1e-6  # smaller changes of roughness are rounding errors


def without_outliers(
    vertices: Floats,
    faces: Ints,
    outliers: Outliers,
    smooth: Callable[[Floats, Bools | None], Floats],
    *,
    movable: Bools | None = None,
    certain: Bools | None = None,
) -> Floats:
    """Returns (n, 3) vertices filtered by `smooth` without the influence of outliers; "keep" just filters once.

    1. `replace_outlying` moves outliers to predicted positions, and the filter gives positions z. At edges the prediction
    errs, an edge-preserving filter does not. 2. So the vertices `far_from` z become candidates. Earlier outliers stay candidates,
    since `far_from` misses some where the filter removes details. 3. `put_back_along` corrects z at the far vertices. Candidates
    that `flattening` accepts are outliers and move to z. 4. All other vertices return to the input, and the filter runs again.
    Missed outliers mislead the filter, so steps 2 to 4 repeat; with held-out vertices as `certain` outliers, they run once.
    """
    check_choice("outliers", outliers, Outliers)
    if outliers == "keep":
        return smooth(vertices, movable)
    calmed, outlying = replace_outlying(vertices, faces, movable)
    if outlying.any() or outliers == "replace" or certain is not None:
        for _ in range(_SEARCHES if certain is None else 1):
            smoothed = smooth(calmed, movable)
            if np.array_equal(smoothed, calmed):
                return calmed  # a filter without effect gives no reference for another search
            before, normals = outlying, smooth_normals(smoothed, faces)
            far = far_from(vertices, faces, smoothed, normals, before)
            if movable is not None:
                far &= movable
            smoothed = put_back_along(smoothed, faces, normals, far)
            outlying = flattening(vertices, smoothed, faces, far | before)
            outlying = outlying if certain is None else outlying | certain
            calmed = np.where(outlying[:, None], smoothed, vertices)
            if np.count_nonzero(outlying != before) <= _STEADY_SHARE * np.count_nonzero(outlying):
                break
    return smooth(calmed, outlying if outliers == "only" else movable)


def far_from(vertices: Floats, faces: Ints, smoothed: Floats, normals: Floats, outlying: Bools) -> Bools:
    """Returns (n,) which vertices are much farther from the `smoothed` vertices, along the normals, than vertices nearby.

    h is the height above the smoothed vertex, m its median in two rings, d the median of |h - m|. The level is three standard
    deviations of h over vertices not `outlying`, at least 0.05 mean edges. A vertex is far if |h| and |h - m| exceed the level
    and |h - m| exceeds 4 d: vertices that move together, as at rounded edges, are not far. The test repeats without far vertices.
    """
    heights = np.einsum("ij,ij->i", vertices - smoothed, normals)
    rings, used = one_rings(faces, len(vertices)), referenced_vertices(faces, len(vertices))
    usual = np.abs(heights[used & ~outlying])
    deviation = float(np.median(usual)) / tuned.MEDIAN_OF_NORMAL if len(usual) else 0.0
    level = max(tuned.STANDS_OUT * deviation, tuned.WEAK * mean_edge_length(vertices, faces))
    far = np.zeros(len(vertices), dtype=np.bool_)
    for _ in range(_PASSES):
        candidates = ~far & (np.abs(heights) > level)
        middles, spreads = medians_around(heights, rings, far, candidates, 0.0)
        candidates &= np.abs(heights - middles) > np.maximum(level, tuned.CLIP * spreads)
        far |= candidates
        if np.count_nonzero(candidates) <= _LAST_SHARE * len(heights):
            break
    return used & far


def replace_outlying(vertices: Floats, faces: Ints, movable: Bools | None = None) -> tuple[Floats, Bools]:
    """Returns (n, 3) the vertices with outliers moved to their predicted positions, and (n,) which are outliers.

    Outliers are the `outlying_vertices` that `flattening` accepts. The prediction is a quadric fitted to the vertices around.
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
    """Returns (n, 3) the vertices, with outliers moved along the surface by a share of the offset to their neighbours' mean.

    The share (s^2 - t^2) / s^2 has the least error [james1961]: s is the root mean square offset of outliers, t that of others.
    """
    others = referenced_vertices(faces, len(vertices)) & ~outlying
    if not others.any() or not outlying.any():
        return vertices.copy()
    rings, indices = one_rings(faces, len(vertices)), np.arange(len(vertices), dtype=np.int32)
    border = rings.along_border()
    inside, along = (means_of_others(vertices, near, indices, outlying) for near in (rings, border))
    offsets = np.where(np.diff(border.offsets)[:, None] > 0, along, inside) - vertices
    offsets -= np.einsum("ij,ij->i", offsets, normals)[:, None] * normals
    # In mean edges, so that squares neither underflow nor overflow.
    lengths = np.linalg.norm(offsets / (mean_edge_length(vertices, faces) or 1.0), axis=1)
    of_others, of_outliers = (float(np.mean(lengths[which] ** 2)) for which in (others, outlying))
    # Slightly longer offsets of outliers may be chance.
    share = 1.0 - of_others / of_outliers if tuned.LARGER * of_others < of_outliers else 0.0
    return np.where(outlying[:, None], vertices + share * offsets, vertices)


def outlying_vertices(points: Floats, faces: Ints, normals: Floats) -> Bools:
    """Returns (n,) which vertices have a large residual and make the prediction of their neighbours worse.

    Let s be the absolute `height_residuals`. A vertex is a candidate if its s is the largest in its one-ring, above 0.01, above 3
    times the median of s in two rings, and above 3 times the standard deviation median(s) / 0.6745 of the mesh. A candidate is an
    outlier if the sum of s^2 over its neighbours falls when predictions ignore candidates: the tip of a spike is an outlier, the
    tip of a cone is not. The search repeats without the outliers. In Gaussian noise it finds 0.2 to 0.3 % of vertices.
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
        large = largest & (sizes > tuned.STANDS_OUT * medians_around(sizes, rings, hidden | ~used, largest, np.inf)[0])
        without = np.abs(height_residuals(points, rings, normals, hidden | large))
        change = np.where(hidden | large, 0.0, without**2 - sizes**2)
        of_rings = np.bincount(first, change[second], len(points)) + np.bincount(second, change[first], len(points))
        accepted = large & (of_rings < 0.0)
        hidden |= accepted
        if np.count_nonzero(accepted) <= _LAST_SHARE * len(points):
            break
        sizes = without if np.array_equal(accepted, large) else np.abs(height_residuals(points, rings, normals, hidden))
    return hidden


def sizes_beside(points: Floats, faces: Ints, normals: Floats, outlying: Bools, scored: Bools) -> tuple[float, float]:
    """Returns the median absolute `height_residuals` of `scored` vertices beside outliers, and of those elsewhere; 0 for none."""
    sizes = np.abs(height_residuals(points, one_rings(faces, len(points)), normals, outlying))
    beside, counted = with_neighbours(outlying, edges(faces)), scored & ~outlying
    near, far = (float(np.median(sizes[which])) if which.any() else 0.0 for which in (counted & beside, counted & ~beside))
    return near, far


def flattening(points: Floats, moved: Floats, faces: Ints, which: Bools) -> Bools:
    """Returns (n,) which vertices of the mask `which` make the surface flatter if they move to their (n, 3) `moved` positions.

    The roughness around a vertex is the sum of |n_f - n_g| over the edges of its faces, where f and g share the edge. Removing a
    spike lowers the roughness, rounding or denting an edge does not. Of adjacent vertices, only the one with the largest decrease
    moves. The test is then repeated; moved vertices may move back.
    """
    is_moved = np.zeros(len(points), dtype=np.bool_)
    candidates = np.flatnonzero(which).astype(np.int32)
    if not len(candidates):
        return is_moved
    at_vertices, across = vertex_faces(faces, len(points)), faces_across(faces)
    a, b = edges(faces).T
    now, gains = points.copy(), np.zeros(len(points))
    for _ in range(_PASSES):
        other = np.where(is_moved[:, None], points, moved)
        over_range(_measure_gains, len(candidates), now, other, faces, at_vertices, across, candidates, gains)
        best = gains.copy()
        np.maximum.at(best, a, gains[b])
        np.maximum.at(best, b, gains[a])
        turned = (gains > _ROUNDING) & (gains == best)
        if not turned.any():
            break
        now[turned] = other[turned]
        is_moved ^= turned
    return is_moved


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
                    # An edge at the vertex is counted from both of its faces.
                    inner = faces[g, 0] == i or faces[g, 1] == i or faces[g, 2] == i
                    gains[i] += 0.5 * change if inner else change


@compiled(nogil=True)
def _bend(points: Floats, places: Floats, faces: Ints, i: int, f: int, g: int) -> float:
    """|n_f - n_g| of the unit normals of faces f and g, with vertex i at `places[i]`."""
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

"""Impulse noise taken away: few vertices that are off by far, as those of stray measurements.

Everywhere here `vertices` are (n, 3) coordinates, `faces` (m, 3) triangles, `normals` (n, 3) unit normals of a smoothed copy, and
`movable` says of (n,) vertices which may move, None for all.
"""

from collections.abc import Callable
from typing import Literal, TypeAlias, get_args

import numpy as np

from ..checks import check_choice
from ..evidence import flattening, means_of_others, outlying_vertices, put_where_expected, standing_out, tuned
from ..geometry import mean_edge_length
from ..mesh import Bools, Floats, Ints
from ..topology import one_rings, referenced_vertices
from .noise_level import smooth_normals

#: "keep": vertices that stand out are filtered like the others. "replace": they are put where the others say, and all are
#: filtered. "only": the same, and nothing but they moves.
Outliers: TypeAlias = Literal["keep", "replace", "only"]
OUTLIERS: tuple[Outliers, ...] = get_args(Outliers)

# Outliers are looked for again up to so many times, or until not more than this share of them changes.
_LOOKS, _HARDLY_ANY = 4, 0.02


def without_outliers(
    vertices: Floats,
    faces: Ints,
    outliers: Outliers,
    smooth: Callable[[Floats, Bools | None], Floats],
    *,
    movable: Bools | None = None,
    certain: Bools | None = None,
) -> Floats:
    """Filter a mesh, its outliers no evidence.

    1. Put the vertices that stand out where a quadric expects them, `replace_outlying`, and filter: z.
    2. At edges a quadric takes vertices for outliers that are none, and misses others; a filter that keeps edges does not. So
       find them again: they are farther from z, along the normals, than three deviations of the others and than those around
       them, `far_from`, or were outliers before, since a filter that takes details is far from all vertices; and putting them on
       z makes the surface flatter, `flattening`. Put them on z, all others where they were, and filter once more; and again, a
       few times, since outliers that were missed mislead the filter: what one in two is hides most of them at first.

    Outliers may be off along the surface too: they are put back along it as well, see `put_back_along`.

    With `outliers` "keep" `smooth` filters once, and both steps are left out. The `certain` (n,) vertices are outliers whatever
    they look like; with them the mesh is a trial, and the others are looked for but once.

    Raises:
        FilterInputError: a parameter out of range.
    """
    check_choice("outliers", outliers, OUTLIERS)
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
    """(n,) the vertices that are farther from the (n, 3) smoothed ones, along the normals, than three deviations.

    And than those around them, see `standing_out`: where a filter rounds an edge all of them are far. The deviation is that of
    vertices that are not `outlying`, (n,).
    """
    away = np.einsum("ij,ij->i", vertices - smoothed, normals)
    used = referenced_vertices(faces, len(vertices))
    usual = used & ~outlying
    deviation = float(np.median(np.abs(away[usual]))) / tuned.MEDIAN_OF_NORMAL if usual.any() else 0.0
    return used & standing_out(away, faces, max(tuned.STANDS_OUT * deviation, tuned.WEAK * mean_edge_length(vertices, faces)))


def replace_outlying(vertices: Floats, faces: Ints, movable: Bools | None = None) -> tuple[Floats, Bools]:
    """Put the vertices that stand out where a quadric through those around them expects them.

    Returns:
        vertices: (n, 3); those that do not stand out keep every bit.
        outlying: (n,) which do, see `outlying_vertices`, and make the surface flatter there, see `flattening`.
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
    """(n, 3) the vertices, (n,) outliers put back along the surface by a share of the way to the mean of those around.

    Vertices that did not slide are off the mean of their neighbours too, by t in the root mean square. If outliers are off by s,
    (s^2 - t^2) / s^2 of their ways is expected to be slid, which has the least expected square of all shares [james1961].
    On a border the neighbours are those next to it there.
    """
    others = referenced_vertices(faces, len(vertices)) & ~outlying
    if not others.any() or not outlying.any():
        return vertices.copy()
    rings = one_rings(faces, len(vertices))
    along_border = rings.along_border()
    on_border = np.flatnonzero(np.diff(along_border.offsets)).astype(np.int32)
    means = means_of_others(vertices, rings, np.arange(len(vertices), dtype=np.int32), outlying)
    means[on_border] = means_of_others(vertices, along_border, on_border, outlying)
    ways = means - vertices
    ways -= np.einsum("ij,ij->i", ways, normals)[:, None] * normals
    # In mean edges, so that no square is too small or too large for a number.
    lengths = np.linalg.norm(ways / (mean_edge_length(vertices, faces) or 1.0), axis=1)
    of_others, of_outliers = (float(np.mean(lengths[which] ** 2)) for which in (others, outlying))
    # Ways that are hardly longer are by chance.
    share = 1.0 - of_others / of_outliers if tuned.LARGER * of_others < of_outliers else 0.0
    return np.where(outlying[:, None], vertices + share * ways, vertices)

"""Impulses taken away: few vertices that are off by far, as those of stray measurements."""

from collections.abc import Callable
from typing import Literal, TypeAlias, get_args

import numpy as np

from ..checks import check_choice
from ..evidence import flattening, outlying_vertices, put_where_expected, standing_out
from ..geometry import mean_edge_length
from ..mesh import Bools, Floats, Ints
from ..topology import referenced_vertices
from .noise_level import smooth_normals
from .tangential_shift import TangentialShift

#: "keep": vertices that stand out are filtered like the others. "replace": they are put where the others say, and all are
#: filtered. "only": the same, and nothing but they moves.
Outliers: TypeAlias = Literal["keep", "replace", "only"]
OUTLIERS: tuple[Outliers, ...] = get_args(Outliers)

# Outliers are looked for again up to so many times, or until not more than this share of them changes.
_LOOKS, _HARDLY_ANY = 4, 0.02
# A filter's outliers are those that it moves by more than three deviations, the median of all ways over 0.6745, and by more than
# a twentieth of an edge: clean surfaces have as much.
_FAR, _MEDIAN_OF_NORMAL, _LEAST = 3.0, 0.6745, 0.05


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
       them, `far_from`, or were known before, since a filter that takes details is far from all vertices; and putting them on z
       makes the surface flatter, `flattening`. Put them on z, all others where they were, and filter once more; and again, a few
       times, since outliers that were missed mislead the filter: what one in two is hides most of them at first.

    Outliers may be off along the surface too: they are put back along it as well, by what `TangentialShift` expects; where they
    are off by far, vertices that fold faces over are outliers.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        outliers: "keep" filters once, and leaves out both steps.
        smooth: (n, 3) coordinates and which vertices may move, (n,) or None for all, to the filtered (n, 3).
        movable: (n,) which vertices may move, None for all.
        certain: (n,) vertices that are outliers whatever they look like, None for none; where they are given the mesh is tried,
            and the others are looked for but once.

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
            before = outlying
            smoothed, outlying = _found_again(vertices, faces, smoothed, before, movable)
            outlying = outlying if certain is None else outlying | certain
            calmed = np.where(outlying[:, None], smoothed, vertices)
            if np.count_nonzero(outlying != before) <= _HARDLY_ANY * np.count_nonzero(outlying):
                break
    return smooth(calmed, outlying if outliers == "only" else movable)


def _found_again(vertices: Floats, faces: Ints, smoothed: Floats, outlying: Bools, movable: Bools | None) -> tuple[Floats, Bools]:
    """Where outliers are to be put by a filtered mesh, and which they are, by it and by those known before."""
    ways = TangentialShift.of(vertices, faces, smooth_normals(smoothed, faces), outlying)
    found = far_from(vertices, faces, smoothed, movable, outlying, normals=ways.normals)
    if ways.outliers_fold:
        found |= ways.folding(movable)
    smoothed = TangentialShift.of(smoothed, faces, ways.normals, found).evened()
    return smoothed, flattening(vertices, smoothed, faces, found | outlying)


def far_from(
    vertices: Floats,
    faces: Ints,
    smoothed: Floats,
    movable: Bools | None = None,
    outlying: Bools | None = None,
    *,
    normals: Floats | None = None,
) -> Bools:
    """(n,) the vertices that are farther from the (n, 3) smoothed ones, along the normals, than three deviations.

    And than those around them, see `standing_out`: where a filter rounds an edge all of them are far.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        smoothed: (n, 3) what a filter made of them.
        movable: (n,) which vertices may move, None for all; the others are not among them.
        outlying: (n,) outliers that are known, None for none: the deviation is that of the others.
        normals: (n, 3) `smooth_normals` of the smoothed vertices, None to find them.
    """
    away = np.einsum("ij,ij->i", vertices - smoothed, smooth_normals(smoothed, faces) if normals is None else normals)
    used = referenced_vertices(faces, len(vertices))
    usual = used if outlying is None else used & ~outlying
    deviation = float(np.median(np.abs(away[usual]))) / _MEDIAN_OF_NORMAL if usual.any() else 0.0
    far = used & standing_out(away, faces, max(_FAR * deviation, _LEAST * mean_edge_length(vertices, faces)))
    return np.asarray(far if movable is None else far & movable)


def replace_outlying(vertices: Floats, faces: Ints, movable: Bools | None = None) -> tuple[Floats, Bools]:
    """Put the vertices that stand out where a quadric through those around them expects them.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        movable: (n,) which vertices may move, None for all.

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
    others = points
    ways = TangentialShift.of(points, faces, normals, outlying)
    # Where a smoothed copy is still bent by spikes, their heights look like ways along the surface.
    if ways.outliers_fold:
        outlying |= ways.folding(movable)
        others = TangentialShift.of(points, faces, normals, outlying).evened()
    expected = put_where_expected(others, faces, normals, np.flatnonzero(outlying).astype(np.int32))
    outlying = flattening(points, expected, faces, outlying)
    result = vertices.copy()
    result[outlying] += edge * (expected - points)[outlying]
    return result, outlying

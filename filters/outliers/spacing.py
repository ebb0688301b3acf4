"""Finds surface without data in a reconstruction, by the spacing of the cloud, and surplus points, by the cells of a grid."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_positive
from ..libraries import spatial
from ..mesh import Bools, Floats, bounding_box, check_mesh, check_points, unit_scale
from ..neighbours import nearest_neighbours

#: The spacing at a point is the mean distance to this many neighbours.
_NEIGHBOURS = 6
#: A place is sparse if the median spacing at the nearest `_AROUND` points is over 1 / `_SHARE` times the spacing of the cloud.
#: Borders and clouds of random points hardly ever have such a median.
_AROUND, _SHARE = 20, 2.0 / 3.0
#: descriptions of the points that a filter has found, by the name of a parameter that only this filter has
_KINDS = {
    "threshold": "outliers with a probability above {:g}",
    "smallest_part": "part of no surface: alone, in a haze, or in small clumps",
    "side": "not the first in their cell of {:g}",
}
# All whole numbers up to this one are exact in float64.
_LARGEST = 2.0**53


def gaps(vertices: ArrayLike, points: ArrayLike, at_points: Floats | None = None) -> Floats:
    """Returns (n,) the distance of each vertex from the nearest point, in units of `cloud_spacings` at this point.

    Screened Poisson also closes gaps of the cloud. Without vertices far from the points its surface ends where the cloud ends.

    Args:
        vertices: (n, 3) finite coordinates.
        points: (p, 3) the points of the cloud, at least 7.
        at_points: (p,) the spacings of `cloud_spacings`, if the caller has them.

    Raises:
        FilterInputError: too few points, most of them coincide with six others each, or coordinates are not finite.
    """
    queries, _ = check_mesh(vertices, ())
    cloud, _ = check_mesh(points, ())
    if at_points is None:
        at_points = cloud_spacings(cloud)
    # Scaled by a power of two, which changes no digit, so that squared distances neither overflow nor vanish.
    scale = unit_scale(*bounding_box(np.concatenate([cloud, queries])))
    middle = (cloud * scale).mean(axis=0)
    nearest, numbers = spatial.cKDTree(cloud * scale - middle).query(queries * scale - middle)
    return np.asarray(nearest / (at_points[numbers] * scale))


def cloud_spacings(points: Floats) -> Floats:
    """Returns (p,) for each of (p, 3) points the median spacing of the cloud or, if larger, 2/3 of the median spacing nearby.

    Raises:
        FilterInputError: too few points, or most of them coincide with six others each.
    """
    distances, around = nearest_neighbours(points, max(_NEIGHBOURS, min(_AROUND, len(points) - 1)))
    spacings = distances[:, :_NEIGHBOURS].mean(axis=1)
    spacing = float(np.median(spacings))
    if spacing == 0.0:
        raise FilterInputError("most points of the cloud coincide, so that it has no spacing: remove duplicates first")
    return np.asarray(np.maximum(spacing, _SHARE * np.median(spacings[around], axis=1)))


def grid_cells(points: Floats, side: float) -> Floats:
    """Returns (n, 3) whole numbers: the cell of each point in a grid of cubes of this side with a corner at the origin.

    Raises:
        FilterInputError: the side is not above 0, or too small for exact cell numbers so far from the origin.
    """
    if side == 0.0:
        raise FilterInputError("side is 0: nothing to do; give the side of a cell, such as '0.1' in mesh units")
    cells = np.floor(points / check_positive("side", side))
    if len(cells) and not np.abs(cells).max() < _LARGEST:
        raise FilterInputError(f"cells of {side:g} are too small for coordinates up to {np.abs(points).max():g}")
    return np.asarray(cells)


def surplus_points(points: ArrayLike, side: float) -> Bools:
    """Returns (n,) which points share a cell of `grid_cells` with an earlier point; larger cells keep fewer points.

    Raises:
        FilterInputError: a side that is not above 0 or too small, coordinates that are not finite.
    """
    cells = grid_cells(check_points(points), side)
    order = np.lexsort(cells.T)
    surplus = np.zeros(len(cells), np.bool_)
    surplus[order[1:]] = (cells[order[1:]] == cells[order[:-1]]).all(axis=1)
    return surplus


def found_words(count: int, total: int, values: Mapping[str, Any], copies: int = 0) -> tuple[str, ...]:
    """What a filter with the parameters `values` has found: `count` of `total` points, `copies` of them copies of others."""
    advice = f"{copies:,} of them are copies of others, and copies count as neighbours: remove duplicate vertices first"
    found = (f"{count:,} of {total:,} points are {_KINDS[n].format(values[n])}" for n in _KINDS if n in values and count)
    return (*found, *([advice] if copies else []))

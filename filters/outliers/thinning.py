"""Thinning of clouds: one point is enough in each cell of a grid."""

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_positive
from ..mesh import Bools, Floats, check_points

# Whole numbers up to this are exact.
_LARGEST = 2.0**53


def grid_cells(points: Floats, side: float) -> Floats:
    """(n, 3) whole numbers: the cell of each point in the grid of cubes of that side which has a corner at the origin.

    Raises:
        FilterInputError: the side is too small to tell cells apart so far from the origin.
    """
    cells = np.floor(points / side)
    if len(cells) and not np.abs(cells).max() < _LARGEST:
        raise FilterInputError(f"cells of {side:g} are too small for coordinates up to {np.abs(points).max():g}")
    return np.asarray(cells)


def surplus_points(points: ArrayLike, side: float) -> Bools:
    """(n,) the points in whose cell of `grid_cells` another one comes before.

    Args:
        points: (n, 3) coordinates.
        side: of a cell, in mesh units. Larger leaves fewer points.

    Raises:
        FilterInputError: a side that is not above 0 or too small, coordinates that are not finite.
    """
    cells = grid_cells(check_points(points), check_positive("side", side))
    order = np.lexsort(cells.T)
    surplus = np.zeros(len(cells), np.bool_)
    surplus[order[1:]] = (cells[order[1:]] == cells[order[:-1]]).all(axis=1)
    return surplus

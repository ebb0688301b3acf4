"""Vertices of a reconstruction far from all points of its cloud: surface without data."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_finite
from ..libraries import spatial
from ..mesh import Bools, check_mesh
from ..neighbours import nearest_neighbours

#: as many neighbours say how dense the cloud is
_NEIGHBOURS = 6


def far_from_points(vertices: ArrayLike, points: ArrayLike, *, spacings: float = 4.0) -> Bools:
    """Which vertices lie farther from the nearest point than `spacings` times the spacing of the cloud.

    The spacing is the median over the points of the mean distance to their six nearest neighbours. Screened Poisson closes every
    surface by a balloon; cut where no point is near, the surface ends where the cloud does.

    Args:
        vertices: (n, 3) finite coordinates.
        points: (p, 3) those of the cloud, at least 7.
        spacings: larger keeps more: bridges over gaps that are up to twice as wide, and a wider rim.

    Returns:
        (n,) bool.

    Raises:
        FilterInputError: too few points, coordinates that are not finite, a number that is not above 0.
    """
    reach = check_finite("spacings", spacings, least=0.0)
    queries, _ = check_mesh(vertices, ())
    cloud, _ = check_mesh(points, ())
    distances, _ = nearest_neighbours(cloud, _NEIGHBOURS)
    spacing = float(np.median(distances.mean(axis=1)))
    middle = cloud.mean(axis=0)
    gaps, _ = spatial.cKDTree(cloud - middle).query(queries - middle)
    return np.asarray(gaps > reach * spacing)

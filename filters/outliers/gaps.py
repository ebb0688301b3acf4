"""How far the vertices of a reconstruction lie from all points of its cloud: surface without data."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..libraries import spatial
from ..mesh import Floats, check_mesh
from ..neighbours import nearest_neighbours

#: as many neighbours say how dense the cloud is
_NEIGHBOURS = 6


def gaps(vertices: ArrayLike, points: ArrayLike) -> Floats:
    """The distance of each vertex from the nearest point, in spacings of the cloud.

    The spacing is the median over the points of the mean distance to their six nearest neighbours. Screened Poisson closes every
    surface by a balloon; cut where no point is near, the surface ends where the cloud does.

    Args:
        vertices: (n, 3) finite coordinates.
        points: (p, 3) those of the cloud, at least 7.

    Returns:
        (n,) float64.

    Raises:
        FilterInputError: too few points, coordinates that are not finite.
    """
    queries, _ = check_mesh(vertices, ())
    cloud, _ = check_mesh(points, ())
    distances, _ = nearest_neighbours(cloud, _NEIGHBOURS)
    middle = cloud.mean(axis=0)
    nearest, _ = spatial.cKDTree(cloud - middle).query(queries - middle)
    spacing = float(np.median(distances.mean(axis=1)))
    if spacing == 0.0:
        raise FilterInputError("half of the points of the cloud coincide, so that it has no spacing: remove duplicates first")
    return np.asarray(nearest / spacing)

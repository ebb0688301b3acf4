"""The distance of the vertices of a reconstruction from the points of its cloud: surface without data."""

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..libraries import spatial
from ..mesh import Floats, check_mesh
from ..neighbours import nearest_neighbours

#: The spacing at a point is the mean distance to this many neighbours.
_NEIGHBOURS = 6
#: The spacing around a point is this share of the median over so many points: at borders, where neighbours lie on one side, and
#: where points are strewn at random, spacings are up to half as large again.
_AROUND, _SHARE = 20, 2.0 / 3.0


def gaps(vertices: ArrayLike, points: ArrayLike, at_points: Floats | None = None) -> Floats:
    """The distance of each vertex from the nearest point, in spacings of the cloud.

    The spacing at a point is the mean distance to its six nearest neighbours, that of the cloud the median over its points. A
    vertex is measured in that of the cloud, or, where the cloud is sparse, as the far ground of a terrestrial scan is, in two
    thirds of the median spacing of the twenty points at the nearest one. Screened Poisson closes every surface by a balloon; cut
    where no point is near, the surface ends where the cloud does.

    Args:
        vertices: (n, 3) finite coordinates.
        points: (p, 3) those of the cloud, at least 7.
        at_points: (p,) the spacings at the points, those of `cloud_spacings`, if the caller has them.

    Returns:
        (n,) float64.

    Raises:
        FilterInputError: too few points, coordinates that are not finite.
    """
    queries, _ = check_mesh(vertices, ())
    cloud, _ = check_mesh(points, ())
    if at_points is None:
        at_points = cloud_spacings(cloud)
    middle = cloud.mean(axis=0)
    nearest, numbers = spatial.cKDTree(cloud - middle).query(queries - middle)
    return np.asarray(nearest / at_points[numbers])


def cloud_spacings(points: Floats) -> Floats:
    """(p,) the spacing in which `gaps` measures near each of (p, 3) points.

    Raises:
        FilterInputError: too few points, or half of them coincide.
    """
    distances, around = nearest_neighbours(points, max(_NEIGHBOURS, min(_AROUND, len(points) - 1)))
    own = distances[:, :_NEIGHBOURS].mean(axis=1)
    spacing = float(np.median(own))
    if spacing == 0.0:
        raise FilterInputError("half of the points of the cloud coincide, so that it has no spacing: remove duplicates first")
    return np.asarray(np.maximum(spacing, _SHARE * np.median(own[around], axis=1)))

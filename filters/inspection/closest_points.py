"""The nearest place on a surface, or in a cloud, to each of many points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..libraries import igl, spatial
from ..mesh import Floats, Ints, Longs


class ClosestPoints(NamedTuple):
    """The places nearest to q points.

    Attributes:
        places: (q, 3) where they are.
        distances: (q,) how far they are.
        elements: (q,) the face each lies on; in a cloud the point that it is.
    """

    places: Floats
    distances: Floats
    elements: Longs


def closest_points(queries: Floats, points: Floats, faces: Ints) -> ClosestPoints:
    """The places of a mesh, or if there are no faces of a cloud, nearest to the queries; exact.

    Args:
        queries: (q, 3) coordinates.
        points: (n, 3) coordinates, n at least 1, in the same frame, which should be near the origin: the squares of the distances
            lose the digits that large coordinates need.
        faces: (m, 3) triangles.
    """
    if len(queries) == 0:
        return ClosestPoints(np.empty((0, 3)), np.empty(0), np.empty(0, dtype=np.int64))
    if len(faces) == 0:
        distances, nearest = spatial.cKDTree(points).query(queries)
        return ClosestPoints(points[nearest], distances, nearest)
    _, elements, places = igl.point_mesh_squared_distance(
        np.ascontiguousarray(queries), np.ascontiguousarray(points), faces.astype(np.int64)
    )
    # From the places, as the squares have half of the digits only.
    return ClosestPoints(places, np.linalg.norm(queries - places, axis=1), elements)

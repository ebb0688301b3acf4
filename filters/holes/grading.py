"""Larger triangles in the middle of a very large hole, so that memory and time stay bounded."""

from __future__ import annotations

import numpy as np

from ..geometry import cross_products
from ..libraries import spatial
from ..mesh import Floats, Ints

#: A hole gets triangles as small as those at its rim all over if these are about so many vertices at most.
MOST_VERTICES = 60_000
#: Otherwise edges are as short as there within some distance of the rim, and beyond it grow by this much of what is further away.
SLOPE = 0.4
#: That distance is at least so many edges.
_LEAST_WIDTH = 1.0


def uniform_width(points: Floats, sizes: Floats, triangles: Ints, n_rim: int) -> float:
    """How far from its rim a patch is to be as dense as there, in edges; infinite if it can be so all over.

    A surface of equilateral triangles with sides h has one vertex for every h^2 sqrt(3) / 2. A band of k edges and the width of
    u edges has k u 2 / sqrt(3) vertices, and what is inside it, where edges grow by g of the distance, k / g 2 / sqrt(3) at most.
    So u is the width for which both together are `MOST_VERTICES`, but `_LEAST_WIDTH` at least.

    Args:
        points: (k, 3) the rim.
        sizes: (k,) the lengths of the edges there.
        triangles: (k - 2, 3) a triangulation of the rim, for its area.
        n_rim: k.
    """
    each = np.sqrt(3.0) / 2.0
    areas = np.linalg.norm(cross_products(points, triangles), axis=1) / 2.0
    wanted = float((areas / (each * sizes[triangles].mean(axis=1) ** 2)).sum())
    if wanted <= MOST_VERTICES:
        return np.inf
    return max(_LEAST_WIDTH, float(MOST_VERTICES * each / n_rim - 1.0 / SLOPE))


class Growth:
    """How many times as long edges are to be at a place as at the rim."""

    def __init__(self, rim: Floats, uniform: float) -> None:
        """For a rim of (k, 3) points, and a band of this width in edges where they do not grow."""
        self._tree = spatial.cKDTree(rim) if np.isfinite(uniform) else None
        self._uniform = uniform

    def at(self, points: Floats, sizes: Floats) -> Floats:
        """(n,) the factors 1 + SLOPE (distance / size - width), at least 1, for the sizes that edges would have without them."""
        if self._tree is None or len(points) == 0:
            return np.ones(len(points))
        distance, _ = self._tree.query(points)
        factors: Floats = np.maximum(1.0, 1.0 + SLOPE * (distance / sizes - self._uniform))
        return factors

"""Angles, areas and quality of single triangles, for kernels."""

import numpy as np

from ..compilation import compiled
from ..mesh import Floats


@compiled
def cross_product(points: Floats, a: int, b: int, c: int) -> tuple[float, float, float]:
    """(b - a) x (c - a): normal to the triangle (a, b, c), counter-clockwise seen from its tip, and twice its area long."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@compiled
def squared_length(points: Floats, a: int, b: int) -> float:
    """The square of the distance between two points."""
    x, y, z = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    return float(x * x + y * y + z * z)


@compiled
def angle_at(points: Floats, a: int, b: int, c: int) -> float:
    """The angle at a between b and c, from 0 to pi; 0 if two of them coincide."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    nx, ny, nz = cross_product(points, a, b, c)
    angle: float = np.arctan2(np.sqrt(nx * nx + ny * ny + nz * nz), ux * vx + uy * vy + uz * vz)
    return angle


@compiled
def quality_and_normal(points: Floats, a: int, b: int, c: int) -> tuple[float, float, float, float]:
    """The quality l / (sqrt(3) R) and the unit normal of the triangle (a, b, c); zeros if it has no area.

    Here l is the shortest edge and R the circumradius: 1 for equilateral triangles, towards 0 for slivers.
    """
    nx, ny, nz = cross_product(points, a, b, c)
    doubled = np.sqrt(nx * nx + ny * ny + nz * nz)
    if not doubled > 0.0:
        return 0.0, 0.0, 0.0, 0.0
    first, second = np.sqrt(squared_length(points, a, b)), np.sqrt(squared_length(points, a, c))
    third = np.sqrt(squared_length(points, b, c))
    # R is the product of the edges over four areas.
    quality = 2.0 * doubled * min(first, second, third) / (np.sqrt(3.0) * first * second * third)
    return quality, nx / doubled, ny / doubled, nz / doubled

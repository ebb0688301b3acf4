"""The area that belongs to each vertex."""

import math

import numpy as np

from ..compilation import compiled, prange
from ..execution import threads_for
from ..mesh import Floats, Ints, Longs, scaled_to_unit
from ..topology import ring_ends


def mixed_voronoi_areas(vertices: Floats, faces: Ints) -> Floats:
    """(n,) the mixed Voronoi area of each vertex; they add up to the area of the mesh [meyer2003].

    In a triangle without an obtuse angle each corner owns the points nearest to it; otherwise the obtuse corner owns half of the
    triangle and the others a quarter each. A triangle without area contributes nothing.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
    """
    points, scale = scaled_to_unit(vertices)
    areas = np.empty(len(vertices))
    with threads_for(len(vertices)):
        _sum_areas(points, *ring_ends(faces, len(vertices)), areas)
    return areas / scale / scale


@compiled
def mixed_share(ux: float, uy: float, uz: float, uu: float, vx: float, vy: float, vz: float, vv: float) -> float:
    """The mixed Voronoi area at corner 0 of the triangle (0, u, v), given also the squared lengths of u and v."""
    cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    doubled = math.sqrt(cx * cx + cy * cy + cz * cz)
    if doubled == 0.0:
        return 0.0
    if ux * vx + uy * vy + uz * vz < 0.0:
        return 0.25 * doubled
    dx, dy, dz = vx - ux, vy - uy, vz - uz
    at_u = -(ux * dx + uy * dy + uz * dz)
    at_v = vx * dx + vy * dy + vz * dz
    if at_u < 0.0 or at_v < 0.0:
        return 0.125 * doubled
    return (vv * (at_u / doubled) + uu * (at_v / doubled)) * 0.125


@compiled(parallel=True)
def _sum_areas(points: Floats, offsets: Longs, ends: Ints, areas: Floats) -> None:
    for i in prange(offsets.shape[0] - 1):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        total = 0.0
        for k in range(offsets[i], offsets[i + 1], 2):
            a, b = ends[k], ends[k + 1]
            ux, uy, uz = points[a, 0] - x, points[a, 1] - y, points[a, 2] - z
            vx, vy, vz = points[b, 0] - x, points[b, 1] - y, points[b, 2] - z
            total += mixed_share(ux, uy, uz, ux * ux + uy * uy + uz * uz, vx, vy, vz, vx * vx + vy * vy + vz * vz)
        areas[i] = total

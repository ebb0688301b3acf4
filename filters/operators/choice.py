"""The Laplace-Beltrami operator that a mesh allows: cotangents, or the robust operator where they would mislead."""

import numpy as np

from ..mesh import Floats, Ints
from ..topology import non_manifold_edges

# Triangles whose doubled area is a smaller share of their squared edges need the robust operator: their cotangents
# spread the spectrum so far that the lowest eigenvalues drown in the rounding of the highest.
_SLIVER = 1e-5


def needs_robust_operator(points: Floats, faces: Ints) -> bool:
    """Whether a mesh is not manifold, or has triangles next to no area: no cotangents fit it.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles.
    """
    return len(non_manifold_edges(faces)) > 0 or _thinnest_triangle(points, faces) < _SLIVER


def _thinnest_triangle(points: Floats, faces: Ints) -> float:
    """The least doubled area of a triangle as a share of its summed squared edges, 0.29 if it is equilateral."""
    a, b, c = faces.T
    proper = (a != b) & (b != c) & (c != a)
    if not proper.any():
        return np.inf
    u, v = points[b[proper]] - points[a[proper]], points[c[proper]] - points[a[proper]]
    size = np.maximum(np.abs(u).max(axis=1), np.abs(v).max(axis=1))
    if not (size > 0.0).all():
        return 0.0
    u, v = u / size[:, None], v / size[:, None]
    squares = (u * u).sum(axis=1) + (v * v).sum(axis=1) + ((u - v) ** 2).sum(axis=1)
    return float((np.linalg.norm(np.cross(u, v), axis=1) / squares).min())

"""The Laplace-Beltrami operator of energies: with a mass at every vertex, and one for meshes that cotangents do not fit."""

from typing import NamedTuple

import numpy as np
from scipy import sparse

from ..mesh import Floats, Ints
from ..operators.cotangent import laplace_beltrami
from ..operators.robust import robust_mesh_laplacian
from ..spectral.problem import SLIVER, thinnest_triangle
from ..topology import non_manifold_edges

# Masses below this share of the mean count as that: the slivers of a bad triangulation would spoil the conditioning of all.
_LEAST_MASS = 1e-6


class SurfaceOperator(NamedTuple):
    """L = -M^-1 S on n vertices.

    Attributes:
        stiffness: S, (n, n) symmetric, positive semidefinite, with rows that sum to 0.
        mass: the diagonal of M, (n,), above 0.
    """

    stiffness: sparse.csr_matrix
    mass: Floats


def surface_operator(points: Floats, faces: Ints) -> SurfaceOperator:
    """Cotangents and mixed Voronoi areas [meyer2003]; for meshes that are not manifold, or have triangles next to no area, the
    same on the intrinsic Delaunay triangulation of the tufted cover [sharp2020].

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles.
    """
    robust = len(non_manifold_edges(faces)) > 0 or thinnest_triangle(points, faces) < SLIVER
    laplacian = robust_mesh_laplacian(points, faces) if robust else laplace_beltrami(points, faces)
    mean = float(laplacian.mass.mean()) if len(points) else 0.0
    mass = np.maximum(laplacian.mass, _LEAST_MASS * mean) if mean > 0.0 else np.ones(len(points))
    return SurfaceOperator(sparse.csr_matrix(-laplacian.stiffness), mass)

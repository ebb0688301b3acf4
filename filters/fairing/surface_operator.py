"""The Laplace-Beltrami operator of energies: that of the surface, with a mass above 0 at every vertex."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..libraries import sparse
from ..mesh import Floats, Ints
from ..operators import surface_laplacian

# Masses below this share of the largest among their neighbours count as that: the slivers of a bad triangulation would spoil the
# conditioning of all. Parts may be as much smaller than others as they like, down to the second share, of the mean: triangles of
# a length of 1e-10 of the others' are rounding.
_LEAST_MASS, _NO_MASS = 1e-6, 1e-20


class SurfaceOperator(NamedTuple):
    """L = -M^-1 S on n vertices.

    Attributes:
        dirichlet: S = -C with C the stiffness, (n, n) symmetric, positive semidefinite, with rows that sum to 0.
        mass: the diagonal of M, (n,), above 0.
    """

    dirichlet: sparse.csr_matrix
    mass: Floats


def surface_operator(points: Floats, faces: Ints) -> SurfaceOperator:
    """The operator of `surface_laplacian`, with a lower bound on the masses.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles.
    """
    laplacian, _ = surface_laplacian(points, faces)
    return SurfaceOperator(sparse.csr_matrix(-laplacian.stiffness), _floored(laplacian.mass, faces))


def _floored(mass: Floats, faces: Ints) -> Floats:
    """The masses, above 0, and none next to nothing against those of its neighbours."""
    mean = float(mass.mean()) if len(mass) else 0.0
    if not mean > 0.0:
        return np.ones(len(mass))
    around = mass.copy()
    for a, b in ((0, 1), (1, 2), (2, 0)):
        np.maximum.at(around, faces[:, a], mass[faces[:, b]])
        np.maximum.at(around, faces[:, b], mass[faces[:, a]])
    # Where there is no mass at all around, as at triangles without area, any will do.
    around[around <= _NO_MASS * mean] = mean
    return np.asarray(np.maximum(mass, _LEAST_MASS * around))

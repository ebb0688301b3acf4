"""The Laplace-Beltrami operator with a mass above 0 at every vertex, as energies need it."""

import math
from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, mask_of
from ..operators import surface_laplacian, surface_stiffness
from ..topology import proper_faces

# Masses below this share of the largest among their neighbours count as that: the slivers of a bad triangulation would spoil the
# conditioning of all. Parts may be as much smaller than others as they like, down to the second share, of the mean: triangles of
# a length of 1e-10 of the others' are rounding.
_LEAST_MASS, _NO_MASS = 1e-6, 1e-20


class SurfaceOperator(NamedTuple):
    """L = -M^-1 S on n vertices."""

    # S = -C with C the stiffness, (n, n) symmetric, positive semidefinite, with rows that sum to 0
    dirichlet: "sparse.csr_matrix"
    mass: Floats  # the diagonal of M, (n,), above 0


def surface_operator(points: Floats, faces: Ints, *, masses: bool = True) -> SurfaceOperator:
    """The operator of `surface_laplacian`, with a lower bound on the masses; without `masses`, which take time, these are 1."""
    if masses:
        laplacian = surface_laplacian(points, faces)
        dirichlet, mass = laplacian.stiffness, _floored(laplacian.mass, faces)
    else:
        dirichlet, mass = surface_stiffness(points, faces), np.ones(len(points))
    np.negative(dirichlet.data, out=dirichlet.data)
    return SurfaceOperator(dirichlet, mass)


def evened_operator(operator: SurfaceOperator, faces: Ints, irregular: Bools) -> tuple[SurfaceOperator, Bools]:
    """The operator with uniform weights and masses in the connected components of irregular vertices.

    Where edges and angles differ by orders of magnitude, the masses and weights do, too: a vertex of next to no mass costs
    nothing wherever it lies, and an energy throws it out to save a little elsewhere. There every edge gets the weight
    2 (cot 60) / 2 and every vertex the same mass, as if all triangles were equilateral.

    `irregular` are the (n,) vertices that an energy with this operator has thrown out. Returns the operator, and (n,) which
    vertices lie in such components.
    """
    n = len(operator.mass)
    a, b, c = faces[proper_faces(faces)].T
    ends = np.concatenate([a, b, c]), np.concatenate([b, c, a])
    edges = sparse.coo_matrix((np.ones(len(ends[0])), ends), shape=(n, n)).tocsr()
    edges = sparse.csr_matrix(edges + edges.T)
    edges.data[:] = 1.0 / math.sqrt(3.0)
    count, labels = sparse.csgraph.connected_components(edges, directed=False)
    inside = mask_of(labels[irregular], count)[labels]
    even = sparse.diags_array(np.asarray(edges.sum(axis=1)).ravel()) - edges
    share = sparse.diags_array(inside.astype(np.float64))
    kept = sparse.diags_array((~inside).astype(np.float64))
    means = np.bincount(labels, operator.mass, count) / np.maximum(np.bincount(labels, minlength=count), 1)
    mass = np.where(inside, means[labels], operator.mass)
    return SurfaceOperator(sparse.csr_matrix(share @ even + kept @ operator.dirichlet), mass), inside


def _floored(mass: Floats, faces: Ints) -> Floats:
    """The masses, above 0, each at least `_LEAST_MASS` of the largest among its neighbours."""
    mean = float(mass.mean()) if len(mass) else 0.0
    if not mean > 0.0:
        return np.ones(len(mass))
    around = _largest_around(mass, faces)
    # Where there is no mass at all around, as at triangles without area, any will do.
    around[around <= _NO_MASS * mean] = mean
    return np.asarray(np.maximum(mass, _LEAST_MASS * around))


@compiled
def _largest_around(mass: Floats, faces: Ints) -> Floats:
    """The largest mass at each vertex and its neighbours."""
    largest = mass.copy()
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        most = max(mass[a], mass[b], mass[c])
        largest[a], largest[b], largest[c] = max(largest[a], most), max(largest[b], most), max(largest[c], most)
    return largest

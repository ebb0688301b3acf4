"""The Laplace-Beltrami operator on the intrinsic Delaunay triangulation of the mollified tufted cover."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..checks import FilterInputError
from ..libraries import robust_laplacian, sparse
from ..mesh import Floats, Ints, scaled_to_unit
from .laplacian import Laplacian


def robust_mesh_laplacian(vertices: Floats, faces: Ints, *, mollify_factor: float = 1e-5) -> Laplacian:
    """The Laplace-Beltrami operator with weights that are neither negative nor infinite [sharp2020].

    For slivers, obtuse triangles and non-manifold meshes. The mass is a third of the area around a vertex in the intrinsic
    triangulation. A mesh whose vertices all coincide has the operator 0.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        mollify_factor: how far, as a share of the mean edge, a triangle may be from degenerate before its edges are lengthened
            intrinsically. Larger is safer and less exact.

    Raises:
        FilterInputError: the edges differ in length by too many orders of magnitude.
    """
    n = len(vertices)
    used = np.zeros(n, dtype=np.bool_)
    a, b, c = faces.T
    proper = faces[(a != b) & (b != c) & (c != a)]
    used[proper] = True
    points = vertices[used]
    if len(points) == 0 or not (points != points[0]).any():
        return Laplacian(sparse.csr_matrix((n, n)), np.zeros(n))
    scaled, scale = _at_the_origin(points)
    index = np.cumsum(used) - 1
    positive, masses = robust_laplacian.mesh_laplacian(scaled, index[proper], mollify_factor)
    spread = sparse.csr_array((np.ones(len(points)), np.flatnonzero(used), np.arange(len(points) + 1)), shape=(len(points), n))
    return _spread(positive, masses, scale, spread)


def robust_cloud_laplacian(points: Floats, *, n_neighbors: int = 30, mollify_factor: float = 1e-5) -> Laplacian:
    """The operator of `robust_mesh_laplacian` on a point cloud, from a Delaunay triangulation around every point [sharp2020].

    Points in the same place count as one and share its mass, and so move together.

    Args:
        points: (n, 3) coordinates.
        n_neighbors: how many neighbours the local triangulations use.
        mollify_factor: as for meshes.

    Raises:
        FilterInputError: no more places than neighbours, or a point that no local triangulation reaches.
    """
    n = len(points)
    if n == 0:
        return Laplacian(sparse.csr_matrix((0, 0)), np.zeros(0))
    places, place_of, together = np.unique(points, axis=0, return_inverse=True, return_counts=True)
    if len(places) <= n_neighbors:
        raise FilterInputError(
            f"a point cloud of {len(places)} points in different places has no {n_neighbors} neighbours for each: it takes at "
            f"least {n_neighbors + 1}"
        )
    if len(places) == n:
        places, place_of = points, np.arange(n)
        together = np.ones(n, dtype=np.int64)
    scaled, scale = _at_the_origin(places)
    try:
        positive, masses = robust_laplacian.point_cloud_laplacian(scaled, mollify_factor, n_neighbors)
    except RuntimeError as error:
        raise FilterInputError(
            "the local triangulations leave a point of the cloud without a triangle, as happens where many points lie on a line "
            f"or nearly coincide: remove such points, for example by a Poisson-disk sampling first ({error})"
        ) from error
    place_of = place_of.ravel()
    spread = sparse.csr_array((1.0 / together[place_of], (place_of, np.arange(n))), shape=(len(places), n))
    return _spread(positive, masses, scale, spread)


def _at_the_origin(points: Floats) -> tuple[Floats, float]:
    return scaled_to_unit(np.ascontiguousarray(points - points.mean(axis=0)))


def _spread(positive: Any, masses: Any, scale: float, spread: sparse.csr_array) -> Laplacian:
    """The library's operator on k points as one on n vertices, by the shares of the (k, n) matrix `spread`."""
    stiffness = sparse.csr_matrix(-(spread.T @ sparse.csr_array(positive) @ spread))
    stiffness.sort_indices()
    if not np.isfinite(stiffness.data).all():
        raise FilterInputError(
            "edges of the mesh differ in length by so many orders of magnitude that no numbers are left for its operator: remove "
            "spikes, or the smallest triangles, first"
        )
    return Laplacian(stiffness, np.asarray(spread.T @ masses.diagonal()) / scale / scale)

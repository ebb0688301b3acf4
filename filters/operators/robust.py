"""The Laplace-Beltrami operator on the intrinsic Delaunay triangulation of the mollified tufted cover."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import sparse

from ..errors import FilterInputError
from ..topology import Bools, Floats, Ints
from .laplacian import Laplacian
from .scale import scaled_to_unit


def robust_mesh_laplacian(vertices: Floats, faces: Ints, *, mollify_factor: float = 1e-5) -> Laplacian:
    """The operator of `laplace_beltrami` without its troubles: no weight is negative and none is infinite [sharp2020].

    For slivers, obtuse triangles and non-manifold meshes. The mass is a third of the area around a vertex in the intrinsic
    triangulation. A mesh whose vertices all coincide has the operator 0.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        mollify_factor: how far, as a share of the mean edge, a triangle may be from degenerate before its edges are lengthened
            intrinsically. Larger is safer and less exact.
    """
    n = len(vertices)
    used = np.zeros(n, dtype=bool)
    a, b, c = faces.T
    proper = faces[(a != b) & (b != c) & (c != a)]
    used[proper] = True
    index = np.cumsum(used) - 1
    return _embedded(vertices, used, lambda points, lib: lib.mesh_laplacian(points, index[proper], mollify_factor))


def robust_cloud_laplacian(points: Floats, *, n_neighbors: int = 30, mollify_factor: float = 1e-5) -> Laplacian:
    """The operator of `robust_mesh_laplacian` on a point cloud, from a Delaunay triangulation around every point [sharp2020].

    Args:
        points: (n, 3) coordinates.
        n_neighbors: how many neighbours the local triangulations use.
        mollify_factor: as for meshes.

    Raises:
        FilterInputError: fewer points than neighbours.
    """
    if 0 < len(points) <= n_neighbors:
        raise FilterInputError(
            f"a point cloud of {len(points)} points has no {n_neighbors} neighbours for each: it takes at least {n_neighbors + 1}"
        )
    used = np.ones(len(points), dtype=bool)
    return _embedded(points, used, lambda scaled, lib: lib.point_cloud_laplacian(scaled, mollify_factor, n_neighbors))


def _embedded(vertices: Floats, used: Bools, build: Callable[[Floats, Any], tuple[Any, Any]]) -> Laplacian:
    import robust_laplacian

    n = len(vertices)
    points = vertices[used]
    if len(points) == 0 or not (points != points[0]).any():
        return Laplacian(sparse.csr_matrix(sparse.diags_array(np.zeros(n))), np.zeros(n))
    scaled, scale = scaled_to_unit(np.ascontiguousarray(points - points.mean(axis=0)))
    positive, masses = build(scaled, robust_laplacian)
    entries = sparse.coo_array(positive)
    index = np.flatnonzero(used)
    stiffness = sparse.csr_matrix((-entries.data, (index[entries.row], index[entries.col])), shape=(n, n))
    stiffness.sort_indices()
    mass = np.zeros(n)
    mass[used] = masses.diagonal() / scale**2
    return Laplacian(stiffness, mass)

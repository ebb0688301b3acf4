"""Laplace operators by name, of meshes, clouds and polylines; the robust one, of the intrinsic Delaunay triangulation."""

import math
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from ..checks import FilterInputError, check_choice
from ..compilation import compiled
from ..libraries import robust_laplacian, sparse
from ..mesh import Floats, Ints, mask_of, scaled_to_unit
from ..topology import non_manifold_edges, proper_faces
from .laplacian import (
    Laplacian,
    cotangent_laplacian,
    inverse_length_laplacian,
    laplace_beltrami,
    scale_dependent_laplacian,
    uniform_laplacian,
)

OperatorName: TypeAlias = Literal["uniform", "inverse_length", "scale_dependent", "cotangent", "laplace_beltrami", "robust"]
OPERATOR_NAMES: tuple[OperatorName, ...] = get_args(OperatorName)
SurfaceOperatorName: TypeAlias = Literal["auto", "cotangent", "robust"]
#: A mesh needs the robust operator if the doubled area of a triangle is a smaller share than this of its squared edges: its
#: cotangents spread the spectrum so far that the lowest eigenvalues drown in the rounding of the highest.
_SLIVER = 1e-5
#: A triangle nearer to degenerate than this share of the mean edge has its edges lengthened intrinsically.
_MOLLIFIED = 1e-5
#: The neighbours from which the triangulation around a point of a cloud is made.
_NEIGHBOURS = 30
#: The operator of curves for each of surfaces. Inverse lengths on a polyline are linear finite elements, as cotangents are on
#: triangles; the scale-dependent operator is the second derivative by arc length, which has the unit of Laplace-Beltrami.
CURVE_OPERATOR: dict[OperatorName, Literal["uniform", "inverse_length", "scale_dependent"]] = {
    "uniform": "uniform",
    "inverse_length": "inverse_length",
    "cotangent": "inverse_length",
    "scale_dependent": "scale_dependent",
    "laplace_beltrami": "scale_dependent",
    "robust": "scale_dependent",
}


def build_laplacian(vertices: Floats, faces: Ints, operator: OperatorName) -> Laplacian:
    """The operator of that name on a mesh, or for "robust" and no faces on a point cloud.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles, or (0, 3) for a point cloud.
        operator: "uniform", "inverse_length" and "cotangent" are normalised: L has no unit and eigenvalues in [-2, 0].
            "scale_dependent", "laplace_beltrami" and "robust" have the unit of one over a squared length.

    Raises:
        FilterInputError: an unknown name, or a point cloud with another operator than "robust".
    """
    check_choice("operator", operator, OPERATOR_NAMES)
    if len(faces) == 0 and len(vertices) > 0:
        if operator != "robust":
            raise FilterInputError(f"operator {operator!r} needs triangles and there are none; for a point cloud take 'robust'")
        return robust_cloud_laplacian(vertices)
    return _named(vertices, faces, operator)


def _named(vertices: Floats, faces_or_edges: Ints, operator: OperatorName) -> Laplacian:
    builders = {
        "inverse_length": inverse_length_laplacian,
        "scale_dependent": scale_dependent_laplacian,
        "cotangent": cotangent_laplacian,
        "laplace_beltrami": laplace_beltrami,
        "robust": robust_mesh_laplacian,
    }
    if operator == "uniform":
        return uniform_laplacian(faces_or_edges, len(vertices))
    return builders[operator](vertices, faces_or_edges)


def surface_laplacian(points: Floats, faces: Ints, operator: SurfaceOperatorName = "auto") -> Laplacian:
    """The Laplace-Beltrami operator of a surface, in one over squared mesh units.

    "cotangent" is linear finite elements with mixed Voronoi areas as lumped mass [meyer2003], "robust" the same on the intrinsic
    Delaunay triangulation of the tufted cover [sharp2020], which "auto" takes for meshes that are not manifold or have triangles
    with next to no area.

    Raises:
        FilterInputError: an unknown operator.
    """
    check_choice("operator", operator, SurfaceOperatorName)
    if operator == "robust" or (operator == "auto" and _needs_robust(points, faces)):
        return robust_mesh_laplacian(points, faces)
    return laplace_beltrami(points, faces)


def _needs_robust(points: Floats, faces: Ints) -> bool:
    return len(non_manifold_edges(faces)) > 0 or _thinnest_triangle(points, faces) < _SLIVER


@compiled(nogil=True)
def _thinnest_triangle(points: Floats, faces: Ints) -> float:
    """The least doubled area of a triangle as a share of its summed squared edges, 0.29 if it is equilateral."""
    least = np.inf
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a == b or b == c or c == a:
            continue
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        size = max(abs(ux), abs(uy), abs(uz), abs(vx), abs(vy), abs(vz))
        if not size > 0.0:
            return 0.0
        ux, uy, uz, vx, vy, vz = ux / size, uy / size, uz / size, vx / size, vy / size, vz / size
        cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        squares = (ux * ux + uy * uy + uz * uz) + (vx * vx + vy * vy + vz * vz)
        squares += (ux - vx) ** 2 + (uy - vy) ** 2 + (uz - vz) ** 2
        least = min(least, math.sqrt(cx * cx + cy * cy + cz * cz) / squares)
    return least


def curve_laplacian(vertices: Floats, edges: Ints, operator: OperatorName) -> Laplacian:
    """The operator of `CURVE_OPERATOR` on the polylines that (e, 2) edges form, for example the borders of a mesh."""
    return _named(vertices, edges, CURVE_OPERATOR[operator])


def robust_mesh_laplacian(vertices: Floats, faces: Ints) -> Laplacian:
    """The Laplace-Beltrami operator with weights that are neither negative nor infinite [sharp2020].

    For slivers, obtuse triangles and non-manifold meshes. The mass is a third of the area around a vertex in the intrinsic
    triangulation. A mesh whose vertices all coincide has the operator 0.
    """
    n = len(vertices)
    proper = faces[proper_faces(faces)]
    used = mask_of(proper, n)
    points = vertices[used]
    if len(points) == 0 or not (points != points[0]).any():
        return Laplacian(sparse.csr_matrix((n, n)), np.zeros(n))
    scaled, scale = _at_the_origin(points)
    index = np.cumsum(used) - 1
    positive, masses = robust_laplacian.mesh_laplacian(scaled, index[proper], _MOLLIFIED)
    spread = sparse.csr_array((np.ones(len(points)), np.flatnonzero(used), np.arange(len(points) + 1)), shape=(len(points), n))
    return _spread(positive, masses, scale, spread)


def robust_cloud_laplacian(points: Floats) -> Laplacian:
    """The operator of `robust_mesh_laplacian` on a point cloud, from a Delaunay triangulation around every point [sharp2020].

    Points in the same place count as one and share its mass, and so move together.
    """
    n = len(points)
    if n == 0:
        return Laplacian(sparse.csr_matrix((0, 0)), np.zeros(0))
    places, place_of, together = np.unique(points, axis=0, return_inverse=True, return_counts=True)
    if len(places) <= _NEIGHBOURS:
        raise FilterInputError(
            f"a point cloud of {len(places)} points in different places has no {_NEIGHBOURS} neighbours for each: it takes at "
            f"least {_NEIGHBOURS + 1}"
        )
    if len(places) == n:
        places, place_of = points, np.arange(n)
        together = np.ones(n, dtype=np.int64)
    scaled, scale = _at_the_origin(places)
    try:
        positive, masses = robust_laplacian.point_cloud_laplacian(scaled, _MOLLIFIED, _NEIGHBOURS)
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


def _spread(positive: Any, masses: Any, scale: float, spread: "sparse.csr_array") -> Laplacian:
    """The library's operator on k points as one on n vertices, by the shares of the (k, n) matrix `spread`."""
    stiffness = sparse.csr_matrix(-(spread.T @ sparse.csr_array(positive) @ spread))
    stiffness.sort_indices()
    if not np.isfinite(stiffness.data).all():
        raise FilterInputError(
            "edges of the mesh differ in length by so many orders of magnitude that its operator is out of the range of numbers: "
            "remove spikes, or the smallest triangles, first"
        )
    return Laplacian(stiffness, np.asarray(spread.T @ masses.diagonal()) / scale / scale)

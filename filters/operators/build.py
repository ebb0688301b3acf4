"""Laplace operators by name, of meshes, clouds and polylines."""

import math
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from ..checks import FilterInputError, check_choice
from ..compilation import compiled
from ..mesh import Floats, Ints
from ..topology import non_manifold_edges
from .cotangent import cotangent_laplacian, laplace_beltrami
from .edge_weights import inverse_length_laplacian, scale_dependent_laplacian, uniform_laplacian
from .laplacian import Laplacian
from .robust import robust_cloud_laplacian, robust_mesh_laplacian

OperatorName: TypeAlias = Literal["uniform", "inverse_length", "scale_dependent", "cotangent", "laplace_beltrami", "robust"]
OPERATOR_NAMES: tuple[OperatorName, ...] = get_args(OperatorName)
SurfaceOperatorName: TypeAlias = Literal["auto", "cotangent", "robust"]
SURFACE_OPERATORS: tuple[SurfaceOperatorName, ...] = get_args(SurfaceOperatorName)
#: A mesh needs the robust operator if the doubled area of a triangle is a smaller share than this of its squared edges: its
#: cotangents spread the spectrum so far that the lowest eigenvalues drown in the rounding of the highest.
_SLIVER = 1e-5
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
    if operator == "uniform":
        return uniform_laplacian(faces, len(vertices))
    if operator == "inverse_length":
        return inverse_length_laplacian(vertices, faces)
    if operator == "scale_dependent":
        return scale_dependent_laplacian(vertices, faces)
    if operator == "cotangent":
        return cotangent_laplacian(vertices, faces)
    if operator == "laplace_beltrami":
        return laplace_beltrami(vertices, faces)
    return robust_mesh_laplacian(vertices, faces)


class ChosenLaplacian(NamedTuple):
    """A Laplace-Beltrami operator and its name."""

    laplacian: Laplacian
    operator: Literal["cotangent", "robust"]


def surface_laplacian(points: Floats, faces: Ints, operator: SurfaceOperatorName = "auto") -> ChosenLaplacian:
    """The Laplace-Beltrami operator of a surface, in one over squared mesh units.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles.
        operator: "cotangent": linear finite elements with mixed Voronoi areas as lumped mass [meyer2003]. "robust": the same on
            the intrinsic Delaunay triangulation of the tufted cover [sharp2020]. "auto": "robust" for meshes that are not
            manifold or have triangles with next to no area, "cotangent" for all others.

    Raises:
        FilterInputError: an unknown operator.
    """
    check_choice("operator", operator, SURFACE_OPERATORS)
    if operator == "robust" or (operator == "auto" and _needs_robust_operator(points, faces)):
        return ChosenLaplacian(robust_mesh_laplacian(points, faces), "robust")
    return ChosenLaplacian(laplace_beltrami(points, faces), "cotangent")


def _needs_robust_operator(points: Floats, faces: Ints) -> bool:
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
    """The operator of `CURVE_OPERATOR` on the polylines that the edges form, for example the borders of a mesh.

    Args:
        vertices: (n, 3) coordinates.
        edges: (e, 2) edges; the rows of vertices that none of them touches are 0.
        operator: the operator of the surface.
    """
    curve = CURVE_OPERATOR[operator]
    if curve == "uniform":
        return uniform_laplacian(edges, len(vertices))
    if curve == "inverse_length":
        return inverse_length_laplacian(vertices, edges)
    return scale_dependent_laplacian(vertices, edges)

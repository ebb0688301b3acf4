"""The Laplace-Beltrami operator of a surface: cotangents, or the robust operator where a mesh does not fit them."""

from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from ..checks import check_choice
from ..mesh import Floats, Ints
from ..topology import non_manifold_edges
from .cotangent import laplace_beltrami
from .laplacian import Laplacian
from .robust import robust_mesh_laplacian

SurfaceOperatorName: TypeAlias = Literal["auto", "cotangent", "robust"]
SURFACE_OPERATORS: tuple[SurfaceOperatorName, ...] = get_args(SurfaceOperatorName)

#: A mesh needs the robust operator if the doubled area of a triangle is a smaller share than this of its squared edges: its
#: cotangents spread the spectrum so far that the lowest eigenvalues drown in the rounding of the highest.
_SLIVER = 1e-5


class ChosenLaplacian(NamedTuple):
    """A Laplace-Beltrami operator and which one it is."""

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

"""The generalised eigenproblem of a surface's Laplace-Beltrami operator: S v = kappa M v."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from ..checks import FilterInputError
from ..mesh import Bools, Floats, Ints, check_mesh
from ..operators import Laplacian, laplace_beltrami, needs_robust_operator, robust_mesh_laplacian
from ..topology import connected_components

SpectralOperator: TypeAlias = Literal["auto", "cotangent", "robust"]
SPECTRAL_OPERATORS: tuple[SpectralOperator, ...] = get_args(SpectralOperator)


@dataclass(frozen=True, eq=False)
class SpectralProblem:
    """S v = kappa M v on the vertices of a mesh that belong to a surface: n of them.

    The eigenvalues kappa are not negative and have the unit of one over a squared length; sqrt(kappa) is a frequency in radians
    per mesh unit, 2 pi / sqrt(kappa) a wavelength. Borders are natural: modes end there with slope 0.

    Attributes:
        stiffness: S = -C, (n, n) scipy.sparse.csr_matrix float64, symmetric, positive semidefinite, with rows that sum to 0.
        mass: the diagonal of M, (n,), above 0, in squared mesh units.
        vertices: (n,) ascending, the vertex of the mesh that each row stands for. The others, which no triangle uses or whose
            component has no area, have no part in it.
        components: (n,) the connected component of each row, counted from 0 in order of its first row. No entry of S joins two.
        n_vertices: the number of vertices of the mesh.
        operator: "cotangent" or "robust", what S and M were made by.
    """

    stiffness: sparse.csr_matrix
    mass: Floats
    vertices: Ints
    components: Ints
    n_vertices: int
    operator: Literal["cotangent", "robust"]

    @property
    def n_components(self) -> int:
        """How many connected components there are."""
        return int(self.components.max(initial=-1)) + 1


def spectral_problem(vertices: ArrayLike, faces: ArrayLike, *, operator: SpectralOperator = "auto") -> SpectralProblem:
    """The eigenproblem of a mesh.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        operator: "cotangent": linear finite elements with mixed Voronoi areas as lumped mass [meyer2003]. "robust": the same on
            the intrinsic Delaunay triangulation of the tufted cover [sharp2020], for meshes that are not manifold or have
            triangles next to no area. "auto": "robust" for those, "cotangent" for all others.

    Raises:
        FilterInputError: not a mesh, an unknown operator, or "cotangent" for a mesh with vertices all of whose triangles have no
            area.
    """
    points, triangles = check_mesh(vertices, faces)
    if operator not in SPECTRAL_OPERATORS:
        raise FilterInputError(f"operator {operator!r} is not one of {', '.join(map(repr, SPECTRAL_OPERATORS))}")
    components, _ = connected_components(triangles, len(points))
    chosen: Literal["cotangent", "robust"] = "robust" if operator == "robust" else "cotangent"
    if operator == "auto" and needs_robust_operator(points, triangles):
        chosen = "robust"
    laplacian = robust_mesh_laplacian(points, triangles) if chosen == "robust" else laplace_beltrami(points, triangles)
    return _restricted(laplacian, components, _usable(laplacian, components, operator), chosen)


def _usable(laplacian: Laplacian, components: Ints, operator: SpectralOperator) -> Bools:
    """(n,) which vertices have a part in the problem: those of components all of whose masses are above 0."""
    used = components >= 0
    massless = used & ~(laplacian.mass > 0.0)
    if not massless.any():
        return used
    stricken = np.zeros(int(components.max(initial=-1)) + 1, dtype=np.bool_)
    stricken[components[massless]] = True
    has_area = np.zeros_like(stricken)
    has_area[components[used & (laplacian.mass > 0.0)]] = True
    if (stricken & has_area).any():
        first = int(massless.argmax())
        raise FilterInputError(
            f"vertex {first} has no area: all its triangles are degenerate ({int(massless.sum())} such vertices): take the "
            f"operator 'robust' instead of {operator!r}, or remove them"
        )
    return used & ~stricken[components]


def _restricted(laplacian: Laplacian, components: Ints, used: Bools, operator: Literal["cotangent", "robust"]) -> SpectralProblem:
    rows = np.flatnonzero(used).astype(np.int32)
    stiffness = sparse.csr_matrix(-laplacian.stiffness)
    if len(rows) < len(used):
        stiffness = sparse.csr_matrix(stiffness[rows][:, rows])
    stiffness.sort_indices()
    left, first, inverse = np.unique(components[rows], return_index=True, return_inverse=True)
    # In the order of their first vertex already, since connected components are counted so.
    assert len(left) < 2 or (np.diff(first) > 0).all()
    return SpectralProblem(stiffness, laplacian.mass[rows], rows, inverse.astype(np.int32).ravel(), len(used), operator)


def about_centroids(points: Floats, problem: SpectralProblem) -> tuple[Floats, Floats]:
    """(n, 3) points about the centroid of their component, which no filter moves, and (n, 3) that centroid."""
    parts, mass = problem.components, problem.mass
    weight = np.bincount(parts, mass)
    means = np.stack([np.bincount(parts, mass * points[:, c]) / weight for c in range(3)], axis=1)
    return points - means[parts], means[parts]

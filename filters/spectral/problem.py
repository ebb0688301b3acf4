"""The generalised eigenproblem of the Laplace-Beltrami operator of a surface: S v = kappa M v."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, check_mesh, mask_of, normalised_mesh
from ..operators import Laplacian, SurfaceOperatorName, surface_laplacian
from ..topology import connected_components

_SMALLEST, _LARGEST = 1e-153, 1e153


@dataclass(frozen=True, eq=False)
class SpectralProblem:
    """S v = kappa M v on the vertices of a mesh that belong to a surface: n of them.

    The eigenvalues kappa are not negative and have the unit of one over a squared length; sqrt(kappa) is a frequency in radians
    per mesh unit, 2 pi / sqrt(kappa) a wavelength. Borders are natural: modes end there with slope 0.

    Attributes:
        dirichlet: S = -C with C the stiffness, (n, n) scipy.sparse.csr_matrix float64, symmetric, positive semidefinite, with
            rows that sum to 0; v^T S v is the Dirichlet energy of v.
        mass: the diagonal of M, (n,), above 0, in squared mesh units.
        vertices: (n,) ascending, the vertex of the mesh that each row stands for. Vertices that no triangle uses, or whose
            component has no area, have no row.
        components: (n,) the connected component of each row, counted from 0 in order of its first row. No entry of S joins two.
        n_vertices: the number of vertices of the mesh.
    """

    dirichlet: "sparse.csr_matrix"
    mass: Floats
    vertices: Ints
    components: Ints
    n_vertices: int

    @property
    def n_components(self) -> int:
        """The number of connected components."""
        return int(self.components.max(initial=-1)) + 1

    @property
    def n_waves(self) -> int:
        """The number of modes, without those that are constant on a component."""
        return len(self.mass) - self.n_components

    def on_mesh(self, values: Floats) -> Floats:
        """(n_vertices,) or (n_vertices, k), Fortran-ordered: (n,) or (n, k) values of rows at their vertices, 0 elsewhere."""
        spread = np.zeros((self.n_vertices, *values.shape[1:]), order="F")
        spread[self.vertices] = values
        return spread


def spectral_problem(vertices: ArrayLike, faces: ArrayLike, *, operator: SurfaceOperatorName = "auto") -> SpectralProblem:
    """The eigenproblem of a mesh.

    Raises:
        FilterInputError: not a mesh, an unknown operator, or "cotangent" for a mesh with vertices all of whose triangles have no
            area.
    """
    points, triangles = check_mesh(vertices, faces)
    check_size(1.0 / normalised_mesh(points, triangles).scale)
    components, _ = connected_components(triangles, len(points))
    laplacian = surface_laplacian(points, triangles, operator)
    rows = np.flatnonzero(_usable(laplacian, components, operator)).astype(np.int32)
    dirichlet = sparse.csr_matrix(-laplacian.stiffness)
    if len(rows) < len(points):
        dirichlet = sparse.csr_matrix(dirichlet[rows][:, rows])
    dirichlet.sort_indices()
    _, numbers = np.unique(components[rows], return_inverse=True)  # in the order of their first vertex, as all components are
    return SpectralProblem(dirichlet, laplacian.mass[rows], rows, numbers.astype(np.int32).ravel(), len(points))


def check_size(size: float) -> None:
    """Refuses sizes of meshes whose areas or eigenvalues, one over squared lengths, leave the range of numbers.

    Raises:
        FilterInputError: the size is out of range.
    """
    if not _SMALLEST < size < _LARGEST:
        raise FilterInputError(
            f"the mesh is about {size:.0e} large, so that the squares of its lengths are out of range: scale it first"
        )


def _usable(laplacian: Laplacian, components: Ints, operator: SurfaceOperatorName) -> Bools:
    """(n,) which vertices have a row: those of components all of whose masses are above 0."""
    used = components >= 0
    massless = used & ~(laplacian.mass > 0.0)
    if not massless.any():
        return used
    count = int(components.max(initial=-1)) + 1
    stricken, has_area = mask_of(components[massless], count), mask_of(components[used & (laplacian.mass > 0.0)], count)
    if (stricken & has_area).any():
        first = int(massless.argmax())
        raise FilterInputError(
            f"vertex {first} has no area: all its triangles are degenerate ({int(massless.sum())} such vertices): take the "
            f"operator 'robust' instead of {operator!r}, or remove them"
        )
    return used & ~stricken[components]


def about_centroids(points: Floats, problem: SpectralProblem) -> tuple[Floats, Floats]:
    """(n, 3) points about the centroid of their component, which no filter moves, and (n, 3) that centroid."""
    parts, mass = problem.components, problem.mass
    weight = np.bincount(parts, mass)
    means = np.stack([np.bincount(parts, mass * points[:, c]) / weight for c in range(3)], axis=1)
    return points - means[parts], means[parts]

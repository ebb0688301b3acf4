"""The eigenproblem of a surface, S v = kappa M v, and responses: the factors by which filters multiply its modes.

The frequency of a mode is omega = sqrt(kappa), in radians per unit length; its wavelength is 2 pi / omega.
All responses combine profiles exp(-ln 2 (omega / omega_c)^(2 n)) with one or two cutoffs omega_c. Diffusion of order n has this
profile after the time that halves the amplitude at omega_c. A profile is as flat at 0 as Butterworth's
1 / (1 + (omega / omega_c)^(2 n)), and falls faster, so that it needs fewer eigenvectors.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_finite, check_positive, check_whole_number
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, check_mesh, mask_of, normalised_mesh
from ..operators import Laplacian, SurfaceOperatorName, surface_laplacian
from ..topology import connected_components

_SMALLEST, _LARGEST = 1e-153, 1e153  # bounds of mesh sizes, see `check_size`


@dataclass(frozen=True, eq=False)
class SpectralProblem:
    """The eigenproblem S v = kappa M v on the n vertices of a mesh that belong to its surface.

    The eigenvalues kappa are not negative; their unit is one over a squared mesh unit. At borders modes have slope 0.

    Attributes:
        dirichlet: S = -C with C the stiffness, (n, n) scipy.sparse.csr_matrix float64, symmetric, positive semidefinite, with
            rows that sum to 0; v^T S v is the Dirichlet energy of v.
        mass: the diagonal of M, (n,), above 0, in squared mesh units.
        vertices: (n,) the mesh vertex of each row, ascending. Vertices without a mass, and those of components without area,
            have no row.
        components: (n,) the component of each row, numbered from 0 in order of occurrence.
        n_vertices: the number of vertices of the mesh.
    """

    dirichlet: sparse.csr_matrix
    mass: Floats
    vertices: Ints
    components: Ints
    n_vertices: int

    @property
    def n_components(self) -> int:
        return int(self.components.max(initial=-1)) + 1

    @property
    def n_waves(self) -> int:
        """The number of modes, without the constant mode of each component."""
        return len(self.mass) - self.n_components

    def on_mesh(self, values: Floats) -> Floats:
        """Spreads (n,) or (n, k) values of rows to (n_vertices,) or (n_vertices, k), Fortran-ordered; 0 at other vertices."""
        spread = np.zeros((self.n_vertices, *values.shape[1:]), order="F")
        spread[self.vertices] = values
        return spread


def spectral_problem(
    vertices: ArrayLike, faces: ArrayLike, *, operator: SurfaceOperatorName = "auto", numbers: Ints | None = None
) -> SpectralProblem:
    """Builds the eigenproblem of a mesh. Errors name vertices by their (n,) `numbers`, or by their indices.

    Raises:
        FilterInputError: not a mesh, an unknown operator, a size out of range, or a vertex without area in a component with area.
    """
    points, triangles = check_mesh(vertices, faces)
    check_size(1.0 / normalised_mesh(points, triangles).scale)
    components, _ = connected_components(triangles, len(points))
    laplacian = surface_laplacian(points, triangles, operator)
    rows = np.flatnonzero(_usable(laplacian, components, operator, numbers)).astype(np.int32)
    dirichlet = sparse.csr_matrix(-laplacian.stiffness)
    if len(rows) < len(points):
        dirichlet = sparse.csr_matrix(dirichlet[rows][:, rows])
    dirichlet.sort_indices()
    _, parts = np.unique(components[rows], return_inverse=True)  # numbered by first vertex, like all components
    return SpectralProblem(dirichlet, laplacian.mass[rows], rows, parts.astype(np.int32).ravel(), len(points))


def check_size(size: float) -> None:
    """Refuses a mesh size whose square (areas) or inverse square (eigenvalues) leaves the range of floating-point numbers."""
    if not _SMALLEST < size < _LARGEST:
        raise FilterInputError(
            f"the mesh is about {size:.0e} large, so that the squares of its lengths are out of range: scale it first"
        )


def _usable(laplacian: Laplacian, components: Ints, operator: SurfaceOperatorName, numbers: Ints | None) -> Bools:
    """Returns (n,) which vertices have a row: those with a triangle, in components without a vertex of mass 0."""
    used = components >= 0
    massless = used & ~(laplacian.mass > 0.0)
    if not massless.any():
        return used
    count = int(components.max(initial=-1)) + 1
    stricken, has_area = mask_of(components[massless], count), mask_of(components[used & (laplacian.mass > 0.0)], count)
    if (stricken & has_area).any():
        refused = np.flatnonzero(massless & has_area[components])
        raise FilterInputError(
            f"vertex {refused[0] if numbers is None else numbers[refused[0]]} has no area: all its triangles are degenerate "
            f"({len(refused)} such vertices): take the operator 'robust' instead of {operator!r}, or remove them"
        )
    return used & ~stricken[components]


def about_centroids(points: Floats, problem: SpectralProblem) -> tuple[Floats, Floats]:
    """Returns (n, 3) points relative to the centroid of their component, and (n, 3) these centroids."""
    parts, mass = problem.components, problem.mass
    weight = np.bincount(parts, mass)
    means = np.stack([np.bincount(parts, mass * points[:, c]) / weight for c in range(3)], axis=1)
    return points - means[parts], means[parts]


ResponseName: TypeAlias = Literal["low_pass", "band_pass", "enhance"]

#: The allowed orders n.
ORDERS = range(1, 9)
DEFAULT_ORDER = 2  # the lowest order that is flatter at 0 than diffusion


@dataclass(frozen=True)
class Response:
    """A response, smooth on omega > 0, with the limit `infinity`:
    F(omega) = infinity + sum_i weights_i exp(-ln 2 (omega / cutoffs_i)^(2 order)).
    """

    name: ResponseName  # see `RESPONSES`
    cutoffs: tuple[float, ...]  # the frequencies at which the profiles are 1/2, ascending, in radians per unit length
    order: int
    weights: tuple[float, ...]
    infinity: float = 0.0

    def __call__(self, frequencies: Floats) -> Floats:
        """Returns F at each frequency from 0. F(0) is 1, so that each component keeps its centroid."""
        omega = np.asarray(frequencies, dtype=np.float64)
        return np.where(omega == 0.0, 1.0, self.profile(omega))

    def profile(self, frequencies: Floats) -> Floats:
        """Returns F without the exception at 0; frequencies may be infinite."""
        omega = np.asarray(frequencies, dtype=np.float64)
        total = np.full(omega.shape, self.infinity)
        with np.errstate(over="ignore", under="ignore"):
            for cutoff, weight in zip(self.cutoffs, self.weights, strict=True):
                total += weight * np.exp(-math.log(2.0) * (omega / cutoff) ** (2 * self.order))
        return total

    def last_frequency(self, tolerance: float) -> float:
        """The frequency beyond which F differs from its limit by less than `tolerance` > 0: higher modes do not matter."""
        largest = sum(map(abs, self.weights))
        if largest <= tolerance:
            return 0.0
        return self.cutoffs[-1] * math.pow(math.log2(largest / tolerance), 0.5 / self.order)


def low_pass(detail_size: float, *, order: int = DEFAULT_ORDER) -> Response:
    """Removes waves shorter than the detail size: F(2 pi / detail_size) = 1/2 exactly.

    A larger `detail_size`, in mesh units, removes more. A larger `order` n cuts off more sharply and rings more.
    """
    return Response("low_pass", (cutoff_frequency("detail_size", detail_size),), _checked_order(order), (1.0,))


def band_pass(detail_size: float, largest_size: float, *, gain: float = 1.0, order: int = DEFAULT_ORDER) -> Response:
    """Keeps only waves between two lengths, and the centroid of each component: the difference of two low passes.

    At both ends the amplitude is half of `gain` up to an error. As a share of `gain` the error is 2^-q at the short end and
    1 - 2^(-1 / q) at the long end, where q = (largest_size / detail_size)^(2 n): at most 4.3 % for an octave and n = 2.

    Args:
        detail_size: the shortest wavelength that stays, in mesh units.
        largest_size: the longest wavelength that stays, above `detail_size`.
        gain: the factor on waves in the band, finite.
        order: see `low_pass`.
    """
    long, short = _band(detail_size, largest_size)
    gain = check_finite("gain", gain)
    return Response("band_pass", (long, short), _checked_order(order), (-gain, gain))


def enhance(detail_size: float, largest_size: float, *, gain: float = 2.0, order: int = DEFAULT_ORDER) -> Response:
    """Multiplies waves between two lengths by `gain` and keeps all others: 1 + (gain - 1) times the band of `band_pass`.

    Args:
        detail_size: the shortest wavelength that changes, in mesh units. Choose it above the wavelengths of the noise.
        largest_size: the longest wavelength that changes, above `detail_size`.
        gain: above 1 makes these details stronger, below 1 weaker; 0 removes them.
        order: see `low_pass`.
    """
    long, short = _band(detail_size, largest_size)
    gain = check_finite("gain", gain)
    return Response("enhance", (long, short), _checked_order(order), (1.0 - gain, gain - 1.0), infinity=1.0)


#: The functions that make responses, by name.
RESPONSES: dict[ResponseName, Callable[..., Response]] = {"low_pass": low_pass, "band_pass": band_pass, "enhance": enhance}


def cutoff_frequency(name: str, wavelength: float) -> float:
    """Returns 2 pi / wavelength, in radians per unit length; errors name the parameter `name`."""
    return 2.0 * math.pi / check_positive(name, wavelength, note="; it is a wavelength in mesh units")


def _band(detail_size: float, largest_size: float) -> tuple[float, float]:
    long, short = cutoff_frequency("largest_size", largest_size), cutoff_frequency("detail_size", detail_size)
    if not long < short:
        raise FilterInputError(f"largest_size {largest_size} is not above detail_size {detail_size}: no wave is in between")
    return long, short


def _checked_order(order: int) -> int:
    return check_whole_number("order", order, least=ORDERS[0], most=ORDERS[-1])

"""Spectral filter of a surface: with eigenvectors, or with a polynomial or rational function of the Laplacian."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice, check_positive, check_whole_number
from ..execution import Progress, ignore_progress, rising
from ..mesh import Floats, check_mesh, normalised_mesh
from ..operators import SurfaceOperatorName
from .eigenpairs import lowest_eigenpairs
from .eigenvector_free import filter_without_eigenvectors
from .problem import (
    DEFAULT_ORDER,
    RESPONSES,
    Response,
    ResponseName,
    SpectralProblem,
    about_centroids,
    cutoff_frequency,
    spectral_problem,
)

SpectralMethod: TypeAlias = Literal["auto", "eigenvectors", "polynomial"]
#: The default of `largest_size` is this many times `detail_size`: two octaves.
BAND = 4.0
#: The largest number of entries in the matrix of modes: 0.8 GB.
LARGEST_BASIS = 100_000_000
#: A safety factor on the number of modes by Weyl's law, which neglects a term that grows with the length of the border.
_MARGIN = 1.15


@dataclass(frozen=True, eq=False)
class SpectralResult:
    """A filtered surface and how it was computed.

    Attributes:
        vertices: (n, 3) the new coordinates.
        route: the method that ran: "eigenvectors", "polynomial", "rational", or "none" if there was nothing to filter.
        error: a bound ("rational": in part an estimate) of the root mean square distance, over the surface, to the exact result,
            in mesh units. The error of the modes themselves, about 1e-9 of the mesh's size, is not included.
        detail_size: the wavelength at which the response cuts off, in mesh units; infinity if nothing was filtered.
        modes: the number of computed modes, without the constant mode of each component.
        degree: the degree of the polynomial or rational function; 0 with "eigenvectors".
        explanation: why nothing was filtered; empty if something was.
    """

    vertices: Floats
    route: str
    error: float
    detail_size: float
    modes: int = 0
    degree: int = 0
    explanation: str = ""


def spectral_filter(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    response: ResponseName = "low_pass",
    detail_size: float | None = None,
    largest_size: float | None = None,
    modes: int | None = None,
    gain: float | None = None,
    order: int = DEFAULT_ORDER,
    method: SpectralMethod = "auto",
    operator: SurfaceOperatorName = "auto",
    tolerance: float = 1e-5,
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> SpectralResult:
    """Multiplies every mode of the coordinates by the response at its frequency: p' = V F(sqrt(kappa)) V^T M p [vallet2008].

    V are the modes of the Laplace-Beltrami operator, S v = kappa M v, and 2 pi / sqrt(kappa) their wavelengths. Every component
    has its own modes and is filtered separately; its centroid stays. Borders have natural (Neumann) conditions: their vertices
    move like all other vertices, and a border becomes as smooth as the surface.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles; at least one unless there are no vertices.
        response: "low_pass" removes waves shorter than `detail_size`. "band_pass" keeps only waves from `detail_size` to
            `largest_size`, and the centroids. "enhance" multiplies the waves of this band by `gain` and keeps all others.
        detail_size: the wavelength, in mesh units, at which a low pass halves the amplitude, or the shortest wavelength of a
            band. Larger smooths more, and enhances larger details.
        largest_size: the longest wavelength of a band, in mesh units; None for four times the shortest. "low_pass" ignores it.
        modes: in place of `detail_size`, the number of lowest modes of all components together that are used. Shorter waves are
            dropped (brick wall), but kept by "enhance". The constant mode of each component holds its centroid: it is kept, not
            counted. Fewer modes smooth more; a component that keeps no other mode shrinks to its centroid. Without
            eigenvectors, the response cuts off at the wavelength of the last mode by Weyl's law, kappa = 4 pi (modes + 1) / area.
        gain: the factor of the band; None for 2 with "enhance" and 1 with "band_pass". Larger exaggerates, below 1 attenuates.
        order: the order of the smooth responses, see `low_pass`. Larger cuts off more sharply.
        method: "eigenvectors" computes modes. "polynomial" applies a polynomial of the Laplacian, or a rational function if the
            polynomial's degree would exceed 1,000. "auto" computes modes only if `modes` is given and they fit into 0.8 GB.
        operator: "cotangent", "robust" or "auto", see `surface_laplacian`.
        tolerance: the aim for the error, as a share of the root mean square distance of the surface from the centroids. Smaller
            takes longer.
        movable: (n,) bool, the vertices that may move; None for all. All vertices are filtered, then fixed vertices are restored,
            which may leave a step between fixed and moved vertices.
        progress: called with the share that is done; may raise to stop.

    Returns:
        The coordinates and how they were computed. Vertices that are not `movable` or have no mass keep every bit.

    Raises:
        FilterInputError: not a mesh, a point cloud, a parameter out of range, both or neither of `detail_size` and `modes`.
        ConvergenceError: modes or solutions of linear systems cannot be computed.
    """
    points, triangles = check_mesh(vertices, faces)
    check_choice("response", response, ResponseName)
    check_choice("method", method, SpectralMethod)
    check_positive("tolerance", tolerance)
    mesh = normalised_mesh(points, triangles, movable)
    if (detail_size is None) == (modes is None):
        raise FilterInputError("give either detail_size, a wavelength, or modes, a number of modes")
    if modes is not None:
        check_whole_number("modes", modes, least=1)
    if largest_size is not None and response != "low_pass":
        cutoff_frequency("largest_size", largest_size)
    if detail_size is not None:  # checks the parameters before any work, even if there is nothing to filter
        _response(response, detail_size, largest_size, gain, order)
    if len(triangles) == 0 and len(points):
        raise FilterInputError("the mesh has no triangles: spectral filters need a surface; triangulate a point cloud first")
    if len(points) == 0 or not (mesh.movable_vertices is None or mesh.movable_vertices.any()):
        return _untouched(points, "no vertex may move")
    problem = spectral_problem(mesh.points, mesh.cells, operator=operator, numbers=mesh.order)
    if len(problem.mass) == 0:
        return _untouched(points, "no triangle has an area")
    scale = mesh.scale

    def transfer(size: float) -> Response:
        in_mesh_units = _response(response, size / scale, largest_size, gain, order)
        return replace(in_mesh_units, cutoffs=tuple(cutoff / scale for cutoff in in_mesh_units.cutoffs))

    size = math.inf if detail_size is None else detail_size * scale
    centred, centroids = about_centroids(mesh.points[problem.vertices], problem)
    if method == "eigenvectors" or (method == "auto" and modes is not None and _basis_fits(problem, modes)):
        if modes is not None:
            done = _brick_wall(problem, centred, int(modes), None if response == "low_pass" else transfer, progress)
        else:
            done = _by_modes(problem, centred, size, transfer(size), tolerance, progress)
    else:
        if modes is not None:  # Weyl's law: a surface of area A has A omega^2 / 4 pi modes up to omega
            size = math.sqrt(math.pi * float(problem.mass.sum()) / (modes + 1))
        free = filter_without_eigenvectors(problem, centred, transfer(size), tolerance=tolerance, progress=progress)
        done = SpectralResult(free.values, free.route, free.error, size, degree=free.degree)
    after = mesh.points.copy()
    after[problem.vertices] = done.vertices + centroids
    if mesh.movable is not None:
        after[~mesh.movable] = mesh.points[~mesh.movable]
    progress(1.0)
    return replace(done, vertices=mesh.restored(after), error=done.error / scale, detail_size=done.detail_size / scale)


def _response(name: ResponseName, detail_size: float, largest_size: float | None, gain: float | None, order: int) -> Response:
    if name == "low_pass":
        return RESPONSES[name](detail_size, order=order)
    options: dict[str, float] = {} if gain is None else {"gain": gain}
    return RESPONSES[name](detail_size, BAND * detail_size if largest_size is None else largest_size, order=order, **options)


def _untouched(points: Floats, why: str) -> SpectralResult:
    return SpectralResult(points.copy(), "none", 0.0, math.inf, explanation=f"nothing was filtered: {why}")


def _basis_fits(problem: SpectralProblem, count: int) -> bool:
    return min(count, problem.n_waves) * len(problem.mass) <= LARGEST_BASIS


def _by_modes(
    problem: SpectralProblem, values: Floats, size: float, response: Response, tolerance: float, progress: Progress
) -> SpectralResult:
    """F(inf) v + V (F - F(inf)) V^T M v for (n, 3) values v of mean 0; V has all modes with |F - F(inf)| >= `tolerance`."""
    last, most = response.last_frequency(tolerance), problem.n_waves
    count = min(math.ceil(_MARGIN * float(problem.mass.sum()) * last**2 / (4.0 * math.pi)) + 10, most)  # by Weyl's law
    never_falling = rising(progress)
    while True:
        omega, shapes = _modes(problem, count, never_falling)
        if count == most or omega[-1] >= last:
            break
        count = min(count + count // 3 + 10, most)
    after, remainder = _combined(problem, values, shapes, response(omega), response.infinity)
    return SpectralResult(after, "eigenvectors", 0.0 if count == most else tolerance * remainder, size, count)


def _brick_wall(
    problem: SpectralProblem, values: Floats, count: int, band_of: Callable[[float], Response] | None, progress: Progress
) -> SpectralResult:
    """Keeps the `count` lowest modes of values with mean 0 on every component, and drops the remainder (all shorter waves).

    With `band_of`, which makes the response of a band from its shortest wavelength, a band ends with the last of these modes. The
    modes in the band are multiplied by the gain of the band, longer waves and the remainder by the response at infinity.
    """
    omega, shapes = _modes(problem, min(count, problem.n_waves), progress)
    size = 2.0 * math.pi / float(omega[-1]) if omega.any() else math.inf
    factors, at_infinity = np.ones_like(omega), 0.0
    if band_of is not None and size < math.inf:
        band = band_of(size)
        at_infinity = band.infinity
        # Below `cutoffs[0]` the two weighted low passes of a band cancel out; in the band only the last one is left.
        factors = np.where(omega >= band.cutoffs[0], at_infinity + band.weights[-1], at_infinity)
    after, _ = _combined(problem, values, shapes, factors, at_infinity)
    return SpectralResult(after, "eigenvectors", 0.0, size, len(omega))


def _modes(problem: SpectralProblem, count: int, progress: Progress) -> tuple[Floats, Floats]:
    """Returns the frequencies and modes without the constant mode of each component, which values of mean 0 do not contain."""
    if not _basis_fits(problem, count):
        raise FilterInputError(
            f"{count} modes of {len(problem.mass)} vertices take {8e-9 * count * len(problem.mass):.1f} GB: take the method "
            "'polynomial', a larger detail_size or fewer modes"
        )
    kappa, shapes = lowest_eigenpairs(problem, count, constants=False, progress=progress)
    return np.sqrt(np.maximum(kappa, 0.0)), shapes


def _combined(problem: SpectralProblem, values: Floats, shapes: Floats, factors: Floats, infinity: float) -> tuple[Floats, float]:
    """Multiplies the modes of the values by `factors`, the remainder by `infinity`; returns the sum and the remainder's RMS."""
    rest, after = values.copy(), np.zeros_like(values)
    for k in range(shapes.shape[1]):  # one by one, because the rounding of a matrix product may depend on the number of threads
        along = np.einsum("i,ij->j", problem.mass * shapes[:, k], values)
        part = shapes[:, k, None] * along
        rest -= part
        after += factors[k] * part
    return after + infinity * rest, math.sqrt(float(np.sum(problem.mass[:, None] * rest * rest) / problem.mass.sum()))

"""Detail enhancement: amplifies the relief of a band of wavelengths along the normals of the smooth base shape."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_finite, check_positive
from ..execution import Progress, ignore_progress, part_of
from ..geometry import face_areas, mean_edge_length, vertex_normals_by_area
from ..libraries import sparse
from ..mesh import Floats, Ints, NormalisedMesh, check_mesh, normalised_mesh
from ..neighbours import touching_balls
from ..operators import SurfaceOperatorName
from ..topology import border_vertices, edges
from .eigenvector_free import filter_without_eigenvectors
from .problem import Response, cutoff_frequency, low_pass, spectral_problem
from .spectral_filter import BAND
from .spectrum import spectrum

# The thickness is searched up to the longest wavelength, and farther only until the bound b of step 4 in `enhance_details` is
# this multiple of the displacement u: beyond it b tanh(u / b) is within 2.1 % of u.
_BOUND = 4.0
# In this search displacements below this share of the largest one count as this share.
_LEAST = 1e-3
# The tolerance of the low passes, small because their results are subtracted from each other.
_TOLERANCE = 1e-12
#: The shortest wavelength of relief, in mean edges: shorter waves have too few vertices.
SHORTEST = 5.0
#: A band of the spectrum counts as signal if its energy is at least this many times the noise energy.
SIGNAL = 4.0
# The noise is measured between these wavelengths, in mean edges; regular triangles have no shorter waves.
_NOISE_FROM, _NOISE_TO = 2.5, 4.0
# Lanczos steps of `spectrum`: enough for wavelengths of up to ten edges; longer ones are not needed.
_STEPS = 300


@dataclass(frozen=True, eq=False)
class EnhancedDetails:
    """A surface with enhanced relief; lengths in mesh units."""

    vertices: Floats  # (n, 3)
    detail_size: float = 0.0  # the shortest wavelength of the relief; 0 if no vertex has a mass
    largest_size: float = 0.0  # the longest wavelength of the relief
    height: float = 0.0  # the root mean square height of the input's relief over the vertices
    largest_displacement: float = 0.0


def enhance_details(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    gain: float = 2.0,
    detail_size: float | None = None,
    largest_size: float | None = None,
    most: float = 0.05,
    operator: SurfaceOperatorName = "auto",
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> EnhancedDetails:
    """Amplifies the relief of a surface along the normals of its base shape: p' = p + f((gain - 1) s h) n, h the relief's height.

    1. The low pass K_short halves the shortest waves of the band, K_long the longest. n are normals of the base shape K_long p.
    2. h = r - K_long r with r = n . (K_short p - K_long p). Without the term - K_long r a bulge would grow as a whole.
    3. s = e(x) e(y) e(z) with e(t) = 3 t^2 - 2 t^3 on [0, 1]. x is the distance from the border, y the smaller of the
       thicknesses of the base shape inside and outside (`touching_balls`), both divided by the longest wavelength. z is the area
       of the faces around a vertex in the base shape, divided by that in K_short p. So borders stay, thin parts change little.
       Parts much thinner than the longest wavelength do not change: their base shape is a line or a point.
    4. f(u) = b tanh(u / b) with b = `most` times the thickness. So the two sides of a gap do not meet.

    Waves outside the band, including noise, stay as they are.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles; at least one unless there are no vertices.
        gain: the factor on the height of the relief, at least 0. Above 1 amplifies the relief, below 1 flattens it.
        detail_size: the shortest wavelength of the relief, in mesh units; None: `shortest_relief` measures it. Choose it above
            the wavelengths of the noise.
        largest_size: the longest wavelength, above `detail_size`; None: four times `detail_size`.
        most: the largest displacement as a share of the thickness, above 0. Larger lets thin parts change more; from 1/2 on
            opposite sides may meet.
        operator: "cotangent", "robust" or "auto", see `surface_laplacian`.
        movable: (n,) bool, which vertices may move, None for all.
        progress: called with the share that is done; may raise to stop.

    Returns:
        The coordinates and the band. Fixed vertices keep every bit: border vertices, vertices without a face of positive area,
        and vertices that are not `movable`.

    Raises:
        FilterInputError: not a mesh, a parameter out of range, a point cloud.
        ConvergenceError: the linear systems of a low pass cannot be solved.
    """
    points, triangles = check_mesh(vertices, faces)
    factor = check_finite("gain", gain, least=0.0) - 1.0
    check_positive("most", most)
    for name, size in (("detail_size", detail_size), ("largest_size", largest_size)):
        if size is not None:
            cutoff_frequency(name, size)
    if len(triangles) == 0 and len(points):
        raise FilterInputError("the mesh has no triangles: only a surface has relief; triangulate a point cloud first")
    mesh = normalised_mesh(points, triangles, movable)
    problem = spectral_problem(mesh.points, mesh.cells, operator=operator, numbers=mesh.order)
    if len(problem.mass) == 0:
        return EnhancedDetails(points.copy())
    shortest, longest = _band(mesh, detail_size, largest_size)
    short, long = low_pass(shortest), low_pass(longest)
    surface_points = mesh.points[problem.vertices]

    def low_passed(values: Floats, low: Response, start: float, stop: float) -> Floats:
        part = part_of(progress, start, stop)
        return filter_without_eigenvectors(problem, values, low, tolerance=_TOLERANCE, progress=part).values

    fine, shape = low_passed(surface_points, short, 0.0, 0.2), low_passed(surface_points, long, 0.2, 0.4)
    relief, base = mesh.points.copy(), mesh.points.copy()
    relief[problem.vertices], base[problem.vertices] = fine, shape
    normals = vertex_normals_by_area(base, mesh.cells)[problem.vertices]
    before, kept = (np.bincount(mesh.cells.ravel(), np.repeat(face_areas(p, mesh.cells), 3), len(p)) for p in (relief, base))
    heights = ((fine - shape) * normals).sum(axis=1)
    heights -= low_passed(heights, long, 0.4, 0.6)
    eased = _away_from_borders(mesh, longest) * _eased(kept / np.maximum(before, 1e-300))
    unbounded = factor * heights * eased[problem.vertices]
    highest = float(np.abs(unbounded).max())
    if mesh.movable is not None:
        unbounded[~mesh.movable[problem.vertices]] = 0.0
    displacement = unbounded
    if highest > 0.0:
        largest = np.maximum(_BOUND / (2.0 * most) * np.maximum(np.abs(unbounded), _LEAST * highest), 0.5 * longest)
        inside = touching_balls(shape, normals, largest=largest, progress=part_of(progress, 0.6, 0.8))
        outside = touching_balls(shape, -normals, largest=largest, progress=part_of(progress, 0.8, 1.0))
        thickness = 2.0 * np.minimum(inside, outside)
        displacement = most * thickness * np.tanh(_eased(thickness / longest) * unbounded / (most * thickness))
    after = mesh.points.copy()
    after[problem.vertices] += displacement[:, None] * normals
    progress(1.0)
    return EnhancedDetails(
        mesh.restored(after),
        shortest / mesh.scale,
        longest / mesh.scale,
        float(np.sqrt((heights**2).mean())) / mesh.scale,
        float(np.abs(displacement).max()) / mesh.scale,
    )


def _band(mesh: NormalisedMesh, detail_size: float | None, largest_size: float | None) -> tuple[float, float]:
    if detail_size is None:
        shortest = shortest_relief(mesh.points, mesh.cells, mean_edge_length(mesh.points, mesh.cells))
    else:
        shortest = detail_size * mesh.scale
    longest = BAND * shortest if largest_size is None else largest_size * mesh.scale
    if not longest > shortest:
        raise FilterInputError(
            f"largest_size {largest_size} is not above detail_size {shortest / mesh.scale:.6g}: no wave is in between"
        )
    return shortest, longest


def _away_from_borders(mesh: NormalisedMesh, width: float) -> Floats:
    """(k,) factors from 0 at borders to 1 from `width` on: 3 x^2 - 2 x^3, x the distance along edges to a border over `width`."""
    border: Ints = np.flatnonzero(border_vertices(mesh.cells, len(mesh))).astype(np.int32)
    if len(border) == 0:
        return np.ones(len(mesh))
    ends = edges(mesh.cells)
    lengths = np.linalg.norm(mesh.points[ends[:, 0]] - mesh.points[ends[:, 1]], axis=1)
    graph = sparse.csr_array((np.maximum(lengths, 1e-300), (ends[:, 0], ends[:, 1])), shape=(len(mesh), len(mesh)))
    return _eased(sparse.csgraph.dijkstra(graph, directed=False, indices=border, min_only=True, limit=width) / width)


def _eased(x: Floats) -> Floats:
    share = np.minimum(x, 1.0)
    return np.asarray(share**2 * (3.0 - 2.0 * share))


def shortest_relief(vertices: Floats, faces: Ints, mean_edge: float) -> float:
    """Estimates the shortest wavelength of the relief from the spectrum of the surface, in mesh units.

    Noise that is independent at each vertex has the same energy in every mode. So its energy in a band of a third of an octave
    grows with the square of the frequency. The noise level is measured at wavelengths of 2.5 to 4 mean edges, which hold little
    besides noise. The result is a third of an octave above the shortest wavelength with at least `SIGNAL` times the noise energy
    in its band, and at least `SHORTEST` mean edges. At least one triangle must have an area.
    """
    # In mean edges, since the bands of a spectrum are at the same frequencies for every mesh.
    measured = spectrum(vertices / mean_edge, faces, modes=0, steps=_STEPS)
    edges = measured.band_edges
    wavelengths = 2.0 * np.pi / np.sqrt(edges[1:] * edges[:-1])
    energies, squares = measured.band_energies, wavelengths**-2.0
    noisy = (wavelengths > _NOISE_FROM) & (wavelengths < _NOISE_TO)
    level = energies[noisy].sum() / max(squares[noisy].sum(), 1e-300)
    signal = (wavelengths > _NOISE_FROM) & (energies > 0.0) & (energies >= SIGNAL * level * squares)
    shortest = SHORTEST
    if noisy.any() and signal.any():
        shortest = max(SHORTEST, 2.0 ** (1.0 / 3.0) * float(wavelengths[signal].min()))
    return shortest * mean_edge

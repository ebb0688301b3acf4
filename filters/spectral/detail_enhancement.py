"""Detail enhancement: relief of a band of wavelengths amplified along the normals of a shape that stays."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_finite, check_positive
from ..execution import Progress, ignore_progress, part_of
from ..geometry import mean_edge_length, vertex_normals_by_area
from ..libraries import sparse
from ..mesh import Floats, Ints, NormalisedMesh, check_mesh, normalised_mesh
from ..neighbours import touching_balls
from ..operators import SurfaceOperatorName
from ..topology import border_vertices, edges
from .eigenvector_free import filter_without_eigenvectors
from .problem import Response, cutoff_frequency, low_pass, spectral_problem
from .spectrum import spectrum

#: The largest thickness that is measured, in displacements: the bound takes 2 % there, 1 - tanh(x) / x for x = 1/4.
_FREE = 4.0
# Displacements count as at least this share of the largest one, so that no bound is 0.
_NONE = 1e-3
# Of the low passes, whose results are subtracted from each other.
_TOLERANCE = 1e-12
#: The longest wave of the relief in shortest ones: two octaves.
OCTAVES = 4.0
#: Waves shorter than this many mean edges are never relief: triangles do not show them.
SHORTEST = 5.0
#: A band whose energy is this many times that of noise is signal: three quarters of it are.
SIGNAL = 4.0
# The lengths of waves from which the noise is measured, in mean edges; regular triangles have no shorter ones.
_NOISE_FROM, _NOISE_TO = 2.5, 4.0
# Enough for bands of up to ten edges; the longer waves of the shape are not needed.
_STEPS = 300


@dataclass(frozen=True, eq=False)
class EnhancedDetails:
    """A surface with its relief enhanced, lengths in mesh units."""

    vertices: Floats  # (n, 3) the new coordinates
    detail_size: float = 0.0  # the shortest wave of the band; 0 where there is nothing to enhance
    largest_size: float = 0.0  # the longest
    height: float = 0.0  # the root mean square of the heights of the relief as it was, over the vertices
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
    """Moves vertices along the normals of the shape, p' = p + f((gain - 1) s h) n, by the heights h of the relief.

    1. K_d is the low pass that halves waves of length d, see `low_pass`. n are the normals of the shape K_long p.
    2. h = n . (K_short p - K_long p), less its own long waves: h - K_long h. Without them a bulge would grow as a whole.
    3. s = e(x) e(y), e(x) = 3 x^2 - 2 x^3 from 0 to 1: x the distance from open borders, y the thickness of the shape, both over
       the longest wave. So borders stay, and so do parts that are themselves no larger than relief, such as the knob of a bone.
    4. f(x) = b tanh(x / b), b a share of the thickness of the shape, inside or outside, whichever is less (`touching_balls`). So
       thin parts do not swell, and two sides of a gap do not meet.

    Waves longer than the band and shorter than it, noise too, stay as they are, and with gain 1 all do.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles; at least one unless there are no vertices.
        gain: how many times as high the relief becomes, from 0. Below 1 it is flattened.
        detail_size: the shortest wave of the relief, in mesh units; None for the one that `shortest_relief` measures. Choose it
            above the size of the noise.
        largest_size: the longest wave, above `detail_size`; None for four times as long.
        most: the largest displacement as a share of the thickness, above 0. Larger lets thin parts change more; at 1/2 two sides
            may meet.
        operator: "cotangent", "robust", or "auto": robust where the mesh is not manifold.
        movable: (n,) bool, which vertices may move, None for all.
        progress: called with the share that is done; may raise to stop.

    Returns:
        The coordinates and the band. Vertices that do not move keep every bit: those on borders, those of no face with an area,
        those not `movable`. Deterministic to the bit.

    Raises:
        FilterInputError: not a mesh, a parameter out of range, a point cloud.
    """
    points, triangles = check_mesh(vertices, faces)
    factor = check_finite("gain", gain, least=0.0) - 1.0
    check_positive("most", most)
    for name, size in (("detail_size", detail_size), ("largest_size", largest_size)):
        if size is not None:
            cutoff_frequency(name, size)
    if len(triangles) == 0 and len(points):
        raise FilterInputError("the mesh has no triangles: relief is that of a surface; triangulate a point cloud first")
    mesh = normalised_mesh(points, triangles, movable)
    if len(mesh) == 0:
        return EnhancedDetails(points.copy())
    problem = spectral_problem(mesh.points, mesh.cells, operator=operator)
    if len(problem.mass) == 0:
        return EnhancedDetails(points.copy())
    shortest, longest = _band(mesh, detail_size, largest_size)
    short, long = low_pass(shortest), low_pass(longest)
    here = mesh.points[problem.vertices]

    def passed(values: Floats, low: Response, start: float, stop: float) -> Floats:
        part = part_of(progress, start, stop)
        return filter_without_eigenvectors(problem, values, low, tolerance=_TOLERANCE, progress=part).values

    fine, shape = passed(here, short, 0.0, 0.2), passed(here, long, 0.2, 0.4)
    everywhere = mesh.points.copy()
    everywhere[problem.vertices] = shape
    normals = vertex_normals_by_area(everywhere, mesh.cells)[problem.vertices]
    heights = ((fine - shape) * normals).sum(axis=1)
    heights -= passed(heights, long, 0.4, 0.6)
    unbounded = factor * heights * _away_from_borders(mesh, longest)[problem.vertices]
    reach = float(np.abs(unbounded).max())
    if mesh.movable is not None:
        unbounded[~mesh.movable[problem.vertices]] = 0.0
    displacement = unbounded
    if reach > 0.0:
        largest = np.maximum(_FREE / (2.0 * most) * np.maximum(np.abs(unbounded), _NONE * reach), 0.5 * longest)
        inside = touching_balls(shape, normals, largest=largest, progress=part_of(progress, 0.6, 0.8))
        outside = touching_balls(shape, -normals, largest=largest, progress=part_of(progress, 0.8, 1.0))
        bound = most * 2.0 * np.minimum(inside, outside)
        displacement = bound * np.tanh(_eased(2.0 * inside / longest) * unbounded / bound)
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
    """The wavelengths between which relief lies, measured where no size is set, in the unit of the points."""
    if detail_size is None:
        shortest = shortest_relief(mesh.points, mesh.cells, mean_edge_length(mesh.points, mesh.cells))
    else:
        shortest = detail_size * mesh.scale
    longest = OCTAVES * shortest if largest_size is None else largest_size * mesh.scale
    if not longest > shortest:
        raise FilterInputError(
            f"largest_size {largest_size} is not above detail_size {shortest / mesh.scale:.6g}: no wave is in between"
        )
    return shortest, longest


def _away_from_borders(mesh: NormalisedMesh, width: float) -> Floats:
    """(k,) 3 x^2 - 2 x^3 of the distance from the nearest border vertex along edges, as a share x of the width, at most 1."""
    border: Ints = np.flatnonzero(border_vertices(mesh.cells, len(mesh))).astype(np.int32)
    if len(border) == 0:
        return np.ones(len(mesh))
    ends = edges(mesh.cells)
    lengths = np.linalg.norm(mesh.points[ends[:, 0]] - mesh.points[ends[:, 1]], axis=1)
    graph = sparse.csr_array((np.maximum(lengths, 1e-300), (ends[:, 0], ends[:, 1])), shape=(len(mesh), len(mesh)))
    distance = sparse.csgraph.dijkstra(graph, directed=False, indices=border, min_only=True, limit=width)
    return _eased(distance / width)


def _eased(x: Floats) -> Floats:
    """3 x^2 - 2 x^3, and 1 above 1."""
    share = np.minimum(x, 1.0)
    return np.asarray(share**2 * (3.0 - 2.0 * share))


def shortest_relief(vertices: Floats, faces: Ints, mean_edge: float) -> float:
    """The shortest waves of the relief in the spectrum of a surface, in mesh units.

    Noise that is independent at each vertex has the same energy in every mode, so that its energy in a band of a third of an
    octave grows with the square of the frequency. Its level is taken from waves of 2.5 to 4 mean edges, which show little else.
    The relief begins a third of an octave above the shortest band that has `SIGNAL` times as much energy as such noise would, at
    `SHORTEST` edges at least. At least one triangle must have an area.
    """
    # In mean edges, since the edges of bands are the same numbers for all meshes.
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

"""The spectrum of a shape: its energy against frequency, by modes and by Gauss quadrature."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..checks import ConvergenceError, FilterInputError, check_whole_number
from ..compilation import compiled, prange
from ..execution import Progress, ignore_progress, part_of, threads_for
from ..linear_solvers import CompressedRows
from ..mesh import Floats, check_mesh, normalised_mesh
from ..operators import SurfaceOperatorName
from .eigenpairs import lowest_eigenpairs
from .eigenvector_free import fused_row_product, symmetric_form
from .problem import SpectralProblem, about_centroids, check_size, spectral_problem

BANDS = 3  # per octave
#: Waves shorter than this share of the mean edge go into the last band: only slivers have such modes.
SHORTEST = 0.5
_SHARE_OF_MODES = 0.6  # of the progress
#: The largest total mass that is added at slivers, as a share of the area.
_ADDED = 1e-4
_FEWEST_STEPS, _MOST_STEPS = 100, 600  # the bounds of the automatic number of Lanczos steps


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Energy of the coordinates against frequency.

    The energy of a mode v_k is |<p, v_k>_M|^2 / area, in squared mesh units, summed over the coordinates p = x, y and z, with
    vertex areas M as weights. All energies add up to the mean squared distance from the centroids of the components.

    Attributes:
        frequencies: (k,) omega of the lowest modes, in radians per mesh unit, rising; the wavelength is 2 pi / omega. Modes that
            are constant on a component, of frequency 0, are left out.
        energies: (k,) their energies.
        band_edges: (b + 1,) the bounds of the bands, in radians per mesh unit: 2^(i / 3) for consecutive integers i.
        band_energies: (b,) the energy in each band, modes included; the last band includes all higher frequencies.
        energy: the energy of all frequencies together.
        area: the area of the surface, up to 0.01 % too large.
    """

    frequencies: Floats
    energies: Floats
    band_edges: Floats
    band_energies: Floats
    energy: float
    area: float

    @property
    def wavelengths(self) -> Floats:
        """(k,) the wavelengths of the modes, in mesh units."""
        return 2.0 * math.pi / self.frequencies


def spectrum(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    modes: int = 100,
    steps: int | None = None,
    operator: SurfaceOperatorName = "auto",
    progress: Progress = ignore_progress,
) -> Spectrum:
    """Measures the energy of a shape against frequency: the lowest modes one by one, all others by a quadrature.

    With the Dirichlet matrix S and masses M, a Lanczos process of M^-1/2 S M^-1/2 starts with the coordinates minus their parts
    in the computed modes. Its tridiagonal matrix gives the nodes and weights of Gauss quadrature for the energy against kappa =
    omega^2 [golub1969]. Slivers and tiny triangles have modes of far higher frequency than any wave of the surface, and these
    modes would take many more steps. So the vertices of these triangles get additional mass, in all up to 0.01 % of the area.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles, at least one.
        modes: the number of modes to compute [vallet2008], without the constant mode of each component. More modes resolve single
            modes up to a higher frequency, and take longer.
        steps: the steps of the Lanczos process; None for enough to resolve the bands above the last mode, at most 600. More steps
            separate neighbouring bands more sharply, especially at low frequencies, and take longer.
        operator: "cotangent", "robust", or "auto": "robust" if the mesh has non-manifold edges or slivers.
        progress: called with the share that is done; may raise to stop.

    Returns:
        The spectrum, deterministic to the bit.

    Raises:
        FilterInputError: not a mesh, no triangle with an area, a parameter out of range.
        ConvergenceError: eigenvalues cannot be computed.
    """
    points, triangles = check_mesh(vertices, faces)
    check_whole_number("modes", modes, least=0)
    if steps is not None:
        check_whole_number("steps", steps, least=1)
    if len(triangles) == 0:
        raise FilterInputError("the mesh has no triangles: only a surface has a spectrum")
    mesh = normalised_mesh(points, triangles)
    unit = 1.0 / mesh.scale
    check_size(unit)
    plain = spectral_problem(mesh.points, mesh.cells, operator=operator, numbers=mesh.order)
    if len(plain.mass) == 0:
        raise FilterInputError("no triangle of the mesh has an area: only a surface has a spectrum")
    problem = without_stiffest(plain)
    remainder, _ = about_centroids(mesh.points[problem.vertices], problem)
    area = float(problem.mass.sum())
    total = float(np.sum(problem.mass[:, None] * remainder * remainder)) / area
    count = min(int(modes), problem.n_waves)
    kappa, shapes = np.empty(0), np.empty((len(remainder), 0))
    if count:
        kappa, shapes = lowest_eigenpairs(problem, count, constants=False, progress=part_of(progress, 0.0, _SHARE_OF_MODES))
    energies = np.empty(len(kappa))
    for k in range(len(kappa)):  # one by one, because the rounding of a matrix product may depend on the number of threads
        along = np.einsum("i,ij->j", problem.mass * shapes[:, k], remainder)
        energies[k] = float(along @ along) / area
        remainder -= shapes[:, k, None] * along
    step_count = enough_steps(problem, float(kappa[-1]) if len(kappa) else 0.0) if steps is None else int(steps)
    share = _SHARE_OF_MODES if count else 0.0
    nodes, weights = energy_quadrature(problem, remainder, step_count, progress=part_of(progress, share, 1.0))
    # The edge length of equilateral triangles with this total area, two triangles for each vertex.
    mean_edge = math.sqrt(2.0 / math.sqrt(3.0) * area / len(problem.mass))
    edges, bands = _bands(
        np.sqrt(np.concatenate([kappa, nodes])) / unit,
        np.concatenate([energies, weights / area]) * unit**2,
        highest=2.0 * math.pi / (SHORTEST * mean_edge * unit),
    )
    progress(1.0)
    return Spectrum(np.sqrt(kappa) / unit, energies * unit**2, edges, bands, total * unit**2, area * unit**2)


def _bands(frequencies: Floats, energies: Floats, *, highest: float) -> tuple[Floats, Floats]:
    """Returns the band edges from the lowest to the highest frequency with energy, and the energy in each band."""
    counted = (frequencies > 0.0) & (energies > 0.0)
    if not counted.any():
        return np.empty(0), np.empty(0)
    omega, energy = np.minimum(frequencies[counted], highest), energies[counted]
    # Tiny energies at very low frequencies are rounding errors; they would add many empty bands.
    lowest = omega[energy > 1e-14 * energy.sum()].min()
    place = np.floor(BANDS * np.log2(np.maximum(omega, lowest))).astype(np.int64)
    first, last = int(place.min()), int(place.max())
    return 2.0 ** (np.arange(first, last + 2) / BANDS), np.asarray(
        np.bincount(place - first, energy, last - first + 1), dtype=np.float64
    )


def without_stiffest(problem: SpectralProblem) -> SpectralProblem:
    """Adds mass where S_ii / M_i is highest, see `spectrum`; twice the highest S_ii / M_i then estimates the largest kappa."""
    diagonal, mass = problem.dirichlet.diagonal(), problem.mass
    stiffest = np.argsort(-(diagonal / mass), kind="stable")
    # With the mass S_ii / bound, vertex i has the ratio `bound`. For bounds[k] the k + 1 stiffest gain `_ADDED` of all mass.
    bounds = np.cumsum(diagonal[stiffest]) / (_ADDED * mass.sum() + np.cumsum(mass[stiffest]))
    # bounds[k] rises as long as the next ratio is above it. At the maximum no vertex after the first k + 1 has a ratio above it.
    bound = float(bounds.max(initial=0.0))
    if not bound > 0.0:
        return problem
    return replace(problem, mass=np.maximum(problem.mass, diagonal / bound))


def enough_steps(problem: SpectralProblem, kappa: float) -> int:
    """Returns the steps that resolve thirds of octaves above kappa: nodes lie sqrt(highest) pi / (2 steps) apart in omega."""
    highest = 2.0 * float(np.max(problem.dirichlet.diagonal() / problem.mass))
    steps = 12.0 * math.sqrt(highest / kappa) if kappa > 0.0 else math.inf
    return int(min(max(steps, _FEWEST_STEPS), _MOST_STEPS))


#: Rows in a block. Each block has a sum of its own, so that the number of threads changes no bit.
_BLOCK = 4096
#: A pass is so short that threads pay only on meshes this many times as large as for other kernels.
_SHORT_PASSES = 10
#: Largest number of iterations for an eigenvalue; two are usual.
_MOST_ITERATIONS = 60


def energy_quadrature(problem: SpectralProblem, values: Floats, steps: int, *, progress: Progress) -> tuple[Floats, Floats]:
    """Returns nodes kappa and weights w such that sum w f(kappa) = sum over columns of <v, f(M^-1 S) v>_M.

    The Lanczos process of D = M^-1/2 S M^-1/2 from M^1/2 v gives a tridiagonal matrix, whose eigenvalues are the nodes. The
    quadrature is exact for polynomials f of degree 2 steps - 1. The vectors are not reorthogonalised: rounding then repeats nodes
    and splits their weight, which does not change the energy of a band.

    Each of the three columns has its own nodes; a column of zeros has none.
    """
    matrix = CompressedRows.of(symmetric_form(problem.dirichlet, problem.mass))
    now = np.sqrt(problem.mass)[:, None] * values
    norms = np.sqrt(np.einsum("ij,ij->j", now, now))
    if not norms.any():
        return np.empty(0), np.empty(0)
    now /= np.where(norms > 0.0, norms, 1.0)
    steps = min(steps, len(now))
    diagonal, beside = np.zeros((steps, 3)), np.zeros((steps, 3))
    before, length = np.zeros_like(now), np.zeros(3)
    sums = np.empty((-(-len(now) // _BLOCK), 3))
    with threads_for(len(now) // _SHORT_PASSES):
        for step in range(steps):
            _apply(matrix, now, length, before, sums)
            diagonal[step] = sums.sum(axis=0)
            _subtract(now, diagonal[step], before, sums)
            beside[step] = length = np.sqrt(sums.sum(axis=0))
            before /= np.where(length > 0.0, length, 1.0)
            before, now = now, before
            progress((step + 1) / steps)
    nodes, weights = [], []
    for column in np.flatnonzero(norms):
        # Where the Krylov space is exhausted, the next off-diagonal entry is pure rounding.
        ends = np.flatnonzero(beside[:, column] <= 1e-14 * np.abs(diagonal[:, column]).max())
        size = int(ends[0]) + 1 if len(ends) else steps
        kappa, first = diagonal[:size, column].copy(), np.zeros(size)
        first[0] = 1.0
        if not _iterated(kappa, np.append(beside[: size - 1, column], 0.0), first):
            raise ConvergenceError(f"the nodes of a quadrature of {size} steps do not converge")
        nodes.append(np.maximum(kappa, 0.0))
        weights.append((norms[column] * first) ** 2)
    return np.concatenate(nodes), np.concatenate(weights)


@compiled(parallel=True, fastmath={"contract"})
def _apply(matrix: CompressedRows, now: Floats, length: Floats, before: Floats, sums: Floats) -> None:
    """Computes `before` = D `now` - `length` `before` in place; `sums` gets, per block, the products of `now` and the result."""
    a, b, c = length
    for block in prange(sums.shape[0]):
        p = q = r = 0.0
        for row in range(block * _BLOCK, min((block + 1) * _BLOCK, now.shape[0])):
            i = np.uint64(row)
            x, y, z = fused_row_product(matrix, i, now)
            x, y, z = x - a * before[i, 0], y - b * before[i, 1], z - c * before[i, 2]
            before[i, 0], before[i, 1], before[i, 2] = x, y, z
            p += x * now[i, 0]
            q += y * now[i, 1]
            r += z * now[i, 2]
        sums[block, 0], sums[block, 1], sums[block, 2] = p, q, r


@compiled(parallel=True, fastmath={"contract"})
def _subtract(now: Floats, factors: Floats, after: Floats, sums: Floats) -> None:
    """Computes `after` -= `factors` `now` in place; `sums` gets, per block, the squared norms of the new `after`."""
    a, b, c = factors
    for block in prange(sums.shape[0]):
        p = q = r = 0.0
        for row in range(block * _BLOCK, min((block + 1) * _BLOCK, now.shape[0])):
            i = np.uint64(row)
            x, y, z = after[i, 0] - a * now[i, 0], after[i, 1] - b * now[i, 1], after[i, 2] - c * now[i, 2]
            after[i, 0], after[i, 1], after[i, 2] = x, y, z
            p += x * x
            q += y * y
            r += z * z
        sums[block, 0], sums[block, 1], sums[block, 2] = p, q, r


@compiled(nogil=True)
def _iterated(diagonal: Floats, beside: Floats, first: Floats) -> bool:
    """Replaces the diagonal of a symmetric tridiagonal matrix by its eigenvalues; returns whether all have converged.

    `beside` holds the off-diagonal entries, then a 0. Only the first entry of each eigenvector is computed: `first` comes in as
    (1, 0, ...) and receives these entries.
    """
    n, eps = diagonal.shape[0], 2.2e-16
    for low in range(n):
        for iteration in range(_MOST_ITERATIONS + 1):
            high = low
            while high < n - 1 and abs(beside[high]) > eps * (abs(diagonal[high]) + abs(diagonal[high + 1])):
                high += 1
            if high == low:
                break
            if iteration == _MOST_ITERATIONS:
                return False
            g = (diagonal[low + 1] - diagonal[low]) / (2.0 * beside[low])
            g = diagonal[high] - diagonal[low] + beside[low] / (g + math.copysign(math.hypot(g, 1.0), g))
            sine = cosine = 1.0
            shift = 0.0
            for i in range(high - 1, low - 1, -1):
                f, b = sine * beside[i], cosine * beside[i]
                r = math.hypot(f, g)
                beside[i + 1] = r
                if r == 0.0:
                    diagonal[i + 1] -= shift
                    break
                sine, cosine = f / r, g / r
                g = diagonal[i + 1] - shift
                r = (diagonal[i] - g) * sine + 2.0 * cosine * b
                shift = sine * r
                diagonal[i + 1] = g + shift
                g = cosine * r - b
                f = first[i + 1]
                first[i + 1] = sine * first[i] + cosine * f
                first[i] = cosine * first[i] - sine * f
            else:
                diagonal[low] -= shift
                beside[low] = g
            beside[high] = 0.0
    return True

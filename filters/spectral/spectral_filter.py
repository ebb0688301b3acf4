"""Spectral filtering of a surface: by its modes or without them, whichever is cheaper."""

import math
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..diffusion.frame import enter, leave, ordered_frame
from ..errors import FilterInputError
from ..mesh import Floats, check_mesh, check_movable
from ..progress import Progress, ignore_progress
from .eigenpairs import lowest_eigenpairs
from .eigenvector_free import filter_without_eigenvectors
from .problem import SpectralOperator, SpectralProblem, spectral_problem
from .responses import DEFAULT_ORDER, RESPONSE_NAMES, RESPONSES, Response, ResponseName

SpectralMethod: TypeAlias = Literal["auto", "eigenvectors", "polynomial"]
SPECTRAL_METHODS: tuple[SpectralMethod, ...] = get_args(SpectralMethod)

#: the longest wave of a band where none is given, in detail sizes: two octaves
BAND = 4.0
#: numbers that the modes may take up before "auto" does without them: 0.8 GB
_LARGEST_BASIS = 100_000_000
#: modes more than the wavelength asks for by Weyl's law, which holds up to a term that the border decides on
_MARGIN = 1.15


@dataclass(frozen=True, eq=False)
class SpectralResult:
    """A filtered surface and how it came about.

    Attributes:
        vertices: (n, 3) the new coordinates.
        route: what ran: "eigenvectors", "polynomial", "rational", or "none" where there was nothing to filter.
        explanation: a sentence about the route and why it was taken.
        error: a bound of the root mean square distance, over the surface, to what the response would give if it were computed
            exactly, in mesh units. That of the modes themselves, about 1e-9 of the size, is not counted.
        detail_size: the wavelength at which the response cuts off, in mesh units; infinity where no mode has one.
        modes: how many modes were computed, 0 for none.
        degree: of the polynomial or rational function, 0 for modes.
    """

    vertices: Floats
    route: str
    explanation: str
    error: float
    detail_size: float
    modes: int = 0
    degree: int = 0


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
    operator: SpectralOperator = "auto",
    tolerance: float = 1e-5,
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> SpectralResult:
    """Multiplies every frequency of the coordinates by F(omega): p' = V F(sqrt(kappa)) V^T M p [vallet2008].

    V are the modes of the Laplace-Beltrami operator, S v = kappa M v, and 2 pi / sqrt(kappa) their wavelengths. Components have
    modes of their own, so they are filtered one by one; their centroids stay. Borders are natural, as if nothing were beyond
    them: no vertex there is held, and a border gets as smooth as the surface.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles; at least one unless there are no vertices.
        response: "low_pass" removes waves shorter than `detail_size`; "band_pass" keeps those from `detail_size` to
            `largest_size` alone, about the centroids; "enhance" multiplies these by `gain` and keeps all others.
        detail_size: the wavelength, in mesh units, at which a low pass halves the amplitude, or the shortest of a band. Larger is
            smoother, and enhances larger details.
        largest_size: the longest wave of a band, in mesh units; None for four times the shortest. Not used by "low_pass".
        modes: in place of `detail_size`, a number of modes over all components, the constant ones included: a brick wall after
            the last of them. Fewer are smoother. Without eigenvectors, the smooth response for the wavelength that Weyl's law,
            kappa = 4 pi modes / area, gives this mode.
        gain: of the band, None for 2 with "enhance" and 1 with "band_pass". Larger exaggerates, below 1 attenuates.
        order: of the smooth responses, see `low_pass`. Larger cuts off more sharply.
        method: "eigenvectors" computes modes, "polynomial" does without them, and takes a rational function where that is
            cheaper, "auto" computes modes only where their number is given and they fit into 0.8 GB.
        operator: "cotangent", "robust", or "auto": robust where the mesh is not manifold.
        tolerance: of the error, as a share of the root mean square distance of the surface from the centroids. Smaller takes
            longer.
        movable: (n,) bool, which vertices may move, None for all. All vertices are filtered, and the others then put back, so
            that a step may be left where they meet.
        progress: told the share that is done; may raise to stop.

    Returns:
        The coordinates and how they came about. Vertices that do not move keep every bit: those that no face with an area uses,
        and those not `movable`. Deterministic to the bit.

    Raises:
        FilterInputError: not a mesh, a parameter out of range, a point cloud.
        ConvergenceError: modes cannot be computed.
    """
    points, triangles = check_mesh(vertices, faces)
    _check_choice("response", response, RESPONSE_NAMES)
    _check_choice("method", method, SPECTRAL_METHODS)
    if not (math.isfinite(tolerance) and tolerance > 0.0):
        raise FilterInputError(f"tolerance {tolerance} is not finite and above 0")
    moves = check_movable(movable, len(points))
    if (detail_size is None) == (modes is None):
        raise FilterInputError("give either detail_size, a wavelength, or modes, their number")
    if modes is not None and (modes != int(modes) or modes < 1):
        raise FilterInputError(f"modes is {modes}: it is a whole number of at least 1")
    if largest_size is not None and response != "low_pass" and not (math.isfinite(largest_size) and largest_size > 0.0):
        raise FilterInputError(f"largest_size {largest_size} is not finite and above 0: it is a wavelength in mesh units")
    if detail_size is not None:  # before any work, and also where there is nothing to filter
        _response(response, detail_size, largest_size, gain, order)
    if len(triangles) == 0 and len(points):
        raise FilterInputError("the mesh has no triangles: a spectral filter is one of surfaces; triangulate a point cloud first")
    if not moves.any() or len(points) == 0:
        return _untouched(points, "no vertex may move")
    used, inverse = np.unique(triangles, return_inverse=True)
    gathered = points[used]
    frame = ordered_frame(gathered, None)
    start = enter(gathered, frame)
    problem = spectral_problem(start, inverse.reshape(-1, 3).astype(np.int32), operator=operator)
    if len(problem.mass) == 0:
        return _untouched(points, "no triangle has an area")
    wanted = _Wanted(
        response,
        None if detail_size is None else detail_size * frame.scale,
        None if largest_size is None else largest_size * frame.scale,
        gain,
        order,
        tolerance,
    )
    by_modes = method == "eigenvectors" or (method == "auto" and modes is not None and _fits(problem, modes))
    centred, centroids = _about_centroids(start[problem.vertices], problem)
    if by_modes:
        found = _by_modes(problem, centred, wanted, modes, progress)
    else:
        found = _without_modes(problem, centred, wanted, modes, progress)
    after = start.copy()
    after[problem.vertices] = found.vertices + centroids
    after[~moves[used]] = start[~moves[used]]
    result = points.copy()
    result[used] = leave(gathered, start, after, frame)
    progress(1.0)
    length = found.detail_size / frame.scale
    told = found.explanation.format(detail_size=length)
    return replace(found, vertices=result, explanation=told, error=found.error / frame.scale, detail_size=length)


@dataclass(frozen=True)
class _Wanted:
    """What is asked for, lengths in the unit of the frame."""

    name: ResponseName
    detail_size: float | None
    largest_size: float | None
    gain: float | None
    order: int
    tolerance: float

    def response(self, detail_size: float) -> Response:
        return _response(self.name, detail_size, self.largest_size, self.gain, self.order)


def _response(name: ResponseName, detail_size: float, largest_size: float | None, gain: float | None, order: int) -> Response:
    options: dict[str, float] = {} if name == "low_pass" or gain is None else {"gain": gain}
    if name == "low_pass":
        return RESPONSES[name](detail_size, order=order)
    return RESPONSES[name](detail_size, BAND * detail_size if largest_size is None else largest_size, order=order, **options)


def _by_modes(problem: SpectralProblem, values: Floats, wanted: _Wanted, modes: int | None, progress: Progress) -> SpectralResult:
    """V F V^T M p, with a brick wall after so many modes, or with as many modes as the smooth response takes."""
    if modes is not None:
        count = min(modes, len(problem.mass))
        _check_fits(problem, count)
        kappa, shapes = lowest_eigenpairs(problem, count, progress=progress)
        omega = _frequencies(kappa, problem)
        detail_size = 2.0 * math.pi / omega[-1] if omega[-1] > 0.0 else math.inf
        response = wanted.response(detail_size if math.isfinite(detail_size) else 1.0)
        longest = 0.0 if wanted.name == "low_pass" else 2.0 * math.pi / response.cutoffs[0]
        # The gain of a band is the weight of the profile at its short end.
        inside = response.infinity + response.weights[-1]
        factors = np.where(omega * longest >= 2.0 * math.pi, inside, response.infinity) if longest else np.ones_like(omega)
        after, _ = _combined(problem, values, shapes, factors, response.infinity)
        said = f"a brick wall after {count} modes, the shortest of wavelength {{detail_size:.4g}}, by eigenvectors"
        return SpectralResult(after, "eigenvectors", said, 0.0, detail_size, count)
    assert wanted.detail_size is not None
    response = wanted.response(wanted.detail_size)
    last = response.last_frequency(wanted.tolerance)
    area = float(problem.mass.sum())
    count = min(math.ceil(_MARGIN * area * last**2 / (4.0 * math.pi)) + problem.n_components + 10, len(problem.mass))
    while True:
        _check_fits(problem, count)
        kappa, shapes = lowest_eigenpairs(problem, count, progress=progress)
        omega = _frequencies(kappa, problem)
        if count == len(problem.mass) or omega[-1] >= last:
            break
        count = min(count + count // 3 + 10, len(problem.mass))
    after, rest = _combined(problem, values, shapes, response(omega), response.infinity)
    error = 0.0 if count == len(problem.mass) else wanted.tolerance * rest
    said = f"a smooth response that halves waves of {{detail_size:.4g}}, by the {count} modes that it reaches"
    return SpectralResult(after, "eigenvectors", said, error, wanted.detail_size, count)


def _without_modes(
    problem: SpectralProblem, values: Floats, wanted: _Wanted, modes: int | None, progress: Progress
) -> SpectralResult:
    """The smooth response as a function of the operator."""
    area = float(problem.mass.sum())
    detail_size = wanted.detail_size if modes is None else math.sqrt(math.pi * area / modes)
    assert detail_size is not None
    after, error, route = filter_without_eigenvectors(
        problem, values, wanted.response(detail_size), tolerance=wanted.tolerance, progress=progress
    )
    said = f"a smooth response that cuts off at waves of {{detail_size:.4g}}, without eigenvectors: {route}"
    if modes is not None:
        said += f"; {modes} modes reach this wavelength by Weyl's law"
    return SpectralResult(after, route.name, said, error, detail_size, degree=route.degree)


def _combined(problem: SpectralProblem, values: Floats, shapes: Floats, factors: Floats, infinity: float) -> tuple[Floats, float]:
    """The values with their modes multiplied, what is no mode times `infinity`, and the root mean square of that remainder."""
    rest, after = values.copy(), np.zeros_like(values)
    for k in range(shapes.shape[1]):  # one by one: a product of matrices may round differently with the number of threads
        along = np.einsum("i,ij->j", problem.mass * shapes[:, k], values)
        part = shapes[:, k, None] * along
        rest -= part
        after += factors[k] * part
    return after + infinity * rest, math.sqrt(float(np.sum(problem.mass[:, None] * rest * rest) / problem.mass.sum()))


def _about_centroids(values: Floats, problem: SpectralProblem) -> tuple[Floats, Floats]:
    """The values about the centroid of each component, which no filter moves, and these centroids, a row a vertex."""
    parts, mass = problem.components, problem.mass
    weight = np.bincount(parts, mass)
    means = np.stack([np.bincount(parts, mass * values[:, c]) / weight for c in range(3)], axis=1)
    return values - means[parts], means[parts]


def _frequencies(kappa: Floats, problem: SpectralProblem) -> Floats:
    """The frequency of each mode, 0 for the first ones, which are constant on the components, whatever they were rounded to."""
    omega = np.sqrt(np.maximum(kappa, 0.0))
    omega[: problem.n_components] = 0.0
    return np.asarray(omega)


def _fits(problem: SpectralProblem, modes: int) -> bool:
    return min(modes, len(problem.mass)) * len(problem.mass) <= _LARGEST_BASIS


def _check_fits(problem: SpectralProblem, count: int) -> None:
    if not _fits(problem, count):
        raise FilterInputError(
            f"{count} modes of {len(problem.mass)} vertices take {8e-9 * count * len(problem.mass):.1f} GB: take the method "
            "'polynomial', which needs none, a larger detail_size or fewer modes"
        )


def _untouched(points: Floats, why: str) -> SpectralResult:
    return SpectralResult(points.copy(), "none", f"nothing was filtered: {why}", 0.0, math.inf)


def _check_choice(name: str, value: object, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise FilterInputError(f"{name} {value!r} is not one of {', '.join(map(repr, allowed))}")

"""Anisotropic diffusion of vertex scalars and colours: smooths values and keeps abrupt changes, called edges [perona1990]."""

import math
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, UnstableStepError, check_choice, check_positive, check_whole_number
from ..compilation import compiled, prange
from ..execution import Progress, ignore_progress, threads_for
from ..mesh import Bools, Floats, Ints, check_mesh, check_movable
from ..robust import KERNEL_CODES, SIGMA_IN_DEVIATIONS, kernel_weight, robust_deviation
from ..topology import OneRings, one_rings

#: The M-estimators with a finite weight at 0. Their weights divided by the weight at 0 are edge-stopping functions g [black1998].
EdgeStop: TypeAlias = Literal["lorentzian", "gaussian", "tukey", "huber", "hampel", "truncated_l2", "l2"]
EDGE_STOPS: tuple[EdgeStop, ...] = get_args(EdgeStop)

#: The automatic contrast in standard deviations of the differences; 1 if not listed. The largest x g(x) is then at one standard
#: deviation [black1998]. "truncated_l2" has a larger contrast: otherwise a third of the noise would count as edges.
_CONTRAST_IN_DEVIATIONS: dict[EdgeStop, float] = {
    "gaussian": math.sqrt(2.0),
    "tukey": math.sqrt(5.0),
    "truncated_l2": SIGMA_IN_DEVIATIONS["truncated_l2"],
}


def perona_malik(
    values: ArrayLike,
    faces: ArrayLike,
    *,
    edge_stop: EdgeStop = "lorentzian",
    contrast: float | None = None,
    step: float | None = None,
    iterations: int = 10,
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Diffuses values I: repeats I_s <- I_s + step sum_p g(|I_p - I_s|) (I_p - I_s), p the neighbours of s, for all s at once.

    g(x) is 1 / (1 + x^2 / c^2) ("lorentzian") or exp(-x^2 / c^2) ("gaussian") as in [perona1990], c the contrast. Other
    M-estimators stop diffusion entirely above c ("tukey", "truncated_l2") or 4 c ("hampel"), partly ("huber"), or not ("l2"). For
    vectors such as colours |I_p - I_s| is the norm: all channels stop at the same edges. Distances of vertices do not matter.

    The sum over all vertices stays the same if all may change. No value leaves the range of the input.

    Args:
        values: (n,) or (n, k) finite values, one or k per vertex.
        faces: (m, 3) triangles.
        edge_stop: the edge-stopping function g.
        contrast: c, in the unit of the values: differences above c are edges. Larger blurs more edges. None: m, times 1.41
            for "gaussian", 2.24 for "tukey", 2.80 for "truncated_l2". Here m is 1.4826 times the median |I_p - I_s| over the
            edges of the mesh; if the median is 0, m is the mean |I_p - I_s|.
        step: above 0 and at most 1 / d, d the largest number of neighbours of a vertex. Larger is smoother. None: 1 / d.
        iterations: number of steps. More are smoother.
        movable: (n,) bool, the vertices whose values may change, None for all. Fixed values still flow to their neighbours.
        progress: called after every step.

    Returns:
        float64 of the shape of `values`. Fixed values, and values of vertices without a face, keep every bit. Deterministic for
        any number of threads.

    Raises:
        FilterInputError: shapes that do not fit, values that are not finite, a parameter out of range.
        UnstableStepError: the step is longer than 1 / d; the error names 1 / d.
    """
    unchanged = np.asarray(values, dtype=np.float64)
    start, triangles = _checked(unchanged, np.asarray(faces))
    moves = check_movable(movable, len(start))
    check_choice("edge_stop", edge_stop, EDGE_STOPS)
    steps = check_whole_number("iterations", iterations, least=0)
    rings = one_rings(triangles, len(start))
    longest = _longest_step(rings)
    step = longest if step is None else step
    if check_positive("step", step) > longest:
        raise UnstableStepError(
            f"with step {step:g} values may leave their range: take at most {{}}, one over the largest number of "
            "neighbours of a vertex",
            largest_stable=longest,
        )
    if contrast is None:
        contrast = automatic_contrast(start, rings, edge_stop)
    else:
        check_positive("contrast", contrast, note="; None takes it from the values")
    now, following = start.copy(), start.copy()
    sigma = math.sqrt(0.5) if edge_stop == "lorentzian" else 1.0  # the Lorentzian has sigma^2 = c^2 / 2; here c is 1
    with threads_for(len(start)):
        for iteration in range(steps if contrast > 0.0 else 0):
            _diffuse(now, following, moves, rings, KERNEL_CODES[edge_stop], sigma, contrast, step)
            now, following = following, now
            progress((iteration + 1) / steps)
    # Rounding may put a value one bit outside the range.
    result = np.clip(now, start.min(axis=0), start.max(axis=0)) if len(start) else now
    # Unchanged values are taken from the input, since adding 0 turns -0.0 into 0.0.
    return np.asarray(np.where(result == start, start, result).reshape(unchanged.shape))


def longest_step(faces: ArrayLike) -> float:
    """The longest step of `perona_malik` on (m, 3) triangles."""
    triangles = np.asarray(faces)
    return _longest_step(one_rings(triangles, int(triangles.max()) + 1)) if triangles.size else 1.0


def automatic_contrast(values: Floats, rings: OneRings, edge_stop: EdgeStop) -> float:
    """The default contrast of `perona_malik` for (n, k) values; 0 if all neighbours have equal values."""
    owners = np.repeat(np.arange(len(values)), np.diff(rings.offsets))
    once = owners < rings.neighbours
    differences = np.abs(values[rings.neighbours[once]] - values[owners[once]])
    largest = float(differences.max(initial=0.0))
    if largest == 0.0:
        return 0.0
    differences = np.linalg.norm(differences / largest, axis=1)  # squares of very large values would overflow
    return _CONTRAST_IN_DEVIATIONS.get(edge_stop, 1.0) * robust_deviation(differences) * largest


def _longest_step(rings: OneRings) -> float:
    return 1.0 / max(1, int(np.diff(rings.offsets).max(initial=0)))


def _checked(values: Floats, faces: Ints) -> tuple[Floats, Ints]:
    if values.ndim not in (1, 2):
        raise FilterInputError(f"values must have the shape (n,) or (n, k), got {values.shape}")
    if faces.dtype.kind in "iu" and faces.size and not 0 <= faces.min() <= faces.max() < len(values):
        raise FilterInputError(
            f"faces name the vertices {faces.min()} to {faces.max()}, but the number of values is {len(values)}"
        )
    columns = np.ascontiguousarray(values.reshape(len(values), -1 if values.size else 1))
    if (bad := ~np.isfinite(columns).all(axis=1)).any():
        raise FilterInputError(
            f"{int(bad.sum())} of {len(values)} vertices have a value that is not finite, the first is vertex "
            f"{int(bad.argmax())}: give these vertices values first"
        )
    return columns, check_mesh(np.zeros((len(values), 3)), faces)[1]


@compiled(parallel=True)
def _diffuse(
    values: Floats, out: Floats, moves: Bools, rings: OneRings, code: int, sigma: float, contrast: float, step: float
) -> None:
    offsets, neighbours, _ = rings
    at_zero = kernel_weight(code, 0.0, sigma)
    for i in prange(values.shape[0]):
        if moves[i]:
            for c in range(values.shape[1]):
                out[i, c] = values[i, c]
            for k in range(offsets[i], offsets[i + 1]):
                j = neighbours[k]
                squared = 0.0
                for c in range(values.shape[1]):
                    difference = (values[j, c] - values[i, c]) / contrast
                    squared += difference * difference
                share = step * kernel_weight(code, math.sqrt(squared), sigma) / at_zero
                for c in range(values.shape[1]):
                    out[i, c] += share * (values[j, c] - values[i, c])

"""Taubin's lambda|mu smoothing: a step that smooths, then a slightly longer one back, so that large shapes keep their size."""

import math
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..checks import FilterInputError, UnstableStepError, check_choice, check_positive
from ..execution import Progress, ignore_progress
from ..mesh import Floats, Whole, check_mesh
from ..topology import BorderPolicy, border_edges, edge_face_counts
from .explicit import explicit_surface

#: The operators whose spectrum lies in [-2, 0]: lambda, mu and the pass band are defined for these.
TaubinOperator: TypeAlias = Literal["uniform", "inverse_length", "cotangent"]


def taubin_fairing(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    operator: TaubinOperator = "uniform",
    step: float = 0.5,
    mu: float = -0.53,
    pass_band: float | None = None,
    iterations: int = 10,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    whole: Whole | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Take p to (1 + mu L)(1 + step L) p, `iterations` times: a low-pass filter that does not shrink [taubin1995].

    A mode of eigenvalue -k of L is multiplied by `transfer_function` (k): by about 1 below the pass band
    k_PB = 1/step + 1/mu, and by less and less above. With the operator "uniform" it is MeshLab's Taubin Smooth, except on
    borders, where MeshLab averages a vertex in with its two border neighbours and so goes two thirds of the way of "along",
    and at non-manifold edges, whose ends MeshLab counts once a face.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        operator: the Laplace operator L; weights that depend on lengths or angles are computed anew for every step.
        step: lambda, above 0. Larger is smoother.
        mu: the step back, below -step. Nearer to -step narrows the pass band, and so is smoother.
        pass_band: k_PB, above 0 and below 1/step; if given, mu = 1 / (k_PB - 1/step). Smaller is smoother; 0.01 to 0.1 is usual.
        iterations: number of pairs of steps. More damp more, above the pass band alone; the time is proportional.
        border: what the vertices on borders do; see `BorderPolicy`.
        movable: (n,) bool, which vertices may move, None for all. The others stay, and count as neighbours of those that do.
        whole: the mesh that this is a part of, None if it is all. Vertices with twice `iterations` rings of faces around them
            in the part, in the order of the whole, get the bits of the whole. For "uniform" and "cotangent".
        progress: called after every pair of steps.

    Returns:
        (n, 3) float64. Vertices that do not move keep every bit: those that no face uses, that are not `movable`, or on a fixed
        border. Deterministic, for any number of threads.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
        UnstableStepError: (1 - step k)(1 - mu k) is below -1 for the largest eigenvalue that such a mesh can have, so that
            the finest detail would grow. The error names the largest stable step for the same mu / step.
    """
    check_choice("operator", operator, TaubinOperator)
    try:
        mu = checked_mu(step, mu, pass_band, largest_eigenvalue=2.0)
    except UnstableStepError:
        if operator != "uniform" or whole is not None or not (edge_face_counts(check_mesh(vertices, faces)[1])[1] == 2).all():
            raise
        # Where every edge has two triangles the operator is a mean over triangles, whose eigenvalues are up to 3/2.
        mu = checked_mu(step, mu, pass_band, largest_eigenvalue=1.5)
    surface = explicit_surface(
        vertices, faces, operator=operator, border=border, movable=movable, iterations=iterations, steps=2, whole=whole
    )

    def back_and_forth(_: int, now: Floats, free: Floats) -> tuple[Floats, Floats]:
        surface.advance(now, free, step)
        surface.advance(free, now, mu)
        return now, free

    return surface.iterated(back_and_forth, iterations, progress)


def meshlab_taubin_smooth(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    step: float = 0.5,
    mu: float = -0.53,
    iterations: int = 10,
    whole: Whole | None = None,
) -> Floats:
    """MeshLab's Taubin Smooth but for rounding, where no edge has more than two faces [taubin1995].

    Its factors are of single precision. A vertex with b border edges is averaged with itself and its b neighbours along these,
    and so goes b / (b + 1) of the way to their mean.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        step: lambda. Larger is smoother.
        mu: the step back.
        iterations: number of pairs of steps.
        whole: see `taubin_fairing`.

    Returns:
        (n, 3) float64.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    surface = explicit_surface(
        vertices, faces, operator="uniform", border="along", movable=None, iterations=iterations, steps=2, whole=whole
    )
    border, count = np.unique(border_edges(surface.mesh.numbered_cells()), return_counts=True)
    share = (count / (count + 1.0))[:, None]

    def back_and_forth(_: int, now: Floats, free: Floats) -> tuple[Floats, Floats]:
        for factor in (step, mu):
            surface.advance(now, free, float(np.float32(factor)))
            free[border] = now[border] + share * (free[border] - now[border])
            now, free = free, now
        return now, free

    return surface.iterated(back_and_forth, iterations, ignore_progress)


def checked_mu(step: float, mu: float, pass_band: float | None, *, largest_eigenvalue: float) -> float:
    """The mu of a stable pair of steps: that of the pass band, or `mu` without one. No eigenvalue of -L is above the largest.

    Raises:
        FilterInputError: a parameter out of range.
        UnstableStepError: the finest detail would grow.
    """
    check_positive("step", step)
    if pass_band is not None:
        mu = mu_of_pass_band(pass_band, step)
    if not (math.isfinite(mu) and mu < -step):
        raise FilterInputError(
            f"mu {mu} is not below -step, {-step}: the step back must be the longer one, for example {-1.06 * step:g}"
        )
    largest = largest_stable_step(mu / step, largest_eigenvalue)
    if step > largest:
        raise UnstableStepError(
            f"step {step:g} with mu {mu:g} makes the finest detail grow: take a step of at most {largest:.6g} and mu in "
            "proportion",
            largest_stable=largest,
        )
    return mu


def transfer_function(k: ArrayLike, *, step: float, mu: float, iterations: int) -> NDArray[np.float64]:
    """((1 - step k)(1 - mu k))^iterations: the factor of a mode of eigenvalue -k [taubin1995].

    Args:
        k: any shape; from 0 to 2 for a normalised operator.
        step: lambda.
        mu: the step back; 0 gives the response of `iterations` explicit steps.
        iterations: number of pairs of steps.
    """
    values = np.asarray(k, dtype=np.float64)
    return ((1.0 - step * values) * (1.0 - mu * values)) ** iterations


def mu_of_pass_band(pass_band: float, step: float) -> float:
    """The mu = 1 / (k_PB - 1/step) for which `transfer_function` is 1 at k = k_PB.

    Raises:
        FilterInputError: the pass band is not above 0 and below 1/step.
    """
    if not 0.0 < pass_band < 1.0 / step:
        raise FilterInputError(f"pass_band {pass_band} is not above 0 and below 1/step = {1.0 / step:g}; 0.01 to 0.1 is usual")
    return 1.0 / (pass_band - 1.0 / step)


def largest_stable_step(ratio: float, largest_eigenvalue: float) -> float:
    """The step above which (1 - step k)(1 - mu k) is below -1 at the largest eigenvalue k of -L, for mu = ratio * step.

    With r = -ratio and x = step k it is the positive root of r x^2 + (1 - r) x - 2 = 0, over k.
    """
    r = -ratio
    return (r - 1.0 + math.sqrt((r - 1.0) ** 2 + 8.0 * r)) / (2.0 * r * largest_eigenvalue)

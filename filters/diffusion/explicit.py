"""Explicit Euler steps of the diffusion equation: every vertex a little way towards its neighbours, all at once."""

import math

from numpy.typing import ArrayLike

from ..checks import FilterInputError, UnstableStepError
from ..execution import Progress, ignore_progress
from ..mesh import Floats, Whole
from ..operators import OperatorName
from ..topology import BorderPolicy
from .explicit_steps import NORMALISED_OPERATORS, explicit_surface
from .stencil import UpdateRule

__all__ = ["UpdateRule", "explicit_smoothing"]


def explicit_smoothing(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    operator: OperatorName = "uniform",
    step: float = 0.5,
    iterations: int = 10,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    update: UpdateRule = "euler",
    whole: Whole | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """p_i <- p_i + step (L p)_i for all vertices at once, again and again [taubin1995, desbrun1999].

    Each step damps the mode of eigenvalue -k of L by the factor 1 - step k. Closed surfaces shrink; see `taubin_fairing` for one
    that does not, and `implicit_fairing` for strong smoothing in one step of any length.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles. With none of them and the operator "robust" the vertices are a point cloud.
        operator: the Laplace operator L; see `build_laplacian`. Weights that depend on lengths or angles are computed anew for
            every step; those of "robust" once, for the input.
        step: larger is smoother. For "uniform", "inverse_length" and "cotangent" a share, above 0 and at most 1. For the others
            a time in squared mesh units, stable up to 2 / rho with rho the largest eigenvalue of -L. Of rho an upper bound is
            used, so that a step that passes is stable: for "scale_dependent" and "robust" Gershgorin's, for "laplace_beltrami"
            the better of that and the largest eigenvalue of a single triangle [irons1971], exact on equilateral triangles.
        iterations: number of steps. More are smoother; the time is proportional.
        border: what the vertices on borders do; see `BorderPolicy`.
        movable: (n,) bool, which vertices may move, None for all. The others stay where they are and are seen by those that do.
        update: "euler", the equation above; or "meshlab", the rule of MeshLab's Laplacian Smooth, for "uniform" and
            "cotangent": p_i <- (p_i + sum_j w_ij p_j) / (1 + sum_j w_ij) with w_ij the number of faces at the edge, or the sum
            of the cotangents there, and along borders (2 p_i + p_prev + p_next) / 4. That is an Euler step of
            sum_j w_ij / (1 + sum_j w_ij), different at every vertex; `step` is not used, and negative cotangents are not tamed.
        whole: the mesh that this is a part of, None if it is all. Vertices with `iterations` rings of faces around them in the
            part, in the order of the whole, get the bits of the whole. For "uniform" and "cotangent".
        progress: called after every step.

    Returns:
        (n, 3) float64. Vertices that do not move keep every bit: those that no face uses, that are not `movable`, or on a fixed
        border. Deterministic, for any number of threads.

    Raises:
        FilterInputError: not a mesh, a parameter out of range, too few points in a cloud.
        UnstableStepError: the step is longer than the largest stable one, which the error names; that of the input, or
            of what the steps so far have made of it.
    """
    normalised = operator in NORMALISED_OPERATORS
    if update == "euler" and not (math.isfinite(step) and step > 0.0 and (step <= 1.0 or not normalised)):
        allowed = "above 0 and at most 1" if normalised else "finite and above 0"
        raise FilterInputError(f"step {step} is not {allowed}, as the operator {operator!r} takes it")
    surface = explicit_surface(
        vertices,
        faces,
        operator=operator,
        border=border,
        movable=movable,
        iterations=iterations,
        steps=1,
        update=update,
        whole=whole,
    )
    scale = surface.mesh.scale
    scaled = step if normalised else step * scale * scale

    def euler(done: int, now: Floats, free: Floats) -> tuple[Floats, Floats]:
        bound = surface.advance(now, free, scaled)
        if not normalised and scaled * bound > 2.0:
            raise _unstable(operator, step, 2.0 / bound / scale / scale, done)
        return free, now

    return surface.iterated(euler, iterations, progress)


def _unstable(operator: OperatorName, step: float, largest: float, done: int) -> UnstableStepError:
    when = "" if done == 0 else f" after {done} iterations, which have shrunk the surface"
    return UnstableStepError(
        f"step {step:g} is longer than the largest stable one of operator {operator!r} on this mesh, {largest:g} squared mesh "
        f"units{when}: take that or less (the shortest edges and the thinnest triangles decide; repairing them helps), or "
        "implicit fairing, which is stable for any step",
        largest_stable=largest,
    )

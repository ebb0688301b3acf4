"""Explicit smoothing: Euler steps of the diffusion equation."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, UnstableStepError, check_positive, check_whole_number
from ..execution import Progress, ignore_progress, threads_for
from ..mesh import Floats, NormalisedMesh, Whole, check_mesh, normalised_mesh, worth_reordering
from ..operators import OperatorName
from ..topology import BorderPolicy, stars
from .stencil import Advance, UpdateRule, explicit_stencil

#: operators without a unit, whose spectrum lies in [-2, 0] on every mesh
NORMALISED_OPERATORS: tuple[OperatorName, ...] = ("uniform", "inverse_length", "cotangent")
#: A step takes as long for a vertex as so many sums of vectors; one of "uniform" is one.
_WORK = 4
#: One iteration: takes its number from 0 on, the points, and an array to write to in which vertices that do not move have their
#: places; returns the points after it and the array that is free now.
Iteration: TypeAlias = Callable[[int, Floats, Floats], tuple[Floats, Floats]]


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
        movable: (n,) bool, which vertices may move, None for all. The others stay, and count as neighbours of those that do.
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
    if update == "euler":
        check_positive("step", step, most=1.0 if normalised else None, note=f", as the operator {operator!r} takes it")
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


class ExplicitSurface(NamedTuple):
    """A mesh on which explicit iterations are made."""

    mesh: NormalisedMesh  # normalised, its points in the order of the stencil
    advance: Advance  # writes p + step (L p) for the vertices that move
    work: int  # how long that takes for a vertex, in the sums of vectors that `threads_for` is made for

    def iterated(self, iteration: Iteration, iterations: int, progress: Progress) -> Floats:
        """(n, 3) the vertices after as many iterations.

        Raises:
            FilterInputError: a coordinate is no longer finite.
        """
        now = self.mesh.new_points()
        free = now.copy()
        with threads_for(self.work * len(now)):
            for done in range(iterations):
                now, free = iteration(done, now, free)
                progress((done + 1) / iterations)
        del free  # the memory of a result
        result = self.mesh.restored(now)
        del now
        if not np.isfinite(result).all():
            raise FilterInputError(
                f"the vertices left all bounds within {iterations} iterations; take fewer, or update='euler', which cannot"
            )
        return result


def explicit_surface(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    operator: OperatorName,
    border: BorderPolicy,
    movable: ArrayLike | None,
    iterations: int,
    steps: int,
    update: UpdateRule = "euler",
    whole: Whole | None = None,
) -> ExplicitSurface:
    """Prepares a mesh for explicit iterations: checked, normalised, and reordered where that is faster.

    Arguments and errors as of `explicit_smoothing`; `steps` is how often each iteration applies L.
    """
    points, triangles = check_mesh(vertices, faces)
    count = check_whole_number("iterations", iterations, least=0)
    mesh = normalised_mesh(points, triangles, movable, whole)
    # "robust" is assembled by a library, in the order of the faces; cotangents lose twice as much to a bad order as means do.
    sweeps = steps * count * (2 if operator in ("cotangent", "laplace_beltrami") else 1)
    reorder = operator != "robust" and worth_reordering(mesh.cells, len(mesh), sweeps)
    if reorder:
        mesh = mesh.by_place()
    star = stars(mesh.numbered_cells(), len(mesh), names=mesh.order)
    with threads_for(len(mesh)):
        advance = explicit_stencil(mesh, star, operator, border=border, update=update)
    return ExplicitSurface(mesh, advance, 1 if operator == "uniform" else _WORK)

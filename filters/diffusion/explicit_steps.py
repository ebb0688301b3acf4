"""Explicit iterations on a mesh: an update rule says what one of them does, and this module repeats it."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_whole_number
from ..execution import Progress, threads_for
from ..mesh import Floats, NormalisedMesh, Whole, check_mesh, normalised_mesh, worth_reordering
from ..operators import OperatorName
from ..topology import BorderPolicy, stars
from .stencil import Advance, UpdateRule, explicit_stencil

#: operators without a unit, whose spectrum lies in [-2, 0] on every mesh
NORMALISED_OPERATORS: tuple[OperatorName, ...] = ("uniform", "inverse_length", "cotangent")

#: One iteration: takes its number from 0 on, the points, and an array to write to in which vertices that do not move have their
#: places; returns the points after it and the array that is free now.
Iteration: TypeAlias = Callable[[int, Floats, Floats], tuple[Floats, Floats]]


class ExplicitSurface(NamedTuple):
    """A mesh on which explicit iterations are made.

    Attributes:
        mesh: normalised, its points in the order of the stencil.
        advance: writes p + step (L p) for the vertices that move.
    """

    mesh: NormalisedMesh
    advance: Advance

    def iterated(self, iteration: Iteration, iterations: int, progress: Progress) -> Floats:
        """(n, 3) the vertices after as many iterations.

        Raises:
            FilterInputError: a coordinate is no longer finite.
        """
        now = self.mesh.new_points()
        free = now.copy()
        with threads_for(len(now)):
            for done in range(iterations):
                now, free = iteration(done, now, free)
                progress((done + 1) / iterations)
        del free
        result = self.mesh.restored(now)
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
    """Makes a mesh ready for explicit iterations: checked, normalised and, where that pays, in an order good for the memory.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles; none for a point cloud, with the operator "robust".
        operator: L; see `build_laplacian`.
        border: what the vertices on borders do; see `BorderPolicy`.
        movable: (n,) bool, which vertices may move, None for all.
        iterations: how many there will be, at least 0.
        steps: how often each of them applies L.
        update: the rule of a step; see `explicit_smoothing`.
        whole: the mesh that this is a part of; None if it is all.

    Raises:
        FilterInputError: not a mesh, a parameter out of range.
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
    return ExplicitSurface(mesh, advance)

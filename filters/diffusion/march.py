"""Repeating explicit steps, on a mesh of any size and place and with its vertices in any order."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, UnstableStepError
from ..execution import Progress, threads_for
from ..mesh import Floats, Ints, check_movable, enter, leave, ordered_frame, worth_reordering
from ..operators import OperatorName
from ..topology import BorderPolicy, stars
from .stencil import UpdateRule, explicit_stencil

#: operators without a unit, whose spectrum lies in [-2, 0] on every mesh
NORMALISED_OPERATORS: tuple[OperatorName, ...] = ("uniform", "inverse_length", "cotangent")


def march(
    vertices: Floats,
    faces: Ints,
    *,
    steps: Sequence[float],
    iterations: int,
    operator: OperatorName,
    border: BorderPolicy,
    movable: ArrayLike | None,
    update: UpdateRule,
    progress: Progress,
) -> Floats:
    """The vertices after `iterations` times all the `steps`; see `explicit_smoothing` for the rest.

    It works on the mesh moved to the origin, scaled by a power of two and, if large, renumbered, and adds the
    displacement to the input: a vertex that does not move keeps every bit, and one far from the origin loses none to the sums.
    """
    moves = None if movable is None else check_movable(movable, len(vertices))
    if not isinstance(iterations, int | np.integer) or iterations < 0:
        raise FilterInputError(f"iterations is {iterations}: it is a whole number of at least 0")
    # "robust" is assembled by a library, in the order of the faces; cotangents lose twice as much to a bad order as means do.
    sweeps = len(steps) * iterations * (2 if operator in ("cotangent", "laplace_beltrami") else 1)
    reorder = operator != "robust" and worth_reordering(faces, len(vertices), sweeps)
    star = stars(faces, len(vertices), reorder=reorder)
    frame = ordered_frame(vertices, star.order)
    start, scale = enter(vertices, frame), frame.scale
    if star.order is not None and moves is not None:
        moves = moves[star.order]
    with threads_for(len(vertices)):
        advance = explicit_stencil(start, faces, star, operator, border=border, movable=moves, update=update)
        now, following = start.copy(), start.copy()
        for iteration in range(iterations):
            for step in steps:
                scaled_step = step if operator in NORMALISED_OPERATORS else step * scale * scale
                bound = advance(now, following, scaled_step)
                if operator not in NORMALISED_OPERATORS and scaled_step * bound > 2.0:
                    raise _unstable(operator, step, 2.0 / bound / scale / scale, iteration)
                now, following = following, now
            progress((iteration + 1) / iterations)
    result = leave(vertices, start, now, frame)
    if not np.isfinite(result).all():
        raise FilterInputError(
            f"the vertices left all bounds within {iterations} iterations; take fewer, or update='euler', which cannot"
        )
    return result


def _unstable(operator: OperatorName, step: float, largest: float, iteration: int) -> UnstableStepError:
    when = "" if iteration == 0 else f" after {iteration} iterations, which have shrunk the surface"
    return UnstableStepError(
        f"step {step:g} is longer than the largest stable one of operator {operator!r} on this mesh, {largest:g} squared mesh "
        f"units{when}: take that or less (the shortest edges and the thinnest triangles decide; repairing them helps), or "
        "implicit fairing, which is stable for any step",
        largest_stable=largest,
    )

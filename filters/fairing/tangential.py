"""Tangential smoothing: better triangles on the same surface, with the edges that are there or with flipped ones."""

import math

from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..execution import Progress, ignore_progress
from ..geometry import mean_edge_length
from ..mesh import Floats, Ints, check_mesh, check_movable, enter, leave, ordered_frame
from ..topology import border_vertices, referenced_vertices
from .edge_flips import flip_towards_quality, proper_faces
from .tangential_steps import KeptSurface, TangentialEnergy


def tangential_smoothing(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    weight: float = 0.1,
    iterations: int = 5,
    max_deviation: float | None = None,
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Moves vertices along the surface towards min sum_i A_i (|L_uniform p'_i - L_cotan p_i|^2 + w |p'_i - p_i|^2) [nealen2006].

    L_cotan p has no tangential part, so what is left of L_uniform p' at the minimum has none either: every vertex sits in the
    middle of its neighbours as seen along the normal, which is where triangles are good. The energy alone also moves vertices
    off the surface. Here each iteration solves for it, takes the part of the step within the tangent plane, and puts the vertex
    on the nearest point of the input surface, walked to from where it was. A step that would fold a triangle over, or bring the
    middle of a triangle or of an edge further from the input than allowed, is halved, and not made after four times.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        weight: w, above 0, without unit. Larger moves less in each iteration.
        iterations: number of steps. More are better triangles, up to a point.
        max_deviation: how far the middles of triangles and edges may get from the input, in mesh units: larger allows better
            triangles on curved parts and across edges. None: 5 % of the mean edge. Vertices themselves stay on the input.
        movable: (n,) bool, which vertices may move, None for all. Border vertices stay, whatever is said.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (n, 3) float64. Vertices that do not move keep every bit.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
        ConvergenceError: the equations cannot be solved.
    """
    return _improved(vertices, faces, weight, iterations, max_deviation, movable, False, progress)[0]


def improve_triangles(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    weight: float = 0.1,
    iterations: int = 5,
    max_deviation: float | None = None,
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> tuple[Floats, Ints]:
    """Tangential smoothing with edge flips before each of its steps [nealen2006, lawson1977, botsch2004remeshing].

    Where the triangles are halves of quadrilaterals cut along the wrong diagonal, as those of range maps, moving vertices does
    not help and flipping edges does; and flips leave vertices off the middle of their new neighbours, to which smoothing then
    moves them. See `tangential_smoothing` and `flip_edges` for what each of the two keeps to: the input surface, its border, and
    the orientation and topology of its triangles.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        weight: w, above 0, without unit. Larger moves less in each iteration.
        iterations: how often edges are flipped and a step is made. More are better triangles, up to a point.
        max_deviation: how far the middles of triangles and edges may get from the input, in mesh units: larger allows better
            triangles on curved parts and across edges. None: 5 % of the mean edge. Vertices themselves stay on the input.
        movable: (n,) bool, which vertices may move, None for all. An edge is flipped only between four vertices that may.
            Border vertices stay, whatever is said.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (n, 3) float64, and the (m, 3) triangles: those that no flip has changed are in their rows as they were.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
        ConvergenceError: the equations cannot be solved.
    """
    return _improved(vertices, faces, weight, iterations, max_deviation, movable, True, progress)


def _improved(
    vertices: ArrayLike,
    faces: ArrayLike,
    weight: float,
    iterations: int,
    max_deviation: float | None,
    movable: ArrayLike | None,
    flips: bool,
    progress: Progress,
) -> tuple[Floats, Ints]:
    points, triangles = check_mesh(vertices, faces)
    if not (math.isfinite(weight) and weight > 0.0):
        raise FilterInputError(f"weight {weight} is not finite and above 0")
    if iterations != int(iterations) or iterations < 0:
        raise FilterInputError(f"iterations is {iterations}: it is a whole number of at least 0")
    if max_deviation is not None and not max_deviation >= 0.0:
        raise FilterInputError(f"max_deviation {max_deviation} is not at least 0")
    used = referenced_vertices(triangles, len(points))
    may = check_movable(movable, len(points)) & used
    moves = may & ~border_vertices(triangles, len(points))
    if not (may if flips else moves).any():
        return points.copy(), triangles.copy()
    frame = ordered_frame(points[used], None)
    start = enter(points, frame)
    edge = mean_edge_length(start, triangles)
    allowed = 0.05 * edge if max_deviation is None else max_deviation * frame.scale
    proper = proper_faces(triangles)
    surface = KeptSurface(start, triangles[proper], allowed)
    energy: TangentialEnergy | None = None
    now = start
    for iteration in range(iterations):

        def partial(share: float, done: int = iteration) -> None:
            progress((done + 0.8 * share) / iterations)

        if flips:
            surface.faces, flipped = flip_towards_quality(now, surface.faces, may, surface.walkable, surface.at, allowed)
            if flipped:
                energy = None
        if moves.any():
            energy = energy or TangentialEnergy(now, surface.faces, moves, weight)
            now = surface.moved(now, energy.step(now, partial), moves)
        progress((iteration + 1) / iterations)
    found = triangles.copy()
    found[proper] = surface.faces
    return leave(points, start, now, frame), found

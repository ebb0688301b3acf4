"""Tangential smoothing: better triangles on the same surface, with or without edge flips."""

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_finite, check_positive, check_whole_number
from ..execution import Progress, ignore_progress
from ..geometry import mean_edge_length
from ..mesh import Floats, Ints, check_mesh, normalised_mesh
from ..topology import border_vertices, proper_faces
from .edge_flips import flip_towards_quality
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

    L_cotan p has no tangential part, so L_uniform p' has none at the minimum either: projected along the normal, every vertex is
    the centroid of its neighbours, where triangles are good. The energy alone also moves vertices off the surface. Here each
    iteration minimises it, takes the part of the step within the tangent plane, and moves the vertex to the nearest point of the
    input surface, found by a walk from where it was. A step that would fold a triangle over, or bring the middle of an edge or
    the centroid of a triangle further from the input than allowed, is halved up to four times, and then not made.

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

    Where the triangles are halves of quadrilaterals cut along the wrong diagonal, as in range maps, moving vertices does not help
    and flipping edges does. Smoothing then moves the vertices to the centroids of their new neighbours. Both keep the input
    surface, its border, and the orientation and topology of its triangles; see `tangential_smoothing` and `flip_edges`.

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
        (n, 3) float64, and the (m, 3) triangles: one that no flip has changed keeps its row.

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
    check_positive("weight", weight)
    check_whole_number("iterations", iterations)
    if max_deviation is not None:
        check_finite("max_deviation", max_deviation, least=0.0)
    mesh = normalised_mesh(points, triangles, movable)
    may = np.ones(len(mesh), dtype=np.bool_) if mesh.movable is None else mesh.movable
    moves = may & ~border_vertices(mesh.cells, len(mesh))
    kept = mesh.cells[proper_faces(mesh.cells)]
    if not len(kept) or not (may if flips else moves).any():
        return points.copy(), triangles.copy()
    now = mesh.points
    allowed = 0.05 * mean_edge_length(now, kept) if max_deviation is None else max_deviation * mesh.scale
    surface = KeptSurface(now, kept, allowed)
    energy: TangentialEnergy | None = None
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
    found[proper_faces(triangles)] = mesh.used[surface.faces]
    return mesh.restored(now), found

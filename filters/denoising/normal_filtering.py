"""Denoising in two steps: the face normals are filtered, then the vertices are fitted to them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..execution import Progress, ignore_progress
from ..geometry import measure_faces
from ..mesh import Bools, Floats, check_mesh, check_movable, enter, leave, ordered_frame
from ..topology import BORDER_POLICIES, BorderPolicy, border_vertices
from .normal_filter import NormalFilter, NormalFilterKeywords, check_choice, check_count
from .normal_passes import NormalPasses
from .surroundings import Surroundings
from .vertex_update import VERTEX_UPDATES, VertexUpdate, fit_vertices

if TYPE_CHECKING:
    from typing_extensions import Unpack


def normal_filtering(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    vertex_iterations: int = 10,
    outer_iterations: int = 1,
    vertex_update: VertexUpdate = "sun",
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    surroundings: Surroundings | None = None,
    progress: Progress = ignore_progress,
    **normal_filter: Unpack[NormalFilterKeywords],
) -> Floats:
    """Filter the face normals, fit the vertices to them, and again, `outer_iterations` times.

    Areas, centres and normals are measured anew at the start of every outer iteration. The defaults are those of [zheng2011] in
    their authors' code: once 20 passes, then 10 steps. Many outer iterations of one pass each keep features better, since every
    pass sees normals that a surface has.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        vertex_iterations: steps of the vertices an outer iteration. More fit more closely, and follow errors of the normals more.
        outer_iterations: how often the two are repeated.
        vertex_update: how vertices are fitted; see `VertexUpdate`.
        border: "fixed": border vertices stay. "along": they move along the mean normal of their faces alone, so that the outline
            stays seen from above. "free": they move like any other.
        movable: (n,) bool, which vertices may move, None for all. The others stay where they are and are seen by those that do.
        surroundings: ``Surroundings.of(faces, n)``, to save finding them again where the same faces are filtered more than once.
        progress: called after every pass and every fit; may raise to stop.
        **normal_filter: the attributes of `NormalFilter`, by name: ``method="guided", normal_iterations=5``. Its
            `normal_iterations` are those of one outer iteration, its distances those of the mesh as it is by then.

    Returns:
        (n, 3) float64. Vertices that do not move keep every bit: those that no face uses, that are not `movable`, or on a fixed
        border. Deterministic, for any number of threads.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    for name, value in (("vertex_iterations", vertex_iterations), ("outer_iterations", outer_iterations)):
        check_count(name, value)
    check_choice("vertex_update", vertex_update, VERTEX_UPDATES)
    check_choice("border", border, BORDER_POLICIES)
    settings = NormalFilter(**normal_filter)
    known = Surroundings.of(triangles, len(points)) if surroundings is None else surroundings
    used = known.restored(np.diff(known.corners.offsets) > 0)
    moves = used if movable is None else used & check_movable(movable, len(points))
    on_border = np.zeros(len(points), dtype=np.bool_) if border == "free" else border_vertices(triangles, len(points))
    if border == "fixed":
        moves = moves & ~on_border
    frame = ordered_frame(_without_strays(points, used), None)
    start = enter(points, frame)
    now = known.ordered(start)
    rounds = outer_iterations if moves.any() else 0
    passes = NormalPasses.over(now, known, settings)
    moves, along_normal = known.ordered(moves), known.ordered(on_border) if border == "along" else None
    table = None
    for outer in range(rounds):

        def partial(share: float, done: int = outer) -> None:
            progress((done + 0.9 * share) / outer_iterations)

        table = measure_faces(now, known.faces, table)
        now = fit_vertices(
            now,
            known.faces,
            known.corners,
            passes.filtered(now, table, partial),
            update=vertex_update,
            iterations=vertex_iterations,
            moves=moves,
            along_normal=along_normal,
        )
        progress((outer + 1) / outer_iterations)
    return leave(points, start, known.restored(now), frame)


def filter_face_normals(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    progress: Progress = ignore_progress,
    **normal_filter: Unpack[NormalFilterKeywords],
) -> Floats:
    """(m, 3) the filtered unit normals of the faces, the vertices left alone.

    A face without area, whose own normal is 0, gets the normal of its surroundings.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        progress: called after every pass; may raise to stop.
        **normal_filter: the attributes of `NormalFilter`, by name.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    settings = NormalFilter(**normal_filter)
    known = Surroundings.of(triangles, len(points))
    start = known.ordered(framed(points, known))
    return NormalPasses.over(start, known, settings).filtered(start, measure_faces(start, known.faces), progress)


def framed(points: Floats, known: Surroundings) -> Floats:
    """The points, in coordinates of ordinary size."""
    return enter(points, ordered_frame(_without_strays(points, known.restored(np.diff(known.corners.offsets) > 0)), None))


def _without_strays(points: Floats, used: Bools) -> Floats:
    """The points that a face uses, or all if none does, so that the others do not decide on the frame."""
    return points if used.all() or not used.any() else points[used]

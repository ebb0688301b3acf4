"""Denoising in two steps: the face normals are filtered, then the vertices are fitted to them."""

from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_choice, check_whole_number
from ..execution import Progress, ignore_progress
from ..geometry import measure_faces
from ..mesh import Floats, check_mesh, normalised_mesh
from ..topology import BORDER_POLICIES, BorderPolicy
from .adjacency import Adjacency
from .normal_filter import NormalFilter, NormalFilterKeywords, lists_settings
from .normal_passes import NormalPasses
from .rounds import rounds
from .vertex_update import VertexUpdate

if TYPE_CHECKING:
    from typing_extensions import Unpack


@lists_settings
def normal_filtering(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    vertex_iterations: int = 10,
    outer_iterations: int = 1,
    vertex_update: VertexUpdate = "sun",
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
    **normal_filter: "Unpack[NormalFilterKeywords]",
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
    check_whole_number("vertex_iterations", vertex_iterations)
    outer = check_whole_number("outer_iterations", outer_iterations)
    check_choice("vertex_update", vertex_update, VertexUpdate)
    check_choice("border", border, BORDER_POLICIES)
    settings = NormalFilter(**normal_filter)
    mesh = normalised_mesh(points, triangles, movable)
    may_sort = settings.ignores_numbers_of_faces and vertex_update != "conjugate_gradient"
    sweeps = outer * (settings.normal_iterations + vertex_iterations) if may_sort else 0
    adjacency = Adjacency.of(mesh, sweeps=sweeps)
    mesh = mesh.in_order(adjacency.places)
    finished, now = 0, mesh.points
    results = rounds(
        mesh,
        adjacency,
        settings,
        vertex_iterations=vertex_iterations,
        vertex_update=vertex_update,
        border=border,
        progress=lambda share: progress((finished + 0.9 * share) / outer),
    )
    for finished, result in enumerate(islice(results, outer), 1):
        now = result
        progress(finished / outer)
    return mesh.restored(now)


@lists_settings
def filter_face_normals(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    progress: Progress = ignore_progress,
    **normal_filter: "Unpack[NormalFilterKeywords]",
) -> Floats:
    """(m, 3) the filtered unit normals of the faces, the vertices left alone.

    A face without area, whose own normal is 0, gets the normal of its surroundings, or 0 if it has none.

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
    mesh = normalised_mesh(points, triangles)
    adjacency = Adjacency.of(mesh, sweeps=settings.normal_iterations if settings.ignores_numbers_of_faces else 0)
    now = mesh.in_order(adjacency.places).points
    filtered = NormalPasses.over(now, adjacency, settings).filtered(now, measure_faces(now, adjacency.faces), progress)
    if adjacency.face_places is not None:
        here, filtered = filtered, np.empty_like(filtered)
        filtered[adjacency.face_places] = here
    if len(filtered) == len(triangles):
        return filtered
    # Faces without area whose vertices no other face uses are not in the normalised mesh.
    normals = np.zeros((len(triangles), 3))
    normals[np.isin(triangles, mesh.used).all(axis=1)] = filtered
    return normals

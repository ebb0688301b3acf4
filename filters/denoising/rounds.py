"""The rounds of two-step denoising: measure the faces, filter their normals, move the vertices; and again."""

from collections.abc import Iterator

import numpy as np

from ..execution import Progress, ignore_progress
from ..geometry import measure_faces
from ..mesh import Floats, NormalisedMesh
from ..topology import BorderPolicy
from .adjacency import Adjacency
from .normal_filter import NormalFilter
from .normal_passes import NormalPasses
from .vertex_update import VertexUpdate, fit_vertices


def rounds(
    mesh: NormalisedMesh,
    adjacency: Adjacency,
    settings: NormalFilter,
    *,
    vertex_iterations: int,
    vertex_update: VertexUpdate = "sun",
    border: BorderPolicy = "along",
    distance: float | None = None,
    progress: Progress = ignore_progress,
) -> Iterator[Floats]:
    """The points after one round, after two, and so on without end; none if no point may move. See `normal_filtering`.

    Args:
        mesh: the mesh, in the order of `adjacency`.
        adjacency: of the mesh.
        settings: the filter of the normals.
        vertex_iterations: steps of the vertices in a round.
        vertex_update: how they are fitted.
        border: which way border vertices may go.
        distance: of `NormalPasses`.
        progress: called with the share of a round after each of its passes over the normals.
    """
    moves = np.diff(adjacency.at_vertices.offsets) > 0
    if mesh.movable is not None:
        moves &= mesh.movable
    if border == "fixed":
        moves &= ~adjacency.on_border
    passes = NormalPasses.over(mesh.points, adjacency, settings, distance)
    now, table = mesh.points, None
    while moves.any():
        table = measure_faces(now, adjacency.faces, table)
        now = fit_vertices(
            now,
            adjacency.faces,
            adjacency.at_vertices,
            passes.filtered(now, table, progress),
            update=vertex_update,
            iterations=vertex_iterations,
            moves=moves,
            along_normal=adjacency.on_border if border == "along" else None,
            overwrite=table,
        )
        yield now

"""The rounds of two-step denoising: measure the faces, filter their normals, move the vertices; and again."""

from collections.abc import Iterator

import numpy as np

from ..execution import Progress, ignore_progress
from ..geometry import AREA, NORMAL, looking_away, measure_faces
from ..mesh import Bools, Floats, NormalisedMesh
from ..topology import BorderPolicy
from .adjacency import Adjacency
from .normal_filter import NormalFilter
from .normal_passes import NormalPasses
from .vertex_update import VertexUpdate, fit_vertices

# The corners of a face that a round folds over go back to where they were. That may fold others, for which it is looked so often.
_LOOKS = 2
#: rings of faces around a vertex that decide whether it goes back
RINGS_OF_LOOKS = 2 * _LOOKS


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

    Vertices slide along the surface until faces have hardly any area, which then turn over: such faces are not made.

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
    now = mesh.points
    table = measure_faces(now, adjacency.faces)
    folded = _folded(adjacency, table)
    while moves.any():
        after = fit_vertices(
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
        for _ in range(1 + _LOOKS):
            measure_faces(after, adjacency.faces, table)
            found = _folded(adjacency, table)
            corners = adjacency.faces[found & ~folded]
            if len(corners) == 0:
                break
            after[corners] = now[corners]
        now, folded = after, found
        yield now


def _folded(adjacency: Adjacency, table: Floats) -> Bools:
    """(m,) which faces are folded over, for a table of `measure_faces`."""
    return looking_away(table[:, [AREA]] * table[:, NORMAL], adjacency.faces, len(adjacency.at_vertices.offsets) - 1)

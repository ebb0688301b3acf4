"""The rounds of two-step denoising: measure the faces, filter their normals, move the vertices; and again."""

from collections.abc import Iterator

import numpy as np

from ..compilation import compiled
from ..execution import Progress, ignore_progress, over_range
from ..geometry import AREA, measure_faces
from ..mesh import Bools, Floats, Ints, Longs, NormalisedMesh
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
    """(m,) which faces look away from the mean of the normals at their corners, by area, for a table of `measure_faces`."""
    at = adjacency.at_vertices
    sums, folded = np.empty((len(at.offsets) - 1, 3)), np.empty(len(adjacency.faces), dtype=np.bool_)
    over_range(_sum_normals, len(sums), table, at.offsets, at.rows, sums)
    over_range(_look, len(folded), table, adjacency.faces, sums, folded)
    return folded


# Unsigned indices need no look whether they count from the end.
@compiled(nogil=True)
def _sum_normals(table: Floats, offsets: Longs, rows: Ints, sums: Floats, first: int, last: int) -> None:
    for i in range(np.uint64(first), np.uint64(last)):
        x = y = z = 0.0
        for k in range(np.uint64(offsets[i]), np.uint64(offsets[i + np.uint64(1)])):
            f = np.uint32(rows[k, 0])
            x += table[f, AREA] * table[f, 0]
            y += table[f, AREA] * table[f, 1]
            z += table[f, AREA] * table[f, 2]
        sums[i, 0], sums[i, 1], sums[i, 2] = x, y, z


@compiled(nogil=True)
def _look(table: Floats, faces: Ints, sums: Floats, folded: Bools, first: int, last: int) -> None:
    for f in range(np.uint64(first), np.uint64(last)):
        a, b, c = np.uint32(faces[f, 0]), np.uint32(faces[f, 1]), np.uint32(faces[f, 2])
        x, y, z = sums[a, 0] + sums[b, 0] + sums[c, 0], sums[a, 1] + sums[b, 1] + sums[c, 1], sums[a, 2] + sums[b, 2] + sums[c, 2]
        folded[f] = table[f, 0] * x + table[f, 1] * y + table[f, 2] * z < 0.0

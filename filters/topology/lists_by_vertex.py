"""The faces at every vertex. The lists are filled in two passes over the faces, in time linear in the mesh."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..mesh import Ints, Longs


class VertexFaces(NamedTuple):
    """The faces at every vertex i: ``rows[offsets[i]:offsets[i + 1]]``, in ascending order of the faces.

    Attributes:
        offsets: (n + 1,) int64.
        rows: (3 m, 3) int32. Face f with the vertices i, a, b in this cyclic order has the row (f, a, b) at vertex i.
    """

    offsets: Longs
    rows: Ints


def vertex_faces(faces: Ints, n_vertices: int) -> VertexFaces:
    """The faces at every vertex; a face that names a vertex twice is left out.

    Args:
        faces: (m, 3) triangles.
        n_vertices: n.
    """
    offsets, entries = _faces_by_vertex(faces, n_vertices, 3)
    return VertexFaces(offsets // 3, entries.reshape(-1, 3))


def ring_ends(faces: Ints, n_vertices: int) -> tuple[Longs, Ints]:
    """`vertex_faces` without the numbers of the faces: at every vertex the two other vertices of each of its faces.

    Those of vertex i are the pairs in ``ends[offsets[i]:offsets[i + 1]]``: a face (i, a, b) has the two entries a, b.

    Returns:
        offsets: (n + 1,) int64, even numbers.
        ends: (6 m,) int32, fewer if faces name a vertex twice.
    """
    return _faces_by_vertex(faces, n_vertices, 2)


def listed_by_vertex(
    cells: Ints, n_vertices: int, count: Callable[[Ints, Longs], None], fill: Callable[[Ints, Longs, Ints], None]
) -> tuple[Longs, Ints]:
    """One list of entries for every vertex.

    Args:
        cells: (m, 3) triangles or (e, 2) edges.
        n_vertices: n.
        count: adds the number of entries of vertex i to ``offsets[i + 2]``. Summed up, they begin at ``offsets[i + 1]``.
        fill: writes an entry of vertex i at ``offsets[i + 1]`` and increases that, so that in the end they begin at
            ``offsets[i]``.

    Returns:
        (n + 1,) int64 offsets and int32 entries.
    """
    # Large arrays come from numpy, never from a kernel: numpy asks the system for large pages, which makes them twice as fast.
    offsets = np.zeros(n_vertices + 2, dtype=np.int64)
    count(cells, offsets)
    np.cumsum(offsets, out=offsets)
    entries = np.empty(offsets[-1], dtype=np.int32)
    fill(cells, offsets, entries)
    return offsets[:-1], entries


def _faces_by_vertex(faces: Ints, n_vertices: int, width: int) -> tuple[Longs, Ints]:
    """The faces at every vertex by `width` entries each: 2 for the other vertices, 3 for the face and these."""
    triangles = np.ascontiguousarray(faces, dtype=np.int32)
    return listed_by_vertex(triangles, n_vertices, partial(_count_faces, width), partial(_fill_faces, width))


@compiled
def _count_faces(width: int, faces: Ints, offsets: Longs) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            offsets[a + 2] += width
            offsets[b + 2] += width
            offsets[c + 2] += width


@compiled
def _fill_faces(width: int, faces: Ints, offsets: Longs, entries: Ints) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):
                at = offsets[i + 1] + width
                if width == 3:
                    entries[at - 3] = f
                entries[at - 2], entries[at - 1] = j, k
                offsets[i + 1] = at

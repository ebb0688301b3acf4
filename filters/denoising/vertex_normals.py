"""Normal filtering on vertices instead of faces, for comparison: at a crease vertex normals are means across it [yadav2021]."""

from __future__ import annotations

import numpy as np

from ..geometry import AREA, CENTRE, NORMAL
from ..libraries import sparse
from ..mesh import Floats, Ints
from ..topology import one_rings
from .face_neighbourhoods import FaceNeighbourhoods


def vertex_neighbourhoods(faces: Ints, n_vertices: int, rings: int) -> FaceNeighbourhoods:
    """The vertices at most that many edges away from every vertex, ascending, without itself."""
    near = one_rings(faces, n_vertices)
    step = sparse.csr_matrix(
        (np.ones(len(near.neighbours), dtype=np.bool_), near.neighbours, near.offsets), (n_vertices, n_vertices)
    )
    around = step
    for _ in range(rings - 1):
        around = around + around @ step
    pairs = around.tocoo()
    others = pairs.row != pairs.col
    around = sparse.csr_matrix((np.ones(int(others.sum()), dtype=np.bool_), (pairs.row[others], pairs.col[others])), around.shape)
    around.sort_indices()
    return FaceNeighbourhoods(around.indptr.astype(np.int64), around.indices.astype(np.int32))


def measure_vertices(vertices: Floats, faces: Ints, table: Floats) -> Floats:
    """(n, 8) the table of `measure_faces` for vertices: unit normal, area, coordinates.

    The normal is the mean of those of the faces at the vertex by area; the area is the sum of theirs.

    Args:
        vertices: (n, 3) coordinates of ordinary size.
        faces: (m, 3) triangles.
        table: (m, 8) of `measure_faces`.
    """
    rows = np.zeros((len(vertices), 8))
    owners = faces.ravel()
    for column, values in ((3, table[:, AREA]), *((k, table[:, AREA] * table[:, k]) for k in range(3))):
        rows[:, column] = np.bincount(owners, weights=np.repeat(values, 3), minlength=len(vertices))
    rows[:, NORMAL] = _unit(rows[:, NORMAL], np.zeros(3))
    rows[:, CENTRE] = vertices
    return rows


def corner_means(vertex_normals: Floats, faces: Ints, face_normals: Floats) -> Floats:
    """(m, 3) for every face the unit mean of the normals of its vertices, or its own normal where they cancel out."""
    return _unit(vertex_normals[faces].sum(axis=1), face_normals)


def _unit(vectors: Floats, otherwise: Floats) -> Floats:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(lengths > 0.0, vectors / np.where(lengths > 0.0, lengths, 1.0), otherwise)

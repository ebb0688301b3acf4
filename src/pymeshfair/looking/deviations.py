"""The distance of every vertex from another surface, as a file: a table, or a mesh whose scalar it is."""

from __future__ import annotations

import io

import numpy as np

from ..declaration import Floats
from ..files.ply_write import write_ply
from ..mesh_data import MeshData

#: the extensions of such files
FORMATS = ("csv", "ply")


def deviations_file(mesh: MeshData, distances: Floats, extension: str) -> bytes:
    """The bytes of a file of `FORMATS`; numbers are as exact as in memory.

    Args:
        mesh: n vertices.
        distances: (n,) how far outwards each vertex lies.
        extension: which format.
    """
    file = io.BytesIO()
    if extension == "csv":
        rows = np.column_stack([np.arange(len(distances)), mesh.vertices, distances])
        np.savetxt(file, rows, fmt=("%d", *4 * ("%.17g",)), delimiter=",", header="vertex,x,y,z,distance", comments="")
    else:
        write_ply(MeshData(vertices=mesh.vertices, faces=mesh.faces, vertex_attributes={"scalars": distances}), file)
    return file.getvalue()

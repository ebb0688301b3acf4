"""The normals, areas and centres of the faces."""

import numpy as np
from numba import njit, prange

from ..execution import PARTS, SERIAL_BELOW
from ..mesh import Floats, Ints

#: The columns of the table of `measure_faces`: the unit normal, the area, the centre, and one that is not used.
NORMAL, AREA, CENTRE = slice(0, 3), 3, slice(4, 7)


def measure_faces(vertices: Floats, faces: Ints, table: Floats | None = None) -> Floats:
    """(m, 8) the faces measured: unit normal, area, centre, 0.

    A row is a cache line: a sweep over the neighbours of a face fetches each of them once. A face without area has the normal 0.

    Args:
        vertices: (n, 3) coordinates of ordinary size, such as those of a `Frame`.
        faces: (m, 3) triangles.
        table: (m, 8) one that is no longer needed, to be written over.
    """
    table = np.zeros((len(faces), 8)) if table is None else table
    if len(faces) < SERIAL_BELOW:
        _measure(vertices, faces, 0, len(faces), table)
    else:
        _measure_in_parallel(vertices, faces, table)
    return table


def face_normals(vertices: Floats, faces: Ints) -> Floats:
    """(m, 3) the unit normals of the faces; 0 where a face has no area."""
    return np.ascontiguousarray(measure_faces(vertices, faces)[:, NORMAL])


def mean_angle(normals: Floats, others: Floats) -> float:
    """The mean over the faces of the angle between two sets of (m, 3) unit normals, in degrees; 90 for a normal of 0."""
    cross = np.linalg.norm(np.cross(normals, others), axis=1)
    dot = np.einsum("ij,ij->i", normals, others)
    angles = np.where((cross == 0.0) & (dot == 0.0), np.pi / 2, np.arctan2(cross, dot))
    return float(np.degrees(angles.mean())) if len(angles) else 0.0


@njit(cache=True, parallel=True)
def _measure_in_parallel(vertices: Floats, faces: Ints, table: Floats) -> None:
    for part in prange(PARTS):
        _measure(vertices, faces, part * faces.shape[0] // PARTS, (part + 1) * faces.shape[0] // PARTS, table)


@njit(cache=True, nogil=True)
def _measure(vertices: Floats, faces: Ints, first: int, last: int, table: Floats) -> None:
    for f in range(first, last):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, uy, uz = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
        vx, vy, vz = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1], vertices[c, 2] - vertices[a, 2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            table[f, 0], table[f, 1], table[f, 2] = x / length, y / length, z / length
        else:
            table[f, 0] = table[f, 1] = table[f, 2] = 0.0
        table[f, 3] = 0.5 * length
        for k in range(3):
            table[f, 4 + k] = (vertices[a, k] + vertices[b, k] + vertices[c, k]) / 3.0

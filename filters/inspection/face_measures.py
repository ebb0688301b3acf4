"""Areas, normals and quality of faces, and the angles between them."""

import math

import numpy as np

from ..compilation import compiled
from ..geometry import cross_product, squared_length
from ..mesh import Bools, Floats, Ints


@compiled
def face_measures(points: Floats, faces: Ints) -> tuple[Floats, Floats, Floats]:
    """The normals of the faces, twice their area long; twice their areas; and their quality, 0 where the area is 0."""
    normals = np.empty((faces.shape[0], 3))
    doubled = np.empty(faces.shape[0])
    quality = np.zeros(faces.shape[0])
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        nx, ny, nz = cross_product(points, a, b, c)
        normals[f, 0], normals[f, 1], normals[f, 2] = nx, ny, nz
        doubled[f] = math.sqrt(nx * nx + ny * ny + nz * nz)
        p = math.sqrt(squared_length(points, a, b))
        q = math.sqrt(squared_length(points, a, c))
        r = math.sqrt(squared_length(points, b, c))
        if doubled[f] > 0:
            # R = p q r / (4 A) and doubled = 2 A.
            quality[f] = min(1.0, 2 / math.sqrt(3) * doubled[f] / (p * q * r / min(p, q, r)))
    return normals, doubled, quality


@compiled
def dihedral_angles(faces: Ints, normals: Floats, neighbours: Ints, shared: Ints) -> tuple[Floats, Bools]:
    """For two faces that share an edge the angle between their normals, NaN if one has no area; and whether they agree.

    They agree if they run along the edge in opposite directions; if not, one of them is turned over for the angle.
    """
    angles = np.empty(neighbours.shape[0])
    agree = np.empty(neighbours.shape[0], dtype=np.bool_)
    for p in range(neighbours.shape[0]):
        f, g = neighbours[p]
        u, v = shared[p]
        agree[p] = _runs_along(faces, f, u, v) != _runs_along(faces, g, u, v)
        sign = 1.0 if agree[p] else -1.0
        ax, ay, az = normals[f]
        bx, by, bz = normals[g]
        cosine = sign * (ax * bx + ay * by + az * bz)
        cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        # The arc tangent keeps the digits of small angles that the arc cosine loses.
        angles[p] = math.atan2(math.sqrt(cx * cx + cy * cy + cz * cz), cosine)
        if (ax == 0 and ay == 0 and az == 0) or (bx == 0 and by == 0 and bz == 0):
            angles[p] = np.nan
    return angles, agree


@compiled
def _runs_along(faces: Ints, face: int, start: int, end: int) -> bool:
    k = 0 if faces[face, 0] == start else 1 if faces[face, 1] == start else 2
    return bool(faces[face, k] == start and faces[face, (k + 1) % 3] == end)

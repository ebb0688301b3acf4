"""Areas, normals and quality of faces, and the angles between them."""

import math

import numpy as np

from ..compilation import compiled
from ..execution import over_range
from ..geometry import cross_product, squared_length
from ..mesh import Bools, Floats, Ints


def face_measures(points: Floats, faces: Ints) -> tuple[Floats, Floats, Floats]:
    """The normals of the faces, twice their area long; twice their areas; and their quality, 0 where the area is 0."""
    normals, doubled, quality = np.empty((len(faces), 3)), np.empty(len(faces)), np.zeros(len(faces))
    over_range(_measure, len(faces), points, faces, normals, doubled, quality)
    return normals, doubled, quality


def dihedral_angles(faces: Ints, normals: Floats, neighbours: Ints, shared: Ints) -> tuple[Floats, Bools]:
    """For two faces that share an edge the angle between their normals, NaN if one has no area; and whether they agree.

    They agree if they run along the edge in opposite directions; if not, one of them is turned over for the angle.
    """
    angles, agree = np.empty(len(neighbours)), np.empty(len(neighbours), dtype=np.bool_)
    over_range(_measure_pairs, len(neighbours), faces, normals, neighbours, shared, angles, agree)
    return angles, agree


@compiled(nogil=True)
def _measure(points: Floats, faces: Ints, normals: Floats, doubled: Floats, quality: Floats, first: int, last: int) -> None:
    for f in range(first, last):
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


@compiled(nogil=True)
def _measure_pairs(
    faces: Ints,
    normals: Floats,
    neighbours: Ints,
    shared: Ints,
    angles: Floats,
    agree: Bools,
    first: int,
    last: int,
) -> None:
    for p in range(first, last):
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


@compiled
def _runs_along(faces: Ints, face: int, start: int, end: int) -> bool:
    k = 0 if faces[face, 0] == start else 1 if faces[face, 1] == start else 2
    return bool(faces[face, k] == start and faces[face, (k + 1) % 3] == end)

"""Areas, normals and quality of faces, and the angles between them."""

import math

import numpy as np

from ..compilation import compiled
from ..execution import over_range
from ..geometry import cross_product, squared_length
from ..mesh import Bools, Floats, Ints
from ..topology import corner_at


def face_measures(points: Floats, faces: Ints) -> tuple[Floats, Floats, Floats]:
    """The normals of the faces, twice their area long; twice their areas; and their quality, 0 where the area is 0."""
    normals, doubled, quality = np.empty((len(faces), 3)), np.empty(len(faces)), np.zeros(len(faces))
    over_range(_measure, len(faces), points, faces, normals, doubled, quality)
    return normals, doubled, quality


def faces_agree(faces: Ints, neighbours: Ints, shared: Ints) -> Bools:
    """(q,) whether the two faces of each of (q, 2) pairs run in opposite directions along their (q, 2) shared edge."""
    agree = np.empty(len(neighbours), dtype=np.bool_)
    over_range(_compare_directions, len(neighbours), faces, neighbours, shared, agree)
    return agree


def dihedral_angles(normals: Floats, neighbours: Ints, agree: Bools) -> Floats:
    """For two faces that share an edge the angle between their normals, one turned over if they do not agree; NaN if one is 0."""
    angles = np.empty(len(neighbours))
    over_range(_measure_pairs, len(neighbours), normals, neighbours, agree, angles)
    return angles


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
def _compare_directions(faces: Ints, neighbours: Ints, shared: Ints, agree: Bools, first: int, last: int) -> None:
    for p in range(first, last):
        u, v = shared[p]
        f, g = neighbours[p]
        after_u, beyond_u = faces[f, (corner_at(faces, f, u) + 1) % 3], faces[g, (corner_at(faces, g, u) + 1) % 3]
        agree[p] = (after_u == v) != (beyond_u == v)


@compiled(nogil=True)
def _measure_pairs(normals: Floats, neighbours: Ints, agree: Bools, angles: Floats, first: int, last: int) -> None:
    for p in range(first, last):
        f, g = neighbours[p]
        sign = 1.0 if agree[p] else -1.0
        ax, ay, az = normals[f]
        bx, by, bz = normals[g]
        cosine = sign * (ax * bx + ay * by + az * bz)
        cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        # The arc tangent keeps the digits of small angles that the arc cosine loses.
        angles[p] = math.atan2(math.sqrt(cx * cx + cy * cy + cz * cz), cosine)
        if (ax == 0 and ay == 0 and az == 0) or (bx == 0 and by == 0 and bz == 0):
            angles[p] = np.nan

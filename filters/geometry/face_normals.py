"""The normals, areas and centres of the faces."""

import numpy as np

from ..compilation import compiled
from ..execution import over_range
from ..mesh import Floats, Ints
from ..topology import face_adjacency
from .triangles import cross_product

#: The columns of the table of `measure_faces`: the unit normal, the area, the centre; the last is not used.
NORMAL, AREA, CENTRE = slice(0, 3), 3, slice(4, 7)


def measure_faces(vertices: Floats, faces: Ints, table: Floats | None = None) -> Floats:
    """(m, 8) the unit normal, the area and the centre of every face, and one 0.

    A row fills one cache line, so a sweep over neighbouring faces loads one line for each. A face without area has the normal 0.

    Args:
        vertices: (n, 3) coordinates of ordinary size, such as the points of a `NormalisedMesh`.
        faces: (m, 3) triangles.
        table: (m, 8) a table to overwrite and return; None for a new one.
    """
    table = np.zeros((len(faces), 8)) if table is None else table
    over_range(_measure, len(faces), vertices, faces, table)
    return table


def face_normals(vertices: Floats, faces: Ints) -> Floats:
    """(m, 3) the unit normals of the faces; 0 where a face has no area."""
    return np.ascontiguousarray(measure_faces(vertices, faces)[:, NORMAL])


def normal_differences(vertices: Floats, faces: Ints) -> Floats:
    """(k,) |n_f - n_g| of the unit normals of the adjacent faces f, g: 0 of flush ones, 2 of a fold."""
    pairs, _ = face_adjacency(faces)
    sides = face_normals(vertices, faces)[pairs]
    return np.asarray(np.linalg.norm(sides[:, 0] - sides[:, 1], axis=1))


def cross_products(vertices: Floats, faces: Ints) -> Floats:
    """(m, 3) (b - a) x (c - a) of the faces (a, b, c): normal to them, and twice their area long."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.asarray(np.cross(b - a, c - a))


def seen_from_one_side(vertices: Floats, faces: Ints) -> float:
    """|sum A n| / sum A over the faces of area A and normal n: 1 of a plane, 0 of any closed surface and of one without area."""
    crosses = cross_products(vertices, faces)
    total = float(np.linalg.norm(crosses, axis=1).sum())
    return float(np.linalg.norm(crosses.sum(axis=0))) / total if total > 0.0 else 0.0


@compiled(nogil=True)
def turned_faces(before: Floats, after: Floats, faces: Ints) -> int:
    """How many faces look more than a right angle away from where they did.

    Args:
        before: (n, 3) coordinates of ordinary size.
        after: (n, 3) those of the same vertices later.
        faces: (m, 3) triangles.
    """
    count = 0
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        x, y, z = cross_product(before, a, b, c)
        u, v, w = cross_product(after, a, b, c)
        if x * u + y * v + z * w < 0.0:
            count += 1
    return count


@compiled(nogil=True)
def _measure(vertices: Floats, faces: Ints, table: Floats, first: int, last: int) -> None:
    for f in range(first, last):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        x, y, z = cross_product(vertices, a, b, c)
        length = np.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            table[f, 0], table[f, 1], table[f, 2] = x / length, y / length, z / length
        else:
            table[f, 0] = table[f, 1] = table[f, 2] = 0.0
        table[f, 3] = 0.5 * length
        for k in range(3):
            table[f, 4 + k] = (vertices[a, k] + vertices[b, k] + vertices[c, k]) / 3.0

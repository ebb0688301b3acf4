"""Normals of faces and vertices; areas and centres of faces."""

import math

import numpy as np

from ..compilation import compiled
from ..execution import blocks, over_range
from ..mesh import Bools, Floats, Ints
from ..topology import face_adjacency
from .measures import cross_product

#: The columns of the table of `measure_faces`: the unit normal, the area, the centre; the eighth is unused.
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
    return _measured(vertices, faces, NORMAL, np.empty((len(faces), 3)))


def face_areas(vertices: Floats, faces: Ints) -> Floats:
    """(m,) the areas of the faces."""
    return _measured(vertices, faces, AREA, np.empty(len(faces)))


def _measured(vertices: Floats, faces: Ints, columns: slice | int, values: Floats) -> Floats:
    """Columns of `measure_faces`, block by block: the table of all faces would not fit into the cache."""
    for part in blocks(len(faces)):
        values[part] = measure_faces(vertices, faces[part])[:, columns]
    return values


def roughness(points: Floats, faces: Ints) -> float:
    """The mean difference |n_f - n_g| of the unit normals of adjacent faces, from 0 in a plane to 2 at folds; 0 without any."""
    pairs, _ = face_adjacency(faces)
    sides = face_normals(points, faces)[pairs]
    return float(np.linalg.norm(sides[:, 0] - sides[:, 1], axis=1).mean()) if len(pairs) else 0.0


def cross_products(vertices: Floats, faces: Ints) -> Floats:
    """(m, 3) (b - a) x (c - a) of the faces (a, b, c): normals twice as long as the area."""
    crosses = np.empty((len(faces), 3))
    _fill_crosses(np.ascontiguousarray(vertices, dtype=np.float64), np.ascontiguousarray(faces, dtype=np.int32), crosses)
    return crosses


@compiled(nogil=True)
def _fill_crosses(points: Floats, faces: Ints, crosses: Floats) -> None:
    for f in range(faces.shape[0]):
        crosses[f, 0], crosses[f, 1], crosses[f, 2] = cross_product(points, faces[f, 0], faces[f, 1], faces[f, 2])


def seen_from_one_side(vertices: Floats, faces: Ints) -> float:
    """|sum A n| / sum A over the faces of area A and normal n: 1 for a plane, 0 for a closed surface or no area."""
    crosses = cross_products(vertices, faces)
    total = float(np.linalg.norm(crosses, axis=1).sum())
    return float(np.linalg.norm(crosses.sum(axis=0))) / total if total > 0.0 else 0.0


@compiled(nogil=True)
def turned_faces(before: Floats, after: Floats, faces: Ints) -> int:
    """The number of faces whose normals turn by more than a right angle, from (n, 3) coordinates of ordinary size to new ones."""
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


def vertex_normals_by_area(points: Floats, faces: Ints) -> Floats:
    """(n, 3) unit normals of points of ordinary size: area-weighted means of the face normals; 0 for points without a face."""
    return mean_normals_at_vertices(cross_products(points, faces), faces, len(points))


def mean_normals_at_vertices(of_faces: Floats, faces: Ints, n_vertices: int) -> Floats:
    """(n, 3) unit vectors, each along the sum of the (m, 3) vectors of the faces at a vertex; 0 for vertices without a face."""
    normals = np.stack([np.bincount(faces.ravel(), np.repeat(column, 3), n_vertices) for column in of_faces.T], axis=1)
    return unit_vectors(np.asarray(normals, np.float64))


def unit_vectors(vectors: Floats) -> Floats:
    """(n, 3) the vectors at length 1; 0 stays 0."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0.0, lengths, 1.0))


def vertex_normals_by_angle(vertices: Floats, faces: Ints) -> Floats:
    """(n, 3) unit normals of the vertices: angle-weighted means of the face normals [thurmer1998]; 0 without a face."""
    normals = np.zeros((len(vertices), 3))
    _add_by_angle(vertices, faces, normals)
    return normals


@compiled
def _add_by_angle(vertices: Floats, faces: Ints, normals: Floats) -> None:
    sides = np.empty((3, 3))
    for f in range(faces.shape[0]):
        for k in range(3):
            a, b = faces[f, k], faces[f, (k + 1) % 3]
            x, y, z = (vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2])
            largest = max(abs(x), abs(y), abs(z))
            if largest > 0.0:
                x, y, z = x / largest, y / largest, z / largest
            length = math.sqrt(x * x + y * y + z * z)
            if length > 0.0:
                x, y, z = x / length, y / length, z / length
            sides[k, 0], sides[k, 1], sides[k, 2] = x, y, z
        x = sides[0, 1] * sides[1, 2] - sides[0, 2] * sides[1, 1]
        y = sides[0, 2] * sides[1, 0] - sides[0, 0] * sides[1, 2]
        z = sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0]
        length = math.sqrt(x * x + y * y + z * z)
        if length == 0.0:
            continue
        for k in range(3):
            before = (k + 2) % 3
            cosine = -(sides[k, 0] * sides[before, 0] + sides[k, 1] * sides[before, 1] + sides[k, 2] * sides[before, 2])
            angle = math.acos(min(max(cosine, -1.0), 1.0)) / length
            i = faces[f, k]
            normals[i, 0] += angle * x
            normals[i, 1] += angle * y
            normals[i, 2] += angle * z
    for i in range(normals.shape[0]):
        length = math.sqrt(normals[i, 0] ** 2 + normals[i, 1] ** 2 + normals[i, 2] ** 2)
        if length > 0.0:
            for c in range(3):
                normals[i, c] /= length


def looking_away(normals: Floats, faces: Ints, count: int) -> Bools:
    """(m,) which faces look away from the mean of the normals of the faces at their vertices, weighted by area.

    The (m, 3) normals are as long as the areas of the faces times any number; `count` is the number of vertices.
    """
    away = np.empty(len(faces), dtype=np.bool_)
    _mark_looking_away(normals, faces, np.zeros((count, 3)), away)
    return away


@compiled(nogil=True)
def _mark_looking_away(normals: Floats, faces: Ints, sums: Floats, away: Bools) -> None:
    for f in range(len(faces)):
        for k in range(3):
            for c in range(3):
                sums[faces[f, k], c] += normals[f, c]
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        product = 0.0
        for d in range(3):
            product += normals[f, d] * (sums[a, d] + sums[b, d] + sums[c, d])
        away[f] = product < 0.0

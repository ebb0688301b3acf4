"""The normals of the vertices."""

import math

import numpy as np

from ..compilation import compiled
from ..mesh import Floats, Ints
from .face_normals import cross_products


def vertex_normals_by_area(points: Floats, faces: Ints) -> Floats:
    """(n, 3) the unit normals of the vertices, means of those of their faces by area; 0 where there is no face.

    Args:
        points: (n, 3) coordinates of ordinary size.
        faces: (m, 3) triangles.
    """
    columns = cross_products(points, faces).T
    normals = np.stack([np.bincount(faces.ravel(), np.repeat(column, 3), len(points)) for column in columns], axis=1)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(lengths > 0.0, lengths, 1.0))


def vertex_normals_by_angle(vertices: Floats, faces: Ints) -> Floats:
    """(n, 3) the unit normals of the vertices, means of those of their faces by the angle there [thurmer1998]; 0 without faces.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
    """
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

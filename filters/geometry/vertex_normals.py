"""The normals of the vertices."""

import numpy as np

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

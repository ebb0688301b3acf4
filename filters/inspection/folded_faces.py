"""Faces that strong noise, or too strong a filter, has folded over."""

import numpy as np
from numpy.typing import ArrayLike

from ..compilation import compiled
from ..mesh import Bools, Floats, Ints, check_mesh, normalised_mesh
from .face_measures import face_measures


def folded_faces(vertices: ArrayLike, faces: ArrayLike) -> Bools:
    """(m,) which faces look away from the mean of the normals of the faces at their vertices, weighted by area.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles. Where they do not agree on the outside, those of the smaller side count.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    local = np.zeros_like(points)
    local[mesh.used] = mesh.points
    return looking_away(face_measures(local, triangles)[0], triangles, len(points))


def looking_away(normals: Floats, faces: Ints, count: int) -> Bools:
    """(m,) `folded_faces`, from the normals of the faces, twice their area long, and the number of vertices."""
    found = np.empty(len(faces), dtype=np.bool_)
    _look(normals, faces, np.zeros((count, 3)), found)
    return found


@compiled(nogil=True)
def _look(normals: Floats, faces: Ints, sums: Floats, found: Bools) -> None:
    for f in range(len(faces)):
        for k in range(3):
            for c in range(3):
                sums[faces[f, k], c] += normals[f, c]
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        product = 0.0
        for d in range(3):
            product += normals[f, d] * (sums[a, d] + sums[b, d] + sums[c, d])
        found[f] = product < 0.0

"""Angles between vectors and at the corners of faces."""

import numpy as np

from ..mesh import Floats, Ints


def angles_between(first: Floats, second: Floats) -> Floats:
    """(k,) the angles between two sets of (k, 3) vectors of any length, in radians from 0 to pi; 0 if one vector is 0.

    From the arc tangent, which keeps the digits of small angles that the arc cosine loses.
    """
    sines = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.arctan2(sines, np.einsum("ij,ij->i", first, second)))


def corner_angles(vertices: Floats, faces: Ints) -> Floats:
    """(m, 3) the angle of every face at each of its vertices, in radians; 0 where two of them coincide.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
    """
    angles = np.empty(faces.shape)
    for k in range(3):
        at = vertices[faces[:, k]]
        angles[:, k] = angles_between(vertices[faces[:, (k + 1) % 3]] - at, vertices[faces[:, (k + 2) % 3]] - at)
    return angles

"""Models of planes as they were designed, without any noise."""

import numpy as np

from ..geometry import face_normals
from ..mesh import Floats, Ints
from ..topology import face_adjacency

# Of such a model this many of the faces and more share a plane with a neighbour. One vertex in a hundred moved spoils six faces
# in a hundred.
_DESIGNED = 0.99
# Angles below this, in radians, are the rounding of a file.
_FLAT = 1e-4


def is_designed(points: Floats, faces: Ints) -> bool:
    """Whether the mesh is made of planes of two faces and more, without noise.

    Args:
        points: (n, 3) coordinates of ordinary size.
        faces: (m, 3) triangles.
    """
    pairs, _ = face_adjacency(faces)
    normals = face_normals(points, faces)
    first, second = normals[pairs[:, 0]], normals[pairs[:, 1]]
    flat = (np.linalg.norm(np.cross(first, second), axis=1) < _FLAT) & (np.einsum("ij,ij->i", first, second) > 0.0)
    return len(np.unique(pairs[flat])) >= _DESIGNED * len(faces)

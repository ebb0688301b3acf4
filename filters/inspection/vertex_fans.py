"""How many fans the faces of a vertex form."""

import numpy as np

from ..compilation import compiled
from ..mesh import Ints, Longs


def fan_counts(faces: Ints, neighbours: Ints, shared: Ints, n_vertices: int) -> Ints:
    """(n,) the number of fans that the faces of a vertex form, linked through edges with two faces."""
    fans: Ints = np.bincount(_first_corners(faces, neighbours, shared), minlength=n_vertices).astype(np.int32)
    return fans


@compiled
def _first_corners(faces: Ints, neighbours: Ints, shared: Ints) -> Ints:
    """For every fan its vertex. Union-find over the corners 3 f + k of the faces."""
    parent = np.arange(3 * faces.shape[0])
    for p in range(neighbours.shape[0]):
        for vertex in shared[p]:
            i = _root(parent, _corner(faces, neighbours[p, 0], vertex))
            j = _root(parent, _corner(faces, neighbours[p, 1], vertex))
            parent[max(i, j)] = min(i, j)
    vertices = np.empty(3 * faces.shape[0], dtype=np.int32)
    found = 0
    for i in range(parent.shape[0]):
        if parent[i] == i:
            vertices[found] = faces[i // 3, i % 3]
            found += 1
    return vertices[:found].copy()


@compiled
def _corner(faces: Ints, face: int, vertex: int) -> int:
    for k in range(2):
        if faces[face, k] == vertex:
            return int(3 * face + k)
    return int(3 * face + 2)


@compiled
def _root(parent: Longs, i: int) -> int:
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i

"""How many fans the faces of a vertex form."""

import numpy as np

from ..compilation import compiled
from ..mesh import Ints


def fan_counts(faces: Ints, neighbours: Ints, shared: Ints, n_vertices: int) -> Ints:
    """(n,) the number of fans that the faces of a vertex form, linked through edges with two faces."""
    fans = np.zeros(n_vertices, dtype=np.int32)
    _count_fans(faces, neighbours, shared, np.arange(3 * len(faces), dtype=np.int32), fans)
    return fans


@compiled(nogil=True)
def _count_fans(faces: Ints, neighbours: Ints, shared: Ints, parent: Ints, fans: Ints) -> None:
    """Union-find over the corners 3 f + k of the faces, each of which is its own parent before."""
    for p in range(neighbours.shape[0]):
        for vertex in shared[p]:
            i = _root(parent, _corner(faces, neighbours[p, 0], vertex))
            j = _root(parent, _corner(faces, neighbours[p, 1], vertex))
            parent[max(i, j)] = min(i, j)
    for i in range(parent.shape[0]):
        if parent[i] == i:
            fans[faces[i // 3, i % 3]] += 1


@compiled
def _corner(faces: Ints, face: int, vertex: int) -> int:
    for k in range(2):
        if faces[face, k] == vertex:
            return int(3 * face + k)
    return int(3 * face + 2)


@compiled
def _root(parent: Ints, i: int) -> int:
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i

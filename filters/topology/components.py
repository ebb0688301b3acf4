"""The connected components of a triangle list."""

import numpy as np

from ..compilation import compiled
from ..mesh import Ints, Longs


def connected_components(faces: Ints, n_vertices: int) -> tuple[Ints, int]:
    """(n,) the component of every vertex, counted from 0 in order of the lowest vertex, -1 if unreferenced; and their number."""
    labels, count = _label_components(np.ascontiguousarray(faces, dtype=np.int32), n_vertices)
    return labels, int(count)


@compiled
def root_of(parent: Ints | Longs, i: int) -> int:
    """The root of the tree that i is in, by (n,) parents, those of roots being themselves; the way there is halved in place."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@compiled
def _label_components(faces: Ints, n_vertices: int) -> tuple[Ints, int]:
    parent = np.arange(n_vertices).astype(np.int32)
    labels = np.full(n_vertices, -1, dtype=np.int32)
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            labels[a] = labels[b] = labels[c] = 0
            for v in (b, c):
                u, w = root_of(parent, a), root_of(parent, v)
                # The lower root wins, so that a component's root is its lowest vertex.
                if u < w:
                    parent[w] = u
                else:
                    parent[u] = w
    count = 0
    for i in range(n_vertices):
        if labels[i] == 0:
            root = root_of(parent, i)
            if root == i:
                labels[i] = count
                count += 1
            else:
                labels[i] = labels[root]
    return labels, count

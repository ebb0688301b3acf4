"""Parts of a triangle list: its connected components, and the submesh around a region."""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..mesh import Bools, Floats, Ints, Longs, mask_of
from .incidence import faces_by_edge, listed_edges


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


class Submesh(NamedTuple):
    """Free vertices with rings of fixed vertices around them."""

    vertices: Ints  # (n,) ascending, the vertices of the mesh in it
    faces: Ints  # (m, 3) triangles of these vertices by their index here, in the order of the mesh
    points: Floats  # (n, 3) coordinates
    free: Bools  # (n,) which of them are free: no border vertex is
    border: Bools  # (n,) which of them lie on the border of the mesh; false on the outermost ring


def submesh_around(points: Floats, faces: Ints, free: Bools, rings: int) -> Submesh:
    """The chosen vertices with `rings` rings of vertices around them: all faces with a vertex within the inner rings - 1 rings.

    Takes one pass over the faces for each ring, and otherwise time in proportion to the submesh.

    Args:
        points: (n, 3) coordinates of the mesh.
        faces: (m, 3) its triangles.
        free: (n,) the chosen vertices. Those on the border of the mesh, and those without a triangle, are not free in the result.
        rings: the number of rings, from 1.
    """
    inside = free.copy()
    chosen = _touching(faces, inside)
    for _ in range(rings - 1):
        inside[chosen] = True
        chosen = _touching(faces, inside)
    # A mark for each vertex gives them in ascending order without sorting.
    vertices = np.flatnonzero(mask_of(chosen, len(points))).astype(np.int32)
    number = np.empty(len(points), dtype=np.int32)
    number[vertices] = np.arange(len(vertices), dtype=np.int32)
    local = number.take(chosen)
    # An edge with one face and no end inside may have another face outside of the submesh.
    edges = listed_edges(*faces_by_edge(local, len(vertices)), 1, 1)[0]
    border = mask_of(edges[inside.take(vertices)[edges].any(axis=1)], len(vertices))
    return Submesh(vertices, local, points.take(vertices, axis=0), free.take(vertices) & ~border, border)


@compiled
def _touching(faces: Ints, marked: Bools) -> Ints:
    """The triangles with a marked vertex, in their order."""
    touching = np.empty((faces.shape[0] + 1, 3), dtype=np.int32)  # the system gives memory only to the part that is written
    at = 0
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        touching[at, 0], touching[at, 1], touching[at, 2] = a, b, c
        at += (marked[a] | marked[b] | marked[c]) & (a != b) & (b != c) & (c != a)  # branches would be unpredictable
    return touching[:at].copy()

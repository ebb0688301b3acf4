"""Parts of a triangle list: its connected components, and the submesh around a region."""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..mesh import Bools, Floats, Ints, Longs
from .edge_lists import edge_face_counts


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
    """Free vertices with rings of fixed vertices around them.

    Attributes:
        vertices: (n,) ascending, the vertices of the mesh in it.
        faces: (m, 3) triangles of these vertices by their index here, in the order of the mesh.
        points: (n, 3) coordinates.
        free: (n,) which of them are free: no border vertex is.
        border: (n,) which of them lie on the border of the mesh; false on the outermost ring.
    """

    vertices: Ints
    faces: Ints
    points: Floats
    free: Bools
    border: Bools


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
    touched = _touching(faces, inside)
    for _ in range(rings - 1):
        inside[faces[touched]] = True
        touched = _touching(faces, inside)
    chosen = faces[touched]
    # A mark for each vertex gives them in ascending order without sorting.
    marked = np.zeros(len(points), dtype=np.bool_)
    marked[chosen] = True
    vertices = np.flatnonzero(marked).astype(np.int32)
    number = np.empty(len(points), dtype=np.int32)
    number[vertices] = np.arange(len(vertices), dtype=np.int32)
    local = np.ascontiguousarray(number[chosen])
    pairs, counts = edge_face_counts(local)
    complete = inside[vertices]
    # An edge of the outermost ring may have lost faces; one that ends further inside has all of them.
    border_pairs = pairs[counts == 1]
    border_pairs = border_pairs[complete[border_pairs].any(axis=1)]
    border = np.zeros(len(vertices), dtype=np.bool_)
    border[border_pairs] = True
    return Submesh(vertices, local, points[vertices], free[vertices] & ~border, border)


@compiled
def _touching(faces: Ints, marked: Bools) -> Longs:
    """The triangles with a marked vertex, ascending."""
    count = 0
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if (marked[a] or marked[b] or marked[c]) and a != b and b != c and c != a:
            count += 1
    rows = np.empty(count, dtype=np.int64)
    at = 0
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if (marked[a] or marked[b] or marked[c]) and a != b and b != c and c != a:
            rows[at] = f
            at += 1
    return rows

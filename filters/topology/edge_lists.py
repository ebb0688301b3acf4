"""The edges of a triangle list and the faces at each, in time linear in the mesh.

A face that names a vertex twice is not proper: it has no edges and references no vertex, so the faces on both sides of a
collapsed triangle share an edge. An edge with exactly one face is a border edge, one with more than two is non-manifold.
"""

import numpy as np

from ..mesh import Bools, Ints
from .edge_keys import faces_by_edge, listed_edges


def edges(faces: Ints) -> Ints:
    """(e, 2) every edge once, lower vertex first, rows ascending."""
    return edge_face_counts(faces)[0]


def edge_face_counts(faces: Ints) -> tuple[Ints, Ints]:
    """(e, 2) every edge once, lower vertex first, rows ascending; and (e,) the number of faces at each."""
    return listed_edges(*faces_by_edge(np.ascontiguousarray(faces, dtype=np.int32), vertex_bound(faces)))


def non_manifold_edges(faces: Ints) -> Ints:
    """(k, 2) the edges with more than two faces, lower vertex first, rows ascending."""
    pairs, counts = edge_face_counts(faces)
    found: Ints = pairs[counts > 2]
    return found


def referenced_vertices(faces: Ints, n_vertices: int) -> Bools:
    """(n,) whether the vertex belongs to a proper face."""
    used = np.zeros(n_vertices, dtype=np.bool_)
    used[faces[proper_faces(faces)]] = True
    return used


def proper_faces(faces: Ints) -> Bools:
    """(m,) whether the face names three different vertices."""
    a, b, c = faces.T
    return np.asarray((a != b) & (b != c) & (c != a))


def vertex_bound(faces: Ints) -> int:
    """One more than the highest vertex that a face names."""
    return int(faces.max()) + 1 if faces.size else 0

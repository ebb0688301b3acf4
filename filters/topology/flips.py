"""Edge flips in two tables: the vertices of every face, and the faces across its edges.

Edge k of a face goes from its corner k to the next. The caller chooses the edges to flip, by their geometry.
"""

import numpy as np

from ..compilation import compiled
from ..mesh import Ints
from .incidence import face_adjacency


def faces_across(faces: Ints) -> Ints:
    """(m, 3) int32 the face across edge k of every face, the edge from its corner k to the next.

    -1 where the edge has other than two faces, and where its two faces are not coherently oriented.
    """
    triangles = np.ascontiguousarray(faces, dtype=np.int32)
    pairs, shared = face_adjacency(triangles)
    across = np.full(triangles.shape, -1, dtype=np.int32)
    _link(triangles, pairs, shared, across)
    return across


@compiled
def _link(faces: Ints, pairs: Ints, shared: Ints, across: Ints) -> None:
    for p in range(pairs.shape[0]):
        f, g = pairs[p, 0], pairs[p, 1]
        u, v = shared[p, 0], shared[p, 1]
        j, k = _edge_from(faces, f, u, v), _edge_from(faces, g, v, u)
        if j < 0:
            j, k = _edge_from(faces, f, v, u), _edge_from(faces, g, u, v)
        if k >= 0:
            across[f, j], across[g, k] = g, f


@compiled
def _edge_from(faces: Ints, f: int, u: int, v: int) -> int:
    """Which edge of face f goes from u to v; -1 if none does."""
    for k in range(3):
        if faces[f, k] == u and faces[f, (k + 1) % 3] == v:
            return k
    return -1


@compiled
def corner_at(faces: Ints, f: int, vertex: int) -> int:
    """The corner, 0 to 2, of face f at one of its vertices."""
    if faces[f, 0] == vertex:
        return 0
    return 1 if faces[f, 1] == vertex else 2


@compiled
def diamond(faces: Ints, across: Ints, f: int, k: int) -> tuple[int, int, int, int]:
    """The ends a, b of edge k of face f = (a, b, c), c, and the vertex d of the face (b, a, d) across, which must exist."""
    a, b, c = faces[f, k], faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
    g = across[f, k]
    return a, b, c, faces[g, (corner_at(faces, g, b) + 2) % 3]


@compiled
def fan_size(faces: Ints, across: Ints, f: int, k: int, other: int) -> int:
    """The number of faces in the fan round corner k of face f; -1 if one of them has the vertex `other`.

    The walk goes across the edges in `across`: both ways to a border, or once round.
    """
    vertex = faces[f, k]
    size, g, closed = 0, f, False
    for way in range(2):
        while g >= 0 and not closed:
            size += 1
            i = corner_at(faces, g, vertex)
            if faces[g, (i + 1) % 3] == other or faces[g, (i + 2) % 3] == other:
                return -1
            g = across[g, i] if way == 0 else across[g, (i + 2) % 3]
            closed = g == f
        if way == 0 and not closed:
            g = across[f, (k + 2) % 3]
    return size


@compiled
def flip(faces: Ints, across: Ints, f: int, k: int) -> None:
    """Replace the edge of a `diamond` by its other diagonal: f and the face across become (a, d, c) and (d, b, c)."""
    a, b, c, d = diamond(faces, across, f, k)
    g = across[f, k]
    j = corner_at(faces, g, b)
    ad, db = across[g, (j + 1) % 3], across[g, (j + 2) % 3]
    bc, ca = across[f, (k + 1) % 3], across[f, (k + 2) % 3]
    faces[f, 0], faces[f, 1], faces[f, 2] = a, d, c
    across[f, 0], across[f, 1], across[f, 2] = ad, g, ca
    faces[g, 0], faces[g, 1], faces[g, 2] = d, b, c
    across[g, 0], across[g, 1], across[g, 2] = db, bc, f
    relink(faces, across, ad, a, d, f)
    relink(faces, across, bc, b, c, g)


@compiled
def relink(faces: Ints, across: Ints, f: int, a: int, b: int, now: int) -> None:
    """Enter face `now` across the edge from b to a of face f; nothing to do for f = -1."""
    if f >= 0:
        across[f, _edge_from(faces, f, b, a)] = now

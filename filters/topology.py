"""Who touches whom: edges, one-rings, borders and components of a triangle list, each in time linear in the mesh.

A face that names a vertex twice is no triangle: it gives no edge and references nothing, so the faces on both sides of a
collapsed triangle meet each other. An edge with exactly one face is a border edge, one with more than two is non-manifold.
"""

from typing import Any

import numpy as np
from numba import njit

from .mesh import Bools, Floats, Ints, Longs, check_mesh, check_points
from .rings import OneRings, one_rings, sort_slice

__all__ = [
    "Bools",
    "Floats",
    "Ints",
    "Longs",
    "OneRings",
    "border_edges",
    "border_vertices",
    "check_mesh",
    "check_points",
    "connected_components",
    "edge_face_counts",
    "edge_lengths",
    "edges",
    "face_adjacency",
    "mean_edge_length",
    "non_manifold_edges",
    "one_rings",
    "referenced_vertices",
]


def edges(faces: Ints) -> Ints:
    """(e, 2) every edge once, lower vertex first, rows ascending."""
    return edge_face_counts(faces)[0]


def edge_face_counts(faces: Ints) -> tuple[Ints, Ints]:
    """(e, 2) every edge once, lower vertex first, rows ascending; and (e,) the number of faces at each."""
    n_vertices = _vertex_bound(faces)
    rings = one_rings(faces, n_vertices)
    low = np.repeat(np.arange(n_vertices, dtype=np.int32), np.diff(rings.offsets))
    once = low < rings.neighbours
    return np.column_stack([low[once], rings.neighbours[once]]), rings.face_counts[once]


def border_edges(faces: Ints) -> Ints:
    """(b, 2) the edges with exactly one face, lower vertex first, rows ascending."""
    pairs, counts = edge_face_counts(faces)
    border: Ints = pairs[counts == 1]
    return border


def non_manifold_edges(faces: Ints) -> Ints:
    """(k, 2) the edges with more than two faces, lower vertex first, rows ascending."""
    pairs, counts = edge_face_counts(faces)
    found: Ints = pairs[counts > 2]
    return found


def border_vertices(faces: Ints, n_vertices: int) -> Bools:
    """(n,) whether a vertex lies on a border edge."""
    on_border = np.zeros(n_vertices, dtype=np.bool_)
    on_border[border_edges(faces)] = True
    return on_border


def referenced_vertices(faces: Ints, n_vertices: int) -> Bools:
    """(n,) whether a triangle uses the vertex."""
    used = np.zeros(n_vertices, dtype=np.bool_)
    used[faces[_is_triangle(faces)]] = True
    return used


def face_adjacency(faces: Ints) -> tuple[Ints, Ints]:
    """(k, 2) the pairs of faces that share an edge with exactly two faces, lower face first; and (k, 2) that edge.

    The rows are in ascending order of the edge. Two faces that share two edges appear twice.
    """
    offsets, keys = _faces_by_edge(np.ascontiguousarray(faces, dtype=np.int32), _vertex_bound(faces))
    pairs, shared = _two_faced_edges(offsets, keys)
    return pairs, shared


def connected_components(faces: Ints, n_vertices: int) -> tuple[Ints, int]:
    """(n,) the component of every vertex, counted from 0 in order of the lowest vertex, -1 if unreferenced; and their number."""
    labels, count = _label_components(np.ascontiguousarray(faces, dtype=np.int32), n_vertices)
    return labels, int(count)


def mean_edge_length(vertices: Floats, faces_or_edges: Ints) -> float:
    """The mean length of the edges, each counted once, in mesh units; 0 if there are none.

    Args:
        vertices: (n, 3) coordinates.
        faces_or_edges: (m, 3) triangles, or (e, 2) edges.
    """
    pairs = edges(faces_or_edges) if faces_or_edges.shape[1] == 3 else faces_or_edges
    if len(pairs) == 0:
        return 0.0
    return float(_lengths(vertices, pairs).mean())


def edge_lengths(vertices: Floats, pairs: Ints) -> Floats:
    """(e,) the length of each of the (e, 2) edges."""
    return np.asarray(_lengths(vertices, pairs))


def _lengths(vertices: Floats, pairs: Ints) -> Any:
    return np.linalg.norm(vertices[pairs[:, 1]] - vertices[pairs[:, 0]], axis=1)


def _vertex_bound(faces: Ints) -> int:
    return int(faces.max()) + 1 if faces.size else 0


def _is_triangle(faces: Ints) -> Any:
    a, b, c = faces.T
    return (a != b) & (b != c) & (c != a)


@njit(cache=True)
def _faces_by_edge(faces: Ints, n_vertices: int) -> tuple[Longs, Longs]:
    """The half-edges by their lower vertex; each key is (higher vertex) * 2^32 + face, ascending."""
    offsets = np.zeros(n_vertices + 1, dtype=np.int64)
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            offsets[min(a, b) + 1] += 1
            offsets[min(b, c) + 1] += 1
            offsets[min(c, a) + 1] += 1
    for i in range(n_vertices):
        offsets[i + 1] += offsets[i]
    cursor = offsets[:-1].copy()
    keys = np.empty(offsets[n_vertices], dtype=np.int64)
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            for u, v in ((a, b), (b, c), (c, a)):
                low = min(u, v)
                keys[cursor[low]] = (np.int64(max(u, v)) << 32) | f
                cursor[low] += 1
    for i in range(n_vertices):
        sort_slice(keys, offsets[i], offsets[i + 1])
    return offsets, keys


@njit(cache=True)
def _two_faced_edges(offsets: Longs, keys: Longs) -> tuple[Ints, Ints]:
    pairs = np.empty((keys.shape[0] // 2, 2), dtype=np.int32)
    shared = np.empty((keys.shape[0] // 2, 2), dtype=np.int32)
    found = 0
    for i in range(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        while start < stop:
            end = start + 1
            while end < stop and keys[end] >> 32 == keys[start] >> 32:
                end += 1
            if end - start == 2:
                pairs[found, 0] = keys[start] & 0xFFFFFFFF
                pairs[found, 1] = keys[start + 1] & 0xFFFFFFFF
                shared[found, 0] = i
                shared[found, 1] = keys[start] >> 32
                found += 1
            start = end
    return pairs[:found].copy(), shared[:found].copy()


@njit(cache=True)
def _root(parent: Ints, i: int) -> int:
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@njit(cache=True)
def _label_components(faces: Ints, n_vertices: int) -> tuple[Ints, int]:
    parent = np.arange(n_vertices).astype(np.int32)
    labels = np.full(n_vertices, -1, dtype=np.int32)
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            labels[a] = labels[b] = labels[c] = 0
            for v in (b, c):
                u, w = _root(parent, a), _root(parent, v)
                # The lower root wins, so that a component's root is its lowest vertex.
                if u < w:
                    parent[w] = u
                else:
                    parent[u] = w
    count = 0
    for i in range(n_vertices):
        if labels[i] == 0:
            root = _root(parent, i)
            if root == i:
                labels[i] = count
                count += 1
            else:
                labels[i] = labels[root]
    return labels, count

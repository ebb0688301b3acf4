"""Who touches whom: edges, one-rings, borders and components of a triangle list, each in time linear in the mesh.

A face that names a vertex twice is no triangle: it gives no edge and references nothing, so the faces on both sides of a
collapsed triangle meet each other. An edge with exactly one face is a border edge, one with more than two is non-manifold.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numba import njit, prange
from numpy.typing import ArrayLike, NDArray

from .errors import FilterInputError
from .parallel import threads_for

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Longs: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]

# Up to this, an insertion sort is faster; above, its quadratic time would show at the hub of a large fan.
_SHORT = 48


class OneRings(NamedTuple):
    """The neighbours of every vertex: those of vertex i are ``neighbours[offsets[i]:offsets[i + 1]]``, ascending, each once.

    Attributes:
        offsets: (n + 1,) int64.
        neighbours: (2 e,) int32 for e edges.
        face_counts: (2 e,) int32, how many faces the edge to that neighbour has: 1 on a border, more than 2 if non-manifold.
    """

    offsets: Longs
    neighbours: Ints
    face_counts: Ints


def check_mesh(vertices: ArrayLike, faces: ArrayLike) -> tuple[Floats, Ints]:
    """The mesh as (n, 3) float64 and (m, 3) int32, both C-contiguous and not copied when they are so already.

    Raises:
        FilterInputError: a wrong shape or type, a coordinate that is not finite, an index that names no vertex; the message
            gives the first of them and their number.
    """
    points = check_points(vertices)
    triangles = np.asarray(faces)
    if triangles.size == 0:
        return points, np.empty((0, 3), dtype=np.int32)
    if triangles.ndim != 2 or triangles.shape[1] != 3 or not np.issubdtype(triangles.dtype, np.integer):
        raise FilterInputError(
            f"faces must be an (m, 3) array of whole numbers, got shape {triangles.shape} of {triangles.dtype}; "
            "triangulate polygons first"
        )
    if triangles.min() < 0 or triangles.max() >= len(points):
        bad = ((triangles < 0) | (triangles >= len(points))).any(axis=1)
        first = int(bad.argmax())
        raise FilterInputError(
            f"face {first} is {triangles[first].tolist()}, but the vertices are 0 to {len(points) - 1} "
            f"({int(bad.sum())} such faces of {len(triangles)}): remove these faces or add the vertices"
        )
    return points, np.ascontiguousarray(triangles, dtype=np.int32)


def check_points(vertices: ArrayLike) -> Floats:
    """The points as (n, 3) float64, C-contiguous, not copied when they are so already.

    Raises:
        FilterInputError: a wrong shape or type, or a coordinate that is not finite.
    """
    raw = np.asarray(vertices)
    if raw.size == 0:
        return np.empty((0, 3))
    if raw.ndim != 2 or raw.shape[1] != 3 or raw.dtype.kind not in "fiu":
        raise FilterInputError(f"vertices must be an (n, 3) array of real numbers, got shape {raw.shape} of {raw.dtype}")
    points = np.ascontiguousarray(raw, dtype=np.float64)
    if len(points) > np.iinfo(np.int32).max:
        raise FilterInputError(f"{len(points)} vertices are more than the 2,147,483,647 that an index of 32 bits reaches")
    if not np.isfinite(points).all():
        bad = ~np.isfinite(points).all(axis=1)
        first = int(bad.argmax())
        raise FilterInputError(
            f"vertex {first} is {points[first].tolist()}: {int(bad.sum())} of {len(points)} vertices have a coordinate that is "
            "not finite; remove these vertices first"
        )
    return points


def one_rings(faces_or_edges: Ints, n_vertices: int) -> OneRings:
    """The one-ring of every vertex, and the number of faces at each of its edges.

    Args:
        faces_or_edges: (m, 3) triangles; or (e, 2) edges, which count as faces.
        n_vertices: n.
    """
    cells = np.ascontiguousarray(faces_or_edges, dtype=np.int32)
    if cells.shape[1] == 3:
        offsets, ends = ring_ends(cells, n_vertices)
    else:
        offsets, ends = _gather_ends(cells, n_vertices, _count_ends_of_edges, _fill_ends_of_edges)
    ring_offsets = np.zeros(n_vertices + 1, dtype=np.int64)
    with threads_for(n_vertices):
        _sort_and_count(offsets, ends, ring_offsets)
        np.cumsum(ring_offsets, out=ring_offsets)
        neighbours = np.empty(ring_offsets[-1], dtype=np.int32)
        face_counts = np.empty(ring_offsets[-1], dtype=np.int32)
        _compress(offsets, ends, ring_offsets, neighbours, face_counts)
    return OneRings(ring_offsets, neighbours, face_counts)


def ring_ends(faces: Ints, n_vertices: int) -> tuple[Longs, Ints]:
    """For every vertex the two other vertices of each of its faces, in the order of the faces, orientation kept.

    Those of vertex i are the pairs in ``ends[offsets[i]:offsets[i + 1]]``: for a face (i, a, b) the two entries a, b.

    Returns:
        offsets: (n + 1,) int64, even numbers.
        ends: (6 m,) int32, less those of faces that name a vertex twice.
    """
    return _gather_ends(np.ascontiguousarray(faces, dtype=np.int32), n_vertices, _count_ends, _fill_ends)


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


def _gather_ends(
    cells: Ints, n_vertices: int, count: Callable[[Ints, Longs], None], fill: Callable[[Ints, Longs, Ints], None]
) -> tuple[Longs, Ints]:
    # Large arrays come from numpy, never from a kernel: numpy asks the system for large pages, which makes them twice as fast.
    offsets = np.zeros(n_vertices + 2, dtype=np.int64)
    count(cells, offsets)
    np.cumsum(offsets, out=offsets)
    ends = np.empty(offsets[-1], dtype=np.int32)
    fill(cells, offsets, ends)
    return offsets[:-1], ends


@njit(cache=True)
def _count_ends(faces: Ints, offsets: Longs) -> None:
    """Count at ``offsets[i + 2]``, so that after summing up vertex i's entries begin at ``offsets[i + 1]``."""
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            offsets[a + 2] += 2
            offsets[b + 2] += 2
            offsets[c + 2] += 2


@njit(cache=True)
def _fill_ends(faces: Ints, offsets: Longs, ends: Ints) -> None:
    """Write at ``offsets[i + 1]`` and move it on, so that in the end vertex i's entries begin at ``offsets[i]``."""
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            k = offsets[a + 1]
            ends[k], ends[k + 1] = b, c
            offsets[a + 1] = k + 2
            k = offsets[b + 1]
            ends[k], ends[k + 1] = c, a
            offsets[b + 1] = k + 2
            k = offsets[c + 1]
            ends[k], ends[k + 1] = a, b
            offsets[c + 1] = k + 2


@njit(cache=True)
def _count_ends_of_edges(pairs: Ints, offsets: Longs) -> None:
    for e in range(pairs.shape[0]):
        a, b = pairs[e, 0], pairs[e, 1]
        if a != b:
            offsets[a + 2] += 1
            offsets[b + 2] += 1


@njit(cache=True)
def _fill_ends_of_edges(pairs: Ints, offsets: Longs, ends: Ints) -> None:
    for e in range(pairs.shape[0]):
        a, b = pairs[e, 0], pairs[e, 1]
        if a != b:
            ends[offsets[a + 1]] = b
            offsets[a + 1] += 1
            ends[offsets[b + 1]] = a
            offsets[b + 1] += 1


@njit(cache=True)
def sort_slice(values: Ints | Longs, start: int, stop: int) -> None:
    """Sort ``values[start:stop]`` in place: by insertion, or if it is long by a heap."""
    if stop - start <= _SHORT:
        for k in range(start + 1, stop):
            value = values[k]
            j = k - 1
            while j >= start and values[j] > value:
                values[j + 1] = values[j]
                j -= 1
            values[j + 1] = value
        return
    size = stop - start
    parent = size // 2
    while size > 1:
        if parent > 0:
            parent -= 1
        else:
            size -= 1
            values[start], values[start + size] = values[start + size], values[start]
        node = parent
        while 2 * node + 1 < size:
            child = 2 * node + 1
            if child + 1 < size and values[start + child + 1] > values[start + child]:
                child += 1
            if values[start + node] >= values[start + child]:
                break
            values[start + node], values[start + child] = values[start + child], values[start + node]
            node = child


@njit(cache=True)
def position(neighbours: Ints, start: int, stop: int, j: int) -> int:
    """Where j is in ``neighbours[start:stop]``, which is ascending and has it."""
    while stop - start > 1:
        middle = (start + stop) // 2
        if neighbours[middle] <= j:
            start = middle
        else:
            stop = middle
    return start


@njit(cache=True, parallel=True)
def _sort_and_count(offsets: Longs, ends: Ints, ring_sizes: Longs) -> None:
    for i in prange(offsets.shape[0] - 1):
        start, stop = offsets[i], offsets[i + 1]
        sort_slice(ends, start, stop)
        size = 0
        for k in range(start, stop):
            if k == start or ends[k] != ends[k - 1]:
                size += 1
        ring_sizes[i + 1] = size


@njit(cache=True, parallel=True)
def _compress(offsets: Longs, ends: Ints, ring_offsets: Longs, neighbours: Ints, face_counts: Ints) -> None:
    for i in prange(offsets.shape[0] - 1):
        at = ring_offsets[i] - 1
        for k in range(offsets[i], offsets[i + 1]):
            if k == offsets[i] or ends[k] != ends[k - 1]:
                at += 1
                neighbours[at] = ends[k]
                face_counts[at] = 1
            else:
                face_counts[at] += 1


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

"""Boundary loops, connected components, and the submesh around a region.

A loop has the direction of the faces that would close it. At a vertex with several fans of faces, the border goes from each fan
to the next fan round the vertex. So two holes that share a vertex have two loops.
"""

from collections import defaultdict
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ..compilation import compiled
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, Longs, mask_of
from .incidence import faces_by_edge, listed_edges, proper_faces

#: Why a border cannot be followed at a vertex: a non-manifold edge ends there, or the faces there give the border no order.
BreakReason: TypeAlias = Literal["non_manifold", "orientation"]


class BoundaryLoop(NamedTuple):
    """A closed loop of border edges."""

    vertices: Ints  # (k,) int32, starting at the lowest index, in the direction of a face that closes the loop
    opposite: Ints  # (k,) int32 the third vertex of the mesh face at each edge of the loop


class BrokenBorder(NamedTuple):
    """Connected border edges that lie on no loop."""

    vertices: Ints  # (k,) int32, ascending
    reason: BreakReason
    vertex: int  # the lowest vertex at which the border cannot be followed for this reason


class Boundary(NamedTuple):
    """The border of a mesh: each border edge is on one loop or in one broken part."""

    loops: list[BoundaryLoop]  # in ascending order of their first two vertices
    broken: list[BrokenBorder]  # in ascending order of their lowest vertices


def boundary_loops(vertices: Floats, faces: Ints) -> Boundary:
    """Returns the boundary loops, and the parts of the border that form no loop.

    Coordinates matter only at vertices with three or more fans of faces.
    """
    faces = np.ascontiguousarray(faces, dtype=np.int32)
    by_edge = faces_by_edge(faces)
    border, at = listed_edges(*by_edge, 1, 1, columns=2)
    if len(border) == 0:
        return Boundary([], [])
    corners = faces[at[:, 0]]
    low, high = border.T
    rises = (np.roll(corners, -1, axis=1)[corners == low[:, None]] == high)[:, None]  # the edge of the face goes from low to high
    # Edges against the direction of their faces, in ascending order, so that a cycle starts at its lowest edge.
    starts, ends = np.where(rises, border[:, ::-1], border).T
    order = np.lexsort((ends, starts))
    starts, ends, opposite = starts[order], ends[order], (corners.sum(axis=1) - low - high).astype(np.int32)[order]
    following, breaks = _successors(starts, ends, faces, vertices, mask_of(listed_edges(*by_edge, 3)[0], len(vertices)))
    cycles, rest = _cycles(following)
    return Boundary([BoundaryLoop(starts[cycle], opposite[cycle]) for cycle in cycles], _broken(starts[rest], ends[rest], breaks))


def is_seam(loop: BoundaryLoop, vertices: Floats) -> bool:
    """Whether at least half of the loop's vertices coincide with another vertex of the loop: an unmerged seam."""
    distinct = np.unique(loop.vertices)
    _, counts = np.unique(vertices[distinct], axis=0, return_counts=True)
    return 2 * int(counts[counts > 1].sum()) >= len(distinct)


def _cycles(following: Ints) -> tuple[list[list[int]], list[int]]:
    """Returns the cycles of the map from each edge to the next edge, and the edges that lie on no cycle."""
    next_of = following.tolist()
    on_paths = set()
    for e in set(range(len(next_of))) - set(next_of):
        while e >= 0:
            on_paths.add(e)
            e = next_of[e]
    seen, cycles = on_paths.copy(), []
    for e in range(len(next_of)):
        cycle = []
        while e not in seen:
            seen.add(e)
            cycle.append(e)
            e = next_of[e]
        if cycle:
            cycles.append(cycle)
    return cycles, sorted(on_paths)


def _broken(starts: Ints, ends: Ints, breaks: dict[int, BreakReason]) -> list[BrokenBorder]:
    """The connected parts of border edges, each with its lowest "non_manifold" break, or else its lowest "orientation" break."""
    if len(starts) == 0:
        return []
    border, at_edges = np.unique([starts, ends], return_inverse=True)
    graph = sparse.coo_array((np.ones(len(starts)), at_edges.reshape(2, -1)), shape=(len(border), len(border)))
    labels = sparse.csgraph.connected_components(graph, directed=False)[1]
    broken = []
    for vertices in np.split(border[np.argsort(labels, kind="stable")], np.cumsum(np.bincount(labels))[:-1]):
        group = vertices.tolist()
        at = [v for v in group if breaks.get(v) == "non_manifold"] or [v for v in group if v in breaks]
        broken.append(BrokenBorder(vertices, breaks[at[0]], at[0]))
    return broken


def _successors(
    starts: Ints, ends: Ints, faces: Ints, vertices: Floats, non_manifold: Bools
) -> tuple[Ints, dict[int, BreakReason]]:
    """Returns (b,) the border edge after each border edge, -1 at a break; and the reason for each vertex with a break."""
    n = len(vertices)
    leaving, arriving = np.bincount(starts, minlength=n), np.bincount(ends, minlength=n)
    balanced = (leaving == arriving) & ~non_manifold
    leaves_by = np.full(n, -1, dtype=np.int32)
    leaves_by[starts] = np.arange(len(starts), dtype=np.int32)
    following = np.where((balanced & (leaving == 1))[ends], leaves_by[ends], np.int32(-1))
    met = leaving + arriving > 0
    breaks: dict[int, BreakReason] = dict.fromkeys(np.flatnonzero(met & non_manifold).tolist(), "non_manifold")
    breaks |= dict.fromkeys(np.flatnonzero((leaving != arriving) & ~non_manifold).tolist(), "orientation")
    pinched = balanced & (leaving > 1)
    if pinched.any():
        concerned = np.flatnonzero(pinched[starts] | pinched[ends])
        edge_of = {
            (a, b): e for e, a, b in zip(*(x.tolist() for x in (concerned, starts[concerned], ends[concerned])), strict=True)
        }
        for v, next_of in _ring_successors(faces[pinched[faces].any(axis=1) & proper_faces(faces)], pinched).items():
            fans = _fans(v, next_of, vertices)
            if fans is None or len(fans) != leaving[v]:
                breaks[v] = "orientation"
                continue
            for fan, after in zip(fans, fans[1:] + fans[:1], strict=True):
                following[edge_of[after[0], v]] = edge_of[v, fan[-1]]
    return following, breaks


def _ring_successors(near: Ints, marked: Bools) -> dict[int, dict[int, int]]:
    """Maps each marked vertex v to a map with a -> b for each face (v, a, b), or to an empty map if two faces have the same a."""
    steps: dict[int, dict[int, int]] = defaultdict(dict)
    ambiguous = set()
    for face in near.tolist():
        for k in range(3):
            v, a, b = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
            if marked[v]:
                if a in steps[v]:
                    ambiguous.add(v)
                steps[v][a] = b
    return {v: {} if v in ambiguous else next_of for v, next_of in steps.items()}


def _fans(v: int, next_of: dict[int, int], vertices: Floats) -> list[list[int]] | None:
    """The open fans at v as lists of neighbours, sorted by angle if three or more; None if they cannot be followed or sorted."""
    fans = []
    for first in sorted(set(next_of) - set(next_of.values())):
        fan = [first]
        while fan[-1] in next_of:
            fan.append(next_of[fan[-1]])
            if len(fan) > len(next_of) + 1:
                return None
        fans.append(fan)
    if len(fans) < 3:
        return fans
    around = {a: vertices[a] - vertices[v] for fan in fans for a in fan}
    normal = sum(np.cross(around[a], around[next_of[a]]) for fan in fans for a in fan[:-1])
    size = float(np.linalg.norm(normal))
    if not size > 0.0:
        return None
    across = around[fans[0][0]]
    x = across - normal * (across @ normal) / size**2
    y = np.cross(normal, x) / size
    return sorted(fans, key=lambda fan: float(np.arctan2(around[fan[0]] @ y, around[fan[0]] @ x) % (2.0 * np.pi)))


def connected_components(faces: Ints, n_vertices: int) -> tuple[Ints, int]:
    """Numbers components by lowest vertex; returns (n,) the number at each vertex (-1 without a proper face), and their count."""
    labels, count = _label_components(np.ascontiguousarray(faces, dtype=np.int32), n_vertices)
    return labels, int(count)


@compiled
def root_of(parent: Ints | Longs, i: int) -> int:
    """The root of i in a union-find forest of (n,) parents, where a root is its own parent; halves the path in place."""
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
                parent[max(u, w)] = min(u, w)  # so that a component's root is its lowest vertex
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

    vertices: Ints  # (n,) the vertices of the mesh that are corners of `faces`, ascending
    faces: Ints  # (m, 3) triangles as indices into `vertices`, in the order of the mesh
    points: Floats  # (n, 3) coordinates
    free: Bools  # (n,) whether the vertex is free; border vertices are not
    border: Bools  # (n,) whether the vertex is an end of a border edge; edges within the outermost ring do not count


def submesh_around(points: Floats, faces: Ints, free: Bools, rings: int) -> Submesh:
    """Returns the free vertices with `rings` >= 1 rings around: all faces at free vertices and at all rings but the last."""
    inside = free.copy()
    chosen = _touching(faces, inside)
    for _ in range(rings - 1):
        inside[chosen] = True
        chosen = _touching(faces, inside)
    vertices = np.flatnonzero(mask_of(chosen, len(points))).astype(np.int32)
    number = np.empty(len(points), dtype=np.int32)
    number[vertices] = np.arange(len(vertices), dtype=np.int32)
    local = number.take(chosen)
    # An edge within the outermost ring may have another face outside of the submesh.
    edges = listed_edges(*faces_by_edge(local, len(vertices)), 1, 1)[0]
    border = mask_of(edges[inside.take(vertices)[edges].any(axis=1)], len(vertices))
    return Submesh(vertices, local, points.take(vertices, axis=0), free.take(vertices) & ~border, border)


@compiled
def _touching(faces: Ints, marked: Bools) -> Ints:
    touching = np.empty((faces.shape[0] + 1, 3), dtype=np.int32)  # the system allocates only the pages that are written
    at = 0
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        touching[at, 0], touching[at, 1], touching[at, 2] = a, b, c
        at += (marked[a] | marked[b] | marked[c]) & (a != b) & (b != c) & (c != a)  # no branch: it would be unpredictable
    return touching[:at].copy()

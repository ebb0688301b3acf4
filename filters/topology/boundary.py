"""Boundary loops, connected components, and the submesh around a region.

A loop has the direction of the faces that would close it. A vertex at which several fans of faces meet is passed once for every
gap between two of them, from each fan to the next one round the vertex. So two holes that share vertices have two loops. A loop
meets a vertex twice only where a part of the surface is attached to the rest by that vertex alone: closed as one polygon, the
vertex has a single fan again, which it would not have if the loop were cut in two.
"""

from collections import defaultdict
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ..compilation import compiled
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, Longs, mask_of
from .incidence import faces_by_edge, listed_edges, proper_faces

#: Why a border cannot be followed at a vertex: an edge with more than two faces ends there; its faces are not oriented alike.
BreakReason: TypeAlias = Literal["non_manifold", "orientation"]


class BoundaryLoop(NamedTuple):
    """A closed loop of border edges."""

    # (k,) int32, from the lowest on. A face that closes the loop has the edge ``vertices[i]``, ``vertices[i + 1]`` in this
    # direction, the face of the mesh at this edge has it in the other.
    vertices: Ints
    opposite: Ints  # (k,) int32 the third vertex of the face of the mesh at that edge


class BrokenBorder(NamedTuple):
    """Connected border edges that lie on no loop."""

    vertices: Ints  # (k,) int32 their vertices, ascending
    reason: BreakReason
    vertex: int  # the lowest vertex at which the border cannot be followed for this reason


class Boundary(NamedTuple):
    """The border edges of a mesh, each on a loop or in a broken part of the border."""

    loops: list[BoundaryLoop]  # in ascending order of their first two vertices
    broken: list[BrokenBorder]  # in ascending order of their lowest vertices


def boundary_loops(vertices: Floats, faces: Ints) -> Boundary:
    """The boundary loops, and the parts of the border that form none.

    Coordinates matter only where three or more fans of faces meet at a vertex.
    """
    by_edge = faces_by_edge(faces)
    border, at = listed_edges(*by_edge, 1, 1, columns=2)
    if len(border) == 0:
        return Boundary([], [])
    corners = faces[at[:, 0]]
    low, high = border.T
    rises = (np.roll(corners, -1, axis=1)[corners == low[:, None]] == high)[:, None]  # the face goes from the lower end up
    # Each edge against the direction of its face, in ascending order, so that a cycle begins at its lowest edge.
    starts, ends = np.where(rises, border[:, ::-1], border).T
    order = np.lexsort((ends, starts))
    starts, ends, opposite = starts[order], ends[order], (corners.sum(axis=1) - low - high).astype(np.int32)[order]
    crowded = mask_of(listed_edges(*by_edge, 3)[0], len(vertices))
    following, breaks = _successors(starts, ends, faces, vertices, crowded)
    cycles, rest = _cycles(following)
    loops = [BoundaryLoop(starts[cycle], opposite[cycle]) for cycle in cycles]
    return Boundary(loops, _broken(starts[rest], ends[rest], breaks))


def is_seam(loop: BoundaryLoop, vertices: Floats) -> bool:
    """Whether at least half of the loop's vertices coincide with another of them: two sides that were never merged."""
    own = np.unique(loop.vertices)
    _, counts = np.unique(vertices[own], axis=0, return_counts=True)
    return 2 * int(counts[counts > 1].sum()) >= len(own)


def _cycles(following: Ints) -> tuple[list[list[int]], list[int]]:
    """The cycles of the map from each edge to the next, and the edges that lie on none."""
    onwards = following.tolist()
    on_paths = set()
    for e in set(range(len(onwards))) - set(onwards):
        while e >= 0:
            on_paths.add(e)
            e = onwards[e]
    seen, cycles = on_paths.copy(), []
    for e in range(len(onwards)):
        cycle = []
        while e not in seen:
            seen.add(e)
            cycle.append(e)
            e = onwards[e]
        if cycle:
            cycles.append(cycle)
    return cycles, sorted(on_paths)


def _broken(starts: Ints, ends: Ints, breaks: dict[int, BreakReason]) -> list[BrokenBorder]:
    if len(starts) == 0:
        return []
    own, at_edges = np.unique([starts, ends], return_inverse=True)
    graph = sparse.coo_array((np.ones(len(starts)), at_edges.reshape(2, -1)), shape=(len(own), len(own)))
    labels = sparse.csgraph.connected_components(graph, directed=False)[1]
    broken = []
    for vertices in np.split(own[np.argsort(labels, kind="stable")], np.cumsum(np.bincount(labels))[:-1]):
        group = vertices.tolist()
        at = [v for v in group if breaks.get(v) == "non_manifold"] or [v for v in group if v in breaks]
        broken.append(BrokenBorder(vertices, breaks[at[0]], at[0]))
    return broken


def _successors(starts: Ints, ends: Ints, faces: Ints, vertices: Floats, crowded: Bools) -> tuple[Ints, dict[int, BreakReason]]:
    """(b,) the border edge after each one, by the next gap at its end, -1 if there is none; and at which vertices and why."""
    n = len(vertices)
    leaving, arriving = np.bincount(starts, minlength=n), np.bincount(ends, minlength=n)
    as_many = (leaving == arriving) & ~crowded
    leaves_by = np.full(n, -1, dtype=np.int32)
    leaves_by[starts] = np.arange(len(starts), dtype=np.int32)
    following = np.where((as_many & (leaving == 1))[ends], leaves_by[ends], np.int32(-1))
    met = leaving + arriving > 0
    breaks: dict[int, BreakReason] = dict.fromkeys(np.flatnonzero(met & crowded).tolist(), "non_manifold")
    breaks |= dict.fromkeys(np.flatnonzero((leaving != arriving) & ~crowded).tolist(), "orientation")
    several = as_many & (leaving > 1)
    if several.any():
        concerned = np.flatnonzero(several[starts] | several[ends])
        edge_of = {
            (a, b): e for e, a, b in zip(*(x.tolist() for x in (concerned, starts[concerned], ends[concerned])), strict=True)
        }
        for v, onwards in _next_round(faces[several[faces].any(axis=1) & proper_faces(faces)], several).items():
            fans = _fans(v, onwards, vertices)
            if fans is None or len(fans) != leaving[v]:
                breaks[v] = "orientation"
                continue
            for fan, after in zip(fans, fans[1:] + fans[:1], strict=True):
                following[edge_of[after[0], v]] = edge_of[v, fan[-1]]
    return following, breaks


def _next_round(near: Ints, several: Bools) -> dict[int, dict[int, int]]:
    """For every marked vertex v the map from a to b over its faces (v, a, b); empty if two faces have the same a."""
    steps: dict[int, dict[int, int]] = defaultdict(dict)
    twice = set()
    for face in near.tolist():
        for k in range(3):
            v, a, b = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
            if several[v]:
                if a in steps[v]:
                    twice.add(v)
                steps[v][a] = b
    return {v: {} if v in twice else onwards for v, onwards in steps.items()}


def _fans(v: int, onwards: dict[int, int], vertices: Floats) -> list[list[int]] | None:
    """The open fans at v, as neighbours in order round v, three by angle about the faces' mean normal; None without order."""
    fans = []
    for first in sorted(set(onwards) - set(onwards.values())):
        fan = [first]
        while fan[-1] in onwards:
            fan.append(onwards[fan[-1]])
            if len(fan) > len(onwards) + 1:
                return None
        fans.append(fan)
    if len(fans) < 3:
        return fans
    around = {a: vertices[a] - vertices[v] for fan in fans for a in fan}
    normal = sum(np.cross(around[a], around[onwards[a]]) for fan in fans for a in fan[:-1])
    size = float(np.linalg.norm(normal))
    if not size > 0.0:
        return None
    across = around[fans[0][0]]
    x = across - normal * (across @ normal) / size**2
    y = np.cross(normal, x) / size
    return sorted(fans, key=lambda fan: float(np.arctan2(around[fan[0]] @ y, around[fan[0]] @ x) % (2.0 * np.pi)))


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
    """The (n,) free vertices with 1 or more rings around them: all faces with a vertex within the inner rings - 1 rings.

    Takes one pass over the faces for each ring, and otherwise time in proportion to the submesh. Vertices on the border of the
    mesh, and those without a triangle, are not free in the result.
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

"""The rims of the holes: loops of border edges, each in the direction of the faces that would close it.

A vertex at which several fans of faces meet is passed once for every gap between two of them, from each fan to the next one
round the vertex. So two holes that share a vertex, or several, are two rims. A rim meets a vertex twice only where a part of the
surface hangs on the rest by that vertex alone; closed as one polygon, the vertex has a single fan again, which it would not have
if such a rim were cut in two.
"""

from collections import defaultdict
from typing import NamedTuple

import numpy as np

from ..mesh import Bools, Floats, Ints
from ..topology import edge_face_counts
from .filling import OpenRim, Reason


class Rim(NamedTuple):
    """A closed loop of border edges.

    Attributes:
        vertices: (k,) int32, from the lowest on. A face that closes the hole has the edge ``vertices[i]``, ``vertices[i + 1]`` in
            this direction, the face of the mesh there has it in the other.
        opposite: (k,) int32 the third vertex of the face of the mesh at that edge.
    """

    vertices: Ints
    opposite: Ints


def find_rims(vertices: Floats, faces: Ints) -> tuple[list[Rim], list[OpenRim]]:
    """All rims in order of their lowest vertices, and the parts of the border that are none, with the reason.

    Args:
        vertices: (n, 3) coordinates; they decide only where three or more fans of faces meet at a vertex.
        faces: (m, 3) triangles.
    """
    pairs, counts = edge_face_counts(faces)
    border = pairs[counts == 1]
    if len(border) == 0:
        return [], []
    n = len(vertices)
    near = _faces_at(border, faces, n)
    starts, ends, opposite = _hole_edges(border, near, n)
    non_manifold = np.zeros(n, dtype=np.bool_)
    non_manifold[pairs[counts > 2]] = True
    following, bad = _follow(starts, ends, near, vertices, non_manifold)
    loops, rest = _loops(following)
    rims = []
    for loop in loops:
        corners = starts[loop]
        first = min(range(len(loop)), key=lambda i: (corners[i], corners[(i + 1) % len(loop)]))
        turned = np.roll(np.array(loop), -first)
        rims.append(Rim(starts[turned], opposite[turned]))
    rims.sort(key=lambda rim: tuple(rim.vertices[:2].tolist()))
    return rims, _refused(rest, starts, ends, bad, non_manifold)


def is_seam(rim: Rim, vertices: Floats) -> bool:
    """Whether half of the rim's vertices and more lie where another of them lies: two sides that were never merged."""
    own = np.unique(rim.vertices)
    _, counts = np.unique(vertices[own], axis=0, return_counts=True)
    return 2 * int(counts[counts > 1].sum()) >= len(own)


def _faces_at(border: Ints, faces: Ints, n_vertices: int) -> Ints:
    """The triangles with a vertex on the border."""
    on_border = np.zeros(n_vertices, dtype=np.bool_)
    on_border[border] = True
    a, b, c = faces.T
    near: Ints = faces[(on_border[a] | on_border[b] | on_border[c]) & (a != b) & (b != c) & (c != a)]
    return near


def _hole_edges(border: Ints, near: Ints, n_vertices: int) -> tuple[Ints, Ints, Ints]:
    """Start, end and opposite vertex of the border edges, against the direction of their faces, in ascending order."""
    ends, starts, opposite = (np.concatenate([near[:, (k + j) % 3] for k in range(3)]) for j in range(3))
    keys = np.minimum(starts, ends).astype(np.int64) * n_vertices + np.maximum(starts, ends)
    chosen = np.isin(keys, border[:, 0].astype(np.int64) * n_vertices + border[:, 1])
    starts, ends, opposite = starts[chosen], ends[chosen], opposite[chosen]
    order = np.lexsort((ends, starts))
    return starts[order], ends[order], opposite[order]


def _follow(starts: Ints, ends: Ints, near: Ints, vertices: Floats, non_manifold: Bools) -> tuple[Ints, dict[int, Reason]]:
    """For every edge of the border the one after it, -1 where that is not defined; and the vertices where it is not."""
    n = len(non_manifold)
    leaving, arriving = np.bincount(starts, minlength=n), np.bincount(ends, minlength=n)
    plain = (leaving == 1) & (arriving == 1) & ~non_manifold
    leaves_by = np.full(n, -1, dtype=np.int32)
    leaves_by[starts] = np.arange(len(starts), dtype=np.int32)
    following = np.where(plain[ends], leaves_by[ends], np.int32(-1))
    bad: dict[int, Reason] = {}
    several = np.zeros(n, dtype=np.bool_)
    for v in np.flatnonzero(((leaving > 0) | (arriving > 0)) & ~plain).tolist():
        if non_manifold[v]:
            bad[v] = "non_manifold"
        elif leaving[v] != arriving[v]:
            bad[v] = "orientation"
        else:
            several[v] = True
    if several.any():
        edge_of = {
            (a, b): e for e, (a, b) in enumerate(zip(starts.tolist(), ends.tolist(), strict=True)) if several[a] or several[b]
        }
        for v, onwards in _steps_round(near[several[near].any(axis=1)], several).items():
            fans = _fans(v, onwards, vertices)
            if fans is None or len(fans) != leaving[v]:
                bad[v] = "orientation"
                continue
            for fan, after in zip(fans, fans[1:] + fans[:1], strict=True):
                following[edge_of[after[0], v]] = edge_of[v, fan[-1]]
    return following, bad


def _steps_round(near: Ints, several: Bools) -> dict[int, dict[int, int]]:
    """For every vertex v that is asked for, of each face (v, a, b) the step from a to b; empty if two of them begin at an a."""
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
    """The open fans of faces round v as lists of neighbours, in the order in which one meets them; None if they make no sense."""
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


def _loops(following: Ints) -> tuple[list[list[int]], list[int]]:
    """The cycles of the map from each edge to the next, and the edges that lie on none."""
    onwards = following.tolist()
    # 0: not met, 1: on a way that ends at a vertex without a next edge, 2: on a loop
    state = [0] * len(onwards)
    for e in sorted(set(range(len(onwards))) - set(onwards)):
        while e >= 0:
            state[e] = 1
            e = onwards[e]
    loops = []
    for e, met in enumerate(state):
        if met == 0 and state[e] == 0:
            loop = []
            while state[e] == 0:
                state[e] = 2
                loop.append(e)
                e = onwards[e]
            loops.append(loop)
    return loops, [e for e, met in enumerate(state) if met == 1]


def _refused(rest: list[int], starts: Ints, ends: Ints, bad: dict[int, Reason], non_manifold: Bools) -> list[OpenRim]:
    """The edges that lie on no loop, those together that hang together."""
    parent: dict[int, int] = {}

    def root(v: int) -> int:
        while parent.setdefault(v, v) != v:
            parent[v] = parent[parent[v]]
            v = parent[v]
        return v

    for a, b in zip(starts[rest].tolist(), ends[rest].tolist(), strict=True):
        low, high = sorted((root(a), root(b)))
        parent[high] = low
    groups: dict[int, list[int]] = defaultdict(list)
    for v in sorted(parent):
        groups[root(v)].append(v)
    refused = []
    for group in groups.values():
        culprits = [v for v in group if bad.get(v) == "non_manifold"] or [v for v in group if v in bad]
        if non_manifold[culprits[0]]:
            reason: Reason = "non_manifold"
            why = "an edge with more than two faces ends there: delete or separate its faces"
        else:
            reason = "orientation"
            why = "the faces there are not coherently oriented: orient them first"
        message = f"the border through vertex {culprits[0]} (and {len(group) - 1} others) was left: {why}"
        refused.append(OpenRim(np.array(group, dtype=np.int32), reason, message))
    return refused

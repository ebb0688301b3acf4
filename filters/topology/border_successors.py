"""Which border edge follows which along the border of a mesh, at vertices with one fan of faces and with several."""

from collections import defaultdict
from typing import Literal, TypeAlias

import numpy as np

from ..mesh import Bools, Floats, Ints

#: Why a border cannot be followed at a vertex: an edge with more than two faces ends there, or its faces are not coherently
#: oriented.
BreakReason: TypeAlias = Literal["non_manifold", "orientation"]


def border_successors(
    starts: Ints, ends: Ints, near: Ints, vertices: Floats, non_manifold: Bools
) -> tuple[Ints, dict[int, BreakReason]]:
    """The border edge that follows each one, by the next gap between two fans of faces at its end.

    Args:
        starts: (b,) the start of every border edge, against the direction of its face.
        ends: (b,) its end.
        near: (k, 3) the proper faces with a vertex on the border.
        vertices: (n, 3) coordinates, for the order of three or more fans round a vertex.
        non_manifold: (n,) the ends of edges with more than two faces.

    Returns:
        (b,) the index of the next edge, -1 if there is none; and the vertices at which there is none, with the reason.
    """
    n = len(non_manifold)
    leaving, arriving = np.bincount(starts, minlength=n), np.bincount(ends, minlength=n)
    plain = (leaving == 1) & (arriving == 1) & ~non_manifold
    leaves_by = np.full(n, -1, dtype=np.int32)
    leaves_by[starts] = np.arange(len(starts), dtype=np.int32)
    following = np.where(plain[ends], leaves_by[ends], np.int32(-1))
    breaks: dict[int, BreakReason] = {}
    several = np.zeros(n, dtype=np.bool_)
    for v in np.flatnonzero(((leaving > 0) | (arriving > 0)) & ~plain).tolist():
        if non_manifold[v]:
            breaks[v] = "non_manifold"
        elif leaving[v] != arriving[v]:
            breaks[v] = "orientation"
        else:
            several[v] = True
    if several.any():
        edge_of = {
            (a, b): e for e, (a, b) in enumerate(zip(starts.tolist(), ends.tolist(), strict=True)) if several[a] or several[b]
        }
        for v, onwards in _next_round(near[several[near].any(axis=1)], several).items():
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
    """The open fans of faces at v as lists of neighbours, in their order round v; None if that order is not defined.

    Three or more are ordered by angle in the plane normal to the sum of the faces' cross products.
    """
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

"""A triangulated hole made as dense as its rim, with edges flipped towards Delaunay."""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..mesh import Bools, Floats, Ints
from ..topology import faces_across, relink
from .delaunay_flips import flip_towards_delaunay

#: A triangle is split if its centroid, times this, is farther from each corner than the edges there are long [liepa2003].
DENSITY = np.sqrt(2.0)

# Edges between two vertices of the rim are not split at triangles whose height is below this share of the edge length there:
# between the sides of a crack a new vertex has no room to move.
_CRACK = 0.25
_MOST_ROUNDS = 60


class Patch(NamedTuple):
    """Triangles that close a hole.

    Attributes:
        points: (k + a, 3) the vertices of the rim, then the new ones.
        sizes: (k + a,) the target length of the edges at each.
        triangles: (b, 3) indices of `points`.
        n_rim: k.
    """

    points: Floats
    sizes: Floats
    triangles: Ints
    n_rim: int


def refined_patch(patch: Patch, *, forbidden: Bools | None = None, density: float = DENSITY) -> Patch:
    """Splits triangles at their centroids until they are as small as the edges of the rim, and flips edges, in turn [liepa2003].

    A triangle is split if, for each of its corners, `density` times the distance to the centroid exceeds both the size of the
    corner and the size of the centroid, which is the mean of the three. After each round edges are flipped until at none the two
    opposite angles sum to more than pi: the local Delaunay criterion of the two triangles unfolded into a plane. A flip is not
    made if it would fold the surface over, double an edge or not lessen the sum. In the end the edges that still join two
    vertices of the rim are split at their middles, except in cracks: a triangle between such an edge and the rim would have no
    vertex that fairing could move. Edges of the rim stay.

    Args:
        patch: a patch with points on the rim alone, or a refined patch whose points have moved.
        forbidden: (k, k) which pairs of vertices of the rim must not be joined because they are joined outside the patch. An edge
            of the patch between such a pair is split. On the diagonal: the vertices that the rim meets twice, at which flips
            make no edges.
        density: larger gives smaller triangles, their size in proportion to 1 / density.
    """
    n_rim = patch.n_rim
    forbidden = np.zeros((n_rim, n_rim), dtype=np.bool_) if forbidden is None else forbidden.copy()
    points, sizes = patch.points, patch.sizes
    triangles = np.ascontiguousarray(patch.triangles, dtype=np.int32).copy()
    across = faces_across(triangles)
    flip_towards_delaunay(points, triangles, across, forbidden)
    for _ in range(_MOST_ROUNDS):
        split = _too_large(points, sizes, triangles, density)
        if not split.any():
            break
        points, sizes, triangles, across = _split(points, sizes, triangles, across, np.flatnonzero(split).astype(np.int32))
        flip_towards_delaunay(points, triangles, across, forbidden)
    points, sizes, triangles = _split_diagonals(points, sizes, triangles, n_rim, forbidden)
    flip_towards_delaunay(points, triangles, faces_across(triangles), forbidden | ~np.eye(n_rim, dtype=np.bool_))
    return Patch(points, sizes, triangles, n_rim)


def _split_diagonals(points: Floats, sizes: Floats, triangles: Ints, n_rim: int, forbidden: Bools) -> tuple[Floats, Floats, Ints]:
    """Splits every edge inside the patch that joins two vertices of the rim, except in cracks, at its middle."""
    # Only the triangles with an edge between vertices of the rim can change.
    concerned = (triangles < n_rim).sum(axis=1) > 1
    rows = triangles[concerned].tolist()
    holder = {(row[k], row[(k + 1) % 3]): t for t, row in enumerate(rows) for k in range(3)}
    middles: list[tuple[int, int]] = []
    inner = [(a, b) for a, b in holder if a < n_rim and b < n_rim and (b, a) in holder]
    if not inner:
        return points, sizes, triangles
    # Every edge is in the list in both directions; the second time it is split already.
    for a, b in inner:
        if (a, b) not in holder:
            continue
        if not forbidden[a, b]:
            heights = [_height(points[rows[holder[edge]]]) for edge in ((a, b), (b, a)) if max(rows[holder[edge]]) < len(points)]
            if heights and min(heights) < _CRACK * (sizes[a] + sizes[b]) / 2.0:
                continue
        v = len(points) + len(middles)
        middles.append((a, b))
        for start, end in ((a, b), (b, a)):
            t = holder.pop((start, end))
            apex = rows[t][(rows[t].index(start) + 2) % 3]
            holder[end, apex] = len(rows)
            rows[t] = [start, v, apex]
            rows.append([v, end, apex])
    ends = np.array(middles, dtype=np.int32).reshape(-1, 2)
    return (
        np.concatenate([points, points[ends].mean(axis=1)]),
        np.concatenate([sizes, sizes[ends].mean(axis=1)]),
        np.concatenate([triangles[~concerned], np.array(rows, dtype=np.int32)]),
    )


def _height(triangle: Floats) -> float:
    """The least height of a triangle; 0 if its vertices coincide."""
    a, b, c = triangle
    longest = float(np.sqrt(max(((b - a) ** 2).sum(), ((c - b) ** 2).sum(), ((a - c) ** 2).sum())))
    return float(np.linalg.norm(np.cross(b - a, c - a))) / longest if longest > 0.0 else 0.0


def _too_large(points: Floats, sizes: Floats, triangles: Ints, density: float) -> Bools:
    centroids, size = points[triangles].mean(axis=1), sizes[triangles].mean(axis=1)
    reach = density * np.linalg.norm(points[triangles] - centroids[:, None], axis=2)
    large: Bools = ((reach > size[:, None]) & (reach > sizes[triangles])).all(axis=1)
    return large


def _split(points: Floats, sizes: Floats, triangles: Ints, across: Ints, chosen: Ints) -> tuple[Floats, Floats, Ints, Ints]:
    """Replaces each chosen triangle by three round its centroid: the first in its row, the other two at the end."""
    new = len(points) + np.arange(len(chosen), dtype=np.int32)
    second = (len(triangles) + 2 * np.arange(len(chosen))).astype(np.int32)
    more = np.full((2 * len(chosen), 3), -1, dtype=np.int32)
    grown, beyond = np.concatenate([triangles, more]), np.concatenate([across, more])
    _write_split(grown, beyond, chosen, new, second)
    return (
        np.concatenate([points, points[triangles[chosen]].mean(axis=1)]),
        np.concatenate([sizes, sizes[triangles[chosen]].mean(axis=1)]),
        grown,
        beyond,
    )


@compiled
def _write_split(triangles: Ints, across: Ints, chosen: Ints, new: Ints, second: Ints) -> None:
    for k in range(chosen.shape[0]):
        t, s = chosen[k], second[k]
        a, b, c, v = triangles[t, 0], triangles[t, 1], triangles[t, 2], new[k]
        beyond_bc, beyond_ca = across[t, 1], across[t, 2]
        triangles[t, 2] = v
        across[t, 1], across[t, 2] = s, s + 1
        triangles[s, 0], triangles[s, 1], triangles[s, 2] = b, c, v
        across[s, 0], across[s, 1], across[s, 2] = beyond_bc, s + 1, t
        triangles[s + 1, 0], triangles[s + 1, 1], triangles[s + 1, 2] = c, a, v
        across[s + 1, 0], across[s + 1, 1], across[s + 1, 2] = beyond_ca, t, s
        relink(triangles, across, beyond_bc, b, c, s)
        relink(triangles, across, beyond_ca, c, a, s + 1)

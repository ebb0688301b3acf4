"""A triangulated hole made as dense as its rim, with edges flipped towards Delaunay."""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints
from ..topology import faces_across, relink
from .delaunay_flips import flip_towards_delaunay
from .grading import Growth
from .vertex_pairs import ForbiddenEdges, nothing_forbidden

#: A triangle is split if its centroid, times this, is farther from each corner than the edges there are long [liepa2003].
DENSITY = np.sqrt(2.0)

# Edges between two vertices of the rim are not split at triangles whose height is below this share of the edge length there:
# between the sides of a crack a new vertex has no room to move.
_CRACK = 0.25
_MOST_ROUNDS = 60
# A patch is not split into more vertices, whatever sizes are given. With a width by `uniform_width` none comes near.
_MOST_POINTS = 300_000
# After so many rounds half of the work counts as done: how many there will be is not known before.
_HALF = 8


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


def refined_patch(
    patch: Patch,
    *,
    forbidden: ForbiddenEdges | None = None,
    density: float = DENSITY,
    uniform: float = np.inf,
    progress: Progress = ignore_progress,
) -> Patch:
    """Splits triangles at their centroids until they are as small as the edges of the rim, and flips edges, in turn [liepa2003].

    A triangle is split if, for each of its corners, `density` times the distance to the centroid exceeds both the size of the
    corner and the size of the centroid, which is the mean of the three. After each round edges are flipped until at none the two
    opposite angles sum to more than pi: the local Delaunay criterion of the two triangles unfolded into a plane. A flip is not
    made if it would fold the surface over, double an edge or not lessen the sum. In the end the edges that still join two
    vertices of the rim are split at their middles, except in cracks: a triangle between such an edge and the rim would have no
    vertex that fairing could move. Edges of the rim stay. A patch of 300,000 vertices is not split any further.

    Args:
        patch: a patch with points on the rim alone, or a refined patch whose points have moved.
        forbidden: which pairs of vertices of the rim must not be joined because they are joined outside the patch. An edge
            of the patch between such a pair is split. `alone` are the vertices that the rim meets twice.
        density: larger gives smaller triangles, their size in proportion to 1 / density.
        uniform: from how many edges from the rim on triangles may be larger, as `Growth` says.
        progress: called with the share that is done after each round; may raise to stop.
    """
    n_rim = patch.n_rim
    limits = forbidden or nothing_forbidden(n_rim)
    points, sizes = patch.points, patch.sizes
    growth = Growth(points[:n_rim], uniform)
    targets = sizes * growth.at(points, sizes)
    triangles = np.ascontiguousarray(patch.triangles, dtype=np.int32).copy()
    across = faces_across(triangles)
    flip_towards_delaunay(points, triangles, across, limits.pairs.keys, limits.apart, limits.alone)
    for done in range(_MOST_ROUNDS):
        progress(done / (done + _HALF))
        split = np.flatnonzero(_too_large(points, targets, triangles, density)).astype(np.int32)
        if len(split) == 0 or len(points) + len(split) > _MOST_POINTS:
            break
        centres = points[triangles[split]].mean(axis=1)
        sizes = np.concatenate([sizes, means := sizes[triangles[split]].mean(axis=1)])
        targets = np.concatenate([targets, means * growth.at(centres, means)])
        triangles, across = _split(len(points), triangles, across, split)
        points = np.concatenate([points, centres])
        flip_towards_delaunay(points, triangles, across, limits.pairs.keys, limits.apart, limits.alone)
    points, sizes, triangles = _split_diagonals(points, sizes, triangles, n_rim, limits)
    apart = np.ones(n_rim, dtype=np.bool_)
    flip_towards_delaunay(points, triangles, faces_across(triangles), limits.pairs.keys, apart, limits.alone)
    return Patch(points, sizes, triangles, n_rim)


def _split_diagonals(
    points: Floats, sizes: Floats, triangles: Ints, n_rim: int, forbidden: ForbiddenEdges
) -> tuple[Floats, Floats, Ints]:
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
        if not forbidden.has(a, b):
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


def _split(count: int, triangles: Ints, across: Ints, chosen: Ints) -> tuple[Ints, Ints]:
    """Replaces each chosen triangle by three round a new point, from `count` on: the first in its row, the others at the end."""
    new = count + np.arange(len(chosen), dtype=np.int32)
    second = (len(triangles) + 2 * np.arange(len(chosen))).astype(np.int32)
    more = np.full((2 * len(chosen), 3), -1, dtype=np.int32)
    grown, beyond = np.concatenate([triangles, more]), np.concatenate([across, more])
    _write_split(grown, beyond, chosen, new, second)
    return grown, beyond


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

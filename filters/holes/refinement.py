"""A triangulated hole made as dense as its rim, with edges flipped towards Delaunay."""

from typing import NamedTuple

import numpy as np
from numba import njit

from ..mesh import Bools, Floats, Ints
from .flips import flip_towards_delaunay, relink

#: A triangle is split when its centroid is farther from each corner, times this, than the edges there are long [liepa2003].
DENSITY = np.sqrt(2.0)

# Triangles between vertices of the rim whose height is below this share of the size there get no vertex on an edge: between the
# sides of a crack there is no room for one to move.
_CRACK = 0.25
_MOST_ROUNDS = 60


class Patch(NamedTuple):
    """Triangles that close a hole.

    Attributes:
        points: (k + a, 3) the vertices of the rim, then the new ones.
        sizes: (k + a,) how long the edges at each are to be.
        triangles: (b, 3) indices of `points`.
        n_rim: k.
    """

    points: Floats
    sizes: Floats
    triangles: Ints
    n_rim: int


def refined_patch(patch: Patch, *, forbidden: Bools | None = None, density: float = DENSITY) -> Patch:
    """Splits triangles at their centroids until they are as small as the edges of the rim, and flips edges, in turn [liepa2003].

    A triangle is split when, for each of its corners, `density` times the distance to the centroid exceeds both the size of the
    corner and that of the centroid, which is the mean of the three. After each round edges are flipped until at none the two
    opposite angles sum to more than pi; that is the local Delaunay criterion of the two triangles unfolded into a plane. A flip
    that would fold the surface over, double an edge or not lessen the sum is not done. In the end the edges that still
    join two vertices of the rim are split in their middles, but in cracks: without, a triangle between such an edge and the rim
    has no vertex that fairing could move. Edges of the rim stay.

    Args:
        patch: points on the rim alone, or a refined patch whose points have moved.
        forbidden: (k, k) which pairs of the rim must not be joined, those joined outside the patch. An edge of the patch between
            such a pair is split. On the diagonal: which vertices get no further edges by flips, those that the rim meets twice.
        density: larger gives smaller triangles, their size in proportion to 1 / density.
    """
    n_rim = patch.n_rim
    forbidden = np.zeros((n_rim, n_rim), dtype=np.bool_) if forbidden is None else forbidden.copy()
    points, sizes = patch.points, patch.sizes
    corners = np.ascontiguousarray(patch.triangles, dtype=np.int32).copy()
    across = _neighbours(corners)
    flip_towards_delaunay(points, corners, across, forbidden)
    for _ in range(_MOST_ROUNDS):
        split = _too_large(points, sizes, corners, density)
        if not split.any():
            break
        points, sizes, corners, across = _split(points, sizes, corners, across, np.flatnonzero(split).astype(np.int32))
        flip_towards_delaunay(points, corners, across, forbidden)
    points, sizes, corners = _split_diagonals(points, sizes, corners, n_rim, forbidden)
    flip_towards_delaunay(points, corners, _neighbours(corners), forbidden | ~np.eye(n_rim, dtype=np.bool_))
    return Patch(points, sizes, corners, n_rim)


def _split_diagonals(points: Floats, sizes: Floats, corners: Ints, n_rim: int, forbidden: Bools) -> tuple[Floats, Floats, Ints]:
    """A vertex in the middle of every edge inside the patch that joins two vertices of the rim, those in cracks excepted."""
    # The triangles with an edge between vertices of the rim, and no others, are taken apart.
    concerned = (corners < n_rim).sum(axis=1) > 1
    rows = corners[concerned].tolist()
    holder = {(row[k], row[(k + 1) % 3]): t for t, row in enumerate(rows) for k in range(3)}
    middles: list[tuple[int, int]] = []
    inner = [(a, b) for a, b in holder if a < n_rim and b < n_rim and (b, a) in holder]
    if not inner:
        return points, sizes, corners
    # Each from both sides, the second time it is split already.
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
        np.concatenate([corners[~concerned], np.array(rows, dtype=np.int32)]),
    )


def _height(triangle: Floats) -> float:
    """The least height of a triangle, 0 if it has no sides."""
    a, b, c = triangle
    longest = float(np.sqrt(max(((b - a) ** 2).sum(), ((c - b) ** 2).sum(), ((a - c) ** 2).sum())))
    return float(np.linalg.norm(np.cross(b - a, c - a))) / longest if longest > 0.0 else 0.0


def _neighbours(corners: Ints) -> Ints:
    """(b, 3) the triangle across the edge from corner k to the next, -1 at the rim."""
    n = int(corners.max()) + 1
    starts, ends = corners.T.ravel().astype(np.int64), np.roll(corners, -1, axis=1).T.ravel().astype(np.int64)
    keys, partners = starts * n + ends, ends * n + starts
    order = np.argsort(keys, kind="stable")
    place = np.minimum(np.searchsorted(keys[order], partners), len(keys) - 1)
    found = keys[order][place] == partners
    across = np.where(found, order[place] % len(corners), -1)
    return np.ascontiguousarray(across.reshape(3, -1).T, dtype=np.int32)


def _too_large(points: Floats, sizes: Floats, corners: Ints, density: float) -> Bools:
    centroids, size = points[corners].mean(axis=1), sizes[corners].mean(axis=1)
    reach = density * np.linalg.norm(points[corners] - centroids[:, None], axis=2)
    large: Bools = ((reach > size[:, None]) & (reach > sizes[corners])).all(axis=1)
    return large


def _split(points: Floats, sizes: Floats, corners: Ints, across: Ints, chosen: Ints) -> tuple[Floats, Floats, Ints, Ints]:
    """Each chosen triangle replaced by three round its centroid: the first in its place, the others at the end."""
    new = len(points) + np.arange(len(chosen), dtype=np.int32)
    second = (len(corners) + 2 * np.arange(len(chosen))).astype(np.int32)
    more = np.full((2 * len(chosen), 3), -1, dtype=np.int32)
    grown, beyond = np.concatenate([corners, more]), np.concatenate([across, more])
    _write_split(grown, beyond, chosen, new, second)
    return (
        np.concatenate([points, points[corners[chosen]].mean(axis=1)]),
        np.concatenate([sizes, sizes[corners[chosen]].mean(axis=1)]),
        grown,
        beyond,
    )


@njit(cache=True)
def _write_split(corners: Ints, across: Ints, chosen: Ints, new: Ints, second: Ints) -> None:
    for k in range(chosen.shape[0]):
        t, s = chosen[k], second[k]
        a, b, c, v = corners[t, 0], corners[t, 1], corners[t, 2], new[k]
        beyond_bc, beyond_ca = across[t, 1], across[t, 2]
        corners[t, 2] = v
        across[t, 1], across[t, 2] = s, s + 1
        corners[s, 0], corners[s, 1], corners[s, 2] = b, c, v
        across[s, 0], across[s, 1], across[s, 2] = beyond_bc, s + 1, t
        corners[s + 1, 0], corners[s + 1, 1], corners[s + 1, 2] = c, a, v
        across[s + 1, 0], across[s + 1, 1], across[s + 1, 2] = beyond_ca, t, s
        relink(across, corners, beyond_bc, b, c, s)
        relink(across, corners, beyond_ca, c, a, s + 1)

"""Parts of a triangulated polygon triangulated anew, where that bends less."""

from collections import deque

import numpy as np

from ..execution import ignore_progress
from ..geometry import cross_products
from ..mesh import Floats, Ints
from .minimal_triangulation import minimal_triangulation
from .vertex_pairs import VertexPairs

#: How many triangles around a chord are replaced together.
WINDOW = 120
# Angles, as 1 - cos, that differ by less count as the same.
_SAME = 1e-9


def retriangulated(
    triangles: Ints, chords: list[tuple[int, int]], points: Floats, opposite: Floats, forbidden: VertexPairs
) -> Ints:
    """A triangulation in which the triangles around each chord are replaced by better ones, if there are any.

    The `WINDOW` triangles nearest to a chord, by the number of edges crossed, form a polygon, since a triangulated polygon is a
    tree of triangles. `minimal_triangulation` triangulates it anew, with the triangles around as neighbours, and its triangles
    are taken if their (largest dihedral angle, area) is less.

    Args:
        triangles: (k - 2, 3) corners from 0 to k - 1, in the orientation of the polygon.
        chords: the two corners of each.
        points: (k, 3) the corners, with coordinates of ordinary size.
        opposite: (k, 3) the third vertex of the face of the mesh at the side from i to i + 1; NaN if there is none.
        forbidden: which diagonals must not be used.
    """
    if not chords:
        return triangles
    n = len(points)
    rows = triangles.copy()
    holder = {(int(row[k]), int(row[(k + 1) % 3])): t for t, row in enumerate(rows) for k in range(3)}
    for a, b in chords:
        first = holder.get((a, b))
        if first is None:
            continue  # no longer an edge
        chosen = _nearest(rows, holder, first)
        corners = np.unique(rows[chosen]).astype(np.int32)
        across = np.full((len(corners), 3), np.nan)
        for i, (u, v) in enumerate(zip(corners.tolist(), np.roll(corners, -1).tolist(), strict=True)):
            t = holder.get((v, u))
            across[i] = opposite[u] if t is None else points[int(rows[t].sum()) - u - v]
        better = minimal_triangulation(points[corners], across, forbidden.among(corners), ignore_progress)
        if better is None:
            continue
        before = np.searchsorted(corners, rows[chosen]).astype(np.int32)
        if _is_less(_energy(points[corners], across, better), _energy(points[corners], across, before)):
            for t in chosen:
                for k in range(3):
                    del holder[int(rows[t, k]), int(rows[t, (k + 1) % 3])]
            rows[chosen] = corners[better]
            for t in chosen:
                for k in range(3):
                    holder[int(rows[t, k]), int(rows[t, (k + 1) % 3])] = t
    assert len(holder) == 3 * (n - 2)
    return rows


def _nearest(rows: Ints, holder: dict[tuple[int, int], int], first: int) -> list[int]:
    """The triangles that are fewest edges away from the first, in ascending order."""
    found, queue = {first}, deque([first])
    while queue and len(found) < WINDOW:
        row = rows[queue.popleft()].tolist()
        for k in range(3):
            t = holder.get((row[(k + 1) % 3], row[k]))
            if t is not None and t not in found and len(found) < WINDOW:
                found.add(t)
                queue.append(t)
    return sorted(found)


def _energy(points: Floats, across: Floats, triangles: Ints) -> tuple[float, float]:
    """The largest angle of the triangles with each other and the faces across the sides, as 1 - cos, and their doubled area."""
    n = len(points)
    normals = cross_products(points, triangles)
    areas = np.linalg.norm(normals, axis=1)
    if (areas == 0.0).any():
        return np.inf, np.inf
    normals /= areas[:, None]
    sides = np.arange(n)
    beyond = np.cross(points[sides] - points[(sides + 1) % n], across - points[(sides + 1) % n])
    lengths = np.linalg.norm(beyond, axis=1)
    owner = {(int(row[k]), int(row[(k + 1) % 3])): t for t, row in enumerate(triangles) for k in range(3)}
    worst = 0.0
    for (u, v), t in owner.items():
        other = owner.get((v, u))
        if other is not None:
            worst = max(worst, 1.0 - float(normals[t] @ normals[other]))
        elif lengths[u] > 0.0:
            worst = max(worst, 1.0 - float(normals[t] @ beyond[u]) / float(lengths[u]))
    return worst, float(areas.sum())


def _is_less(one: tuple[float, float], other: tuple[float, float]) -> bool:
    return one[0] < other[0] - _SAME or (one[0] <= other[0] + _SAME and one[1] < other[1])

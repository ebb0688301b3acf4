"""A rim closed with triangles between its own vertices, as flat and as smooth at the rim as can be."""

import numpy as np
from numba import njit

from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints

#: Rims with more vertices than this are cut in two by a short chord first; the time grows with the cube of this, the memory with
#: the square.
LARGEST_WHOLE = 800

# A triangle whose doubled area is below this share of its summed squared edges is degenerate.
_THINNEST = 1e-7
# Angles that differ by less count as the same, so that ties are decided by area and not by rounding.
_SAME = 1e-9
# About as many triangles are tried between two calls of `progress`.
_BATCH = 20_000_000


def triangulate_rim(
    points: Floats, opposite: Floats, forbidden: Bools, *, progress: Progress = ignore_progress, whole: int = LARGEST_WHOLE
) -> Ints | None:
    """The triangulation of a rim that minimises (largest dihedral angle, area), compared in this order [liepa2003].

    By dynamic programming: the best triangulation of the part of the rim from i to j is, for the best vertex m between, the
    triangle (i, m, j) on top of the best ones from i to m and from m to j. Dihedral angles are those at the new edges and at
    the rim, between the normals of the two triangles there, 0 if they go on in the same plane; so the quantity of a part depends
    on its last triangle, and the minimum is that of the parts that were kept, as in the paper. Time O(k^3).

    A rim of more than `whole` vertices is cut in two by the chord that is shortest compared with the rim between its
    ends, again and again; the parts are triangulated one after the other, each seeing the triangles of those before it.

    Args:
        points: (k, 3) the vertices of the rim in order, in the direction of the new faces.
        opposite: (k, 3) the third vertex of the face of the mesh at the edge from i to i + 1.
        forbidden: (k, k) symmetric, which diagonals must not be used: those that are edges of the mesh.
        progress: called now and then with the share that is done; may raise to stop.
        whole: the largest part that is triangulated at once, from 4.

    Returns:
        (k - 2, 3) indices from 0 to k - 1, in the rim's orientation; None if there is no triangulation without degenerate
        triangles and forbidden diagonals.
    """
    n = len(points)
    size = float(np.abs(points - points.mean(axis=0)).max())
    if n < 3 or not size > 0.0:
        return None
    # Products of four lengths stay in range whatever the unit.
    centre = points.mean(axis=0)
    p, q = (points - centre) / size, (opposite - centre) / size
    parts = [(np.arange(n, dtype=np.int32), q)]
    done: list[Ints] = []
    while parts:
        corners, across = parts.pop()
        if len(corners) > whole:
            i, j = _chord(p[corners], forbidden[np.ix_(corners, corners)])
            if i >= 0:
                # The part from i to j is done first; its triangle at the chord is then the neighbour of the other part.
                rest = np.concatenate([corners[: i + 1], corners[j:]])
                parts.append((rest, np.concatenate([across[:i], np.full((1, 3), np.nan), across[j:]])))
                parts.append((corners[i : j + 1], np.concatenate([across[i:j], np.full((1, 3), np.nan)])))
                continue
        for k in np.flatnonzero(np.isnan(across[:, 0])):
            across[k] = _apex(done, int(corners[k]), int(corners[(k + 1) % len(corners)]), p)
        before, own = sum(map(len, done)), len(corners) - 2

        def partial(share: float, before: int = before, own: int = own) -> None:
            progress((before + own * share) / (n - 2))

        triangles = _triangulate(p[corners], across, forbidden[np.ix_(corners, corners)], partial)
        if triangles is None:
            return None
        done.append(corners[triangles])
    return np.concatenate(done)


def _apex(done: list[Ints], a: int, b: int, points: Floats) -> Floats:
    """The third vertex of the triangle made already that has the edge from b to a; without one no number."""
    for triangles in done:
        for k in range(3):
            found = np.flatnonzero((triangles[:, k] == b) & (triangles[:, (k + 1) % 3] == a))
            if len(found):
                return np.asarray(points[triangles[found[0], (k + 2) % 3]])
    return np.full(3, np.nan)


def _triangulate(p: Floats, q: Floats, forbidden: Bools, progress: Progress) -> Ints | None:
    n = len(p)
    angle, area = np.full((n, n), np.inf), np.full((n, n), np.inf)
    split = np.full((n, n), -1, dtype=np.int32)
    normals = np.zeros((n, n, 3))
    for i in range(n - 1):
        angle[i, i + 1] = area[i, i + 1] = 0.0
    rim_normals = np.zeros((n, 3))
    _rim_normals(p, q, rim_normals)
    span = 2
    while span < n:
        until = span
        tried = 0
        while until < n and (tried == 0 or tried < _BATCH):
            tried += (n - until) * until
            until += 1
        _solve(p, rim_normals, forbidden, span, until, angle, area, split, normals)
        span = until
        progress(span / n)
    if split[0, n - 1] < 0:
        return None
    return _collect(split)


@njit(cache=True)
def _rim_normals(p: Floats, q: Floats, normals: Floats) -> None:
    """The unit normals of the faces of the mesh at the rim, 0 if they have none."""
    n = p.shape[0]
    for i in range(n):
        j = (i + 1) % n
        x, y, z = _unit_normal(p[j, 0], p[j, 1], p[j, 2], p[i, 0], p[i, 1], p[i, 2], q[i, 0], q[i, 1], q[i, 2])[:3]
        normals[i, 0], normals[i, 1], normals[i, 2] = x, y, z


@njit(cache=True)
def _unit_normal(
    ax: float, ay: float, az: float, bx: float, by: float, bz: float, cx: float, cy: float, cz: float
) -> tuple[float, float, float, float]:
    """The unit normal of the triangle and its doubled area; zeros if it is degenerate."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    wx, wy, wz = cx - bx, cy - by, cz - bz
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    area = np.sqrt(nx * nx + ny * ny + nz * nz)
    sum_of_squares = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz + wx * wx + wy * wy + wz * wz
    if not area > _THINNEST * sum_of_squares:
        return 0.0, 0.0, 0.0, 0.0
    return nx / area, ny / area, nz / area, area


@njit(cache=True)
def _bend(ax: float, ay: float, az: float, b: Floats) -> float:
    """1 - cos of the angle between two unit normals, which grows with it; 0 if the second is none."""
    if b[0] == 0.0 and b[1] == 0.0 and b[2] == 0.0:
        return 0.0
    cosine: float = ax * b[0] + ay * b[1] + az * b[2]
    return 1.0 - cosine


@njit(cache=True)
def _solve(
    p: Floats,
    rim_normals: Floats,
    forbidden: Bools,
    span_from: int,
    span_to: int,
    angle: Floats,
    area: Floats,
    split: Ints,
    normals: Floats,
) -> None:
    """Fill in the best triangulations of all parts of the rim with `span_from` up to below `span_to` edges."""
    n = p.shape[0]
    for span in range(span_from, span_to):
        for i in range(n - span):
            j = i + span
            last = span == n - 1
            if forbidden[i, j] and not last:
                continue
            best_angle, best_area = np.inf, np.inf
            for m in range(i + 1, j):
                worst = max(angle[i, m], angle[m, j])
                if worst > best_angle + _SAME or worst == np.inf:
                    continue
                x, y, z, doubled = _unit_normal(p[i, 0], p[i, 1], p[i, 2], p[m, 0], p[m, 1], p[m, 2], p[j, 0], p[j, 1], p[j, 2])
                if doubled == 0.0:
                    continue
                worst = max(worst, _bend(x, y, z, rim_normals[i] if m == i + 1 else normals[i, m]))
                worst = max(worst, _bend(x, y, z, rim_normals[m] if j == m + 1 else normals[m, j]))
                if last:
                    worst = max(worst, _bend(x, y, z, rim_normals[j]))
                total = area[i, m] + area[m, j] + doubled
                if worst < best_angle - _SAME or (worst <= best_angle + _SAME and total < best_area):
                    best_angle, best_area = worst, total
                    angle[i, j], area[i, j], split[i, j] = worst, total, m
                    normals[i, j, 0], normals[i, j, 1], normals[i, j, 2] = x, y, z


@njit(cache=True)
def _collect(split: Ints) -> Ints:
    n = split.shape[0]
    triangles = np.empty((n - 2, 3), dtype=np.int32)
    stack = np.empty((n, 2), dtype=np.int32)
    stack[0, 0], stack[0, 1] = 0, n - 1
    height, found = 1, 0
    while height > 0:
        height -= 1
        i, j = stack[height, 0], stack[height, 1]
        if j - i < 2:
            continue
        m = split[i, j]
        triangles[found, 0], triangles[found, 1], triangles[found, 2] = i, m, j
        found += 1
        stack[height, 0], stack[height, 1] = m, j
        stack[height + 1, 0], stack[height + 1, 1] = i, m
        height += 2
    return triangles


@njit(cache=True)
def _chord(p: Floats, forbidden: Bools) -> tuple[int, int]:
    """The diagonal that is shortest compared with the shorter way along the rim between its ends, both parts of a quarter up."""
    n = p.shape[0]
    along = np.zeros(n + 1)
    for i in range(n):
        j = (i + 1) % n
        along[i + 1] = along[i] + np.sqrt((p[j, 0] - p[i, 0]) ** 2 + (p[j, 1] - p[i, 1]) ** 2 + (p[j, 2] - p[i, 2]) ** 2)
    best, best_i, best_j = np.inf, -1, -1
    for i in range(n):
        for j in range(i + n // 4, min(n, i + n - n // 4)):
            if forbidden[i, j]:
                continue
            way = min(along[j] - along[i], along[n] - along[j] + along[i])
            length = np.sqrt((p[j, 0] - p[i, 0]) ** 2 + (p[j, 1] - p[i, 1]) ** 2 + (p[j, 2] - p[i, 2]) ** 2)
            if length > 0.0 and length < best * way:
                best, best_i, best_j = length / way, i, j
    return best_i, best_j

"""The triangulation of a polygon that bends least, by dynamic programming."""

import numpy as np

from ..compilation import compiled
from ..execution import Progress
from ..mesh import Bools, Floats, Ints

# A triangle whose doubled area is below this share of its summed squared edges is degenerate.
_THINNEST = 1e-7
# Angles that differ by less count as the same, so that ties are decided by area and not by rounding.
_SAME = 1e-9
# So do areas that differ by less than this share, the rounding of sums of some hundred of them.
_SAME_AREA = 1e-12
# The number of triangles tried between two calls of `progress`, about.
_BATCH = 20_000_000


def minimal_triangulation(points: Floats, opposite: Floats, forbidden: Bools, progress: Progress) -> Ints | None:
    """The triangulation of a closed polygon that minimises (largest dihedral angle, area), compared in this order [liepa2003].

    By dynamic programming: the best triangulation of the part of the polygon from i to j is, for the best vertex m between, the
    triangle (i, m, j) and the best ones from i to m and from m to j. Dihedral angles are those between the normals of the two
    triangles at the new edges and at the sides, 0 if both lie in one plane. So the angle of a part depends on its last triangle,
    and the minimum is taken over the parts that were kept, as in the paper. Time O(k^3).

    Args:
        points: (k, 3) the corners of the polygon, with coordinates of ordinary size.
        opposite: (k, 3) the third vertex of the face of the mesh at the side from i to i + 1; NaN if there is none.
        forbidden: (k, k) symmetric, which diagonals must not be used.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (k - 2, 3) indices from 0 to k - 1 in the orientation of the polygon; None if all triangulations have degenerate triangles
        or forbidden diagonals.
    """
    n = len(points)
    angle, area = np.full((n, n), np.inf), np.full((n, n), np.inf)
    split = np.full((n, n), -1, dtype=np.int32)
    normals = np.zeros((n, n, 3))
    for i in range(n - 1):
        angle[i, i + 1] = area[i, i + 1] = 0.0
    side_normals = np.zeros((n, 3))
    _find_side_normals(points, opposite, side_normals)
    span = 2
    while span < n:
        until = span
        tried = 0
        while until < n and (tried == 0 or tried < _BATCH):
            tried += (n - until) * until
            until += 1
        _solve(points, side_normals, forbidden, span, until, angle, area, split, normals)
        span = until
        progress(span / n)
    if split[0, n - 1] < 0:
        return None
    return _collect(split)


@compiled
def _find_side_normals(p: Floats, q: Floats, normals: Floats) -> None:
    """Write the unit normals of the faces of the mesh at the sides, 0 where there is no face or it is degenerate."""
    n = p.shape[0]
    for i in range(n):
        j = (i + 1) % n
        x, y, z = _unit_normal(p[j, 0], p[j, 1], p[j, 2], p[i, 0], p[i, 1], p[i, 2], q[i, 0], q[i, 1], q[i, 2])[:3]
        normals[i, 0], normals[i, 1], normals[i, 2] = x, y, z


@compiled
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


@compiled
def _bend(ax: float, ay: float, az: float, b: Floats) -> float:
    """1 - cos of the angle between two unit normals, which grows with the angle; 0 if the second normal is 0."""
    if b[0] == 0.0 and b[1] == 0.0 and b[2] == 0.0:
        return 0.0
    cosine: float = ax * b[0] + ay * b[1] + az * b[2]
    return 1.0 - cosine


@compiled
def _solve(
    p: Floats,
    side_normals: Floats,
    forbidden: Bools,
    span_from: int,
    span_to: int,
    angle: Floats,
    area: Floats,
    split: Ints,
    normals: Floats,
) -> None:
    """Enter the best triangulations of all parts of the polygon with `span_from` to less than `span_to` sides."""
    n = p.shape[0]
    for span in range(span_from, span_to):
        for i in range(n - span):
            j = i + span
            last = span == n - 1
            if forbidden[i, j] and not last:
                continue
            best_angle, best_area, best_skew = np.inf, np.inf, n
            for m in range(i + 1, j):
                worst = max(angle[i, m], angle[m, j])
                if worst > best_angle + _SAME or worst == np.inf:
                    continue
                x, y, z, doubled = _unit_normal(p[i, 0], p[i, 1], p[i, 2], p[m, 0], p[m, 1], p[m, 2], p[j, 0], p[j, 1], p[j, 2])
                if doubled == 0.0:
                    continue
                worst = max(worst, _bend(x, y, z, side_normals[i] if m == i + 1 else normals[i, m]))
                worst = max(worst, _bend(x, y, z, side_normals[m] if j == m + 1 else normals[m, j]))
                if last:
                    worst = max(worst, _bend(x, y, z, side_normals[j]))
                total = area[i, m] + area[m, j] + doubled
                if not _is_better(worst, total, abs(2 * m - i - j), best_angle, best_area, best_skew):
                    continue
                best_angle, best_area, best_skew = worst, total, abs(2 * m - i - j)
                angle[i, j], area[i, j], split[i, j] = worst, total, m
                normals[i, j, 0], normals[i, j, 1], normals[i, j, 2] = x, y, z


@compiled
def _is_better(angle: float, area: float, skew: int, best_angle: float, best_area: float, best_skew: int) -> bool:
    """Whether a split is to replace the best so far: by angle, then by area, then for the evener one.

    In a flat polygon all triangulations have the same angles and areas, and rounding would choose fans of needles.
    """
    if angle < best_angle - _SAME:
        return True
    if angle > best_angle + _SAME or area > best_area * (1.0 + _SAME_AREA):
        return False
    return area < best_area * (1.0 - _SAME_AREA) or skew < best_skew


@compiled
def _collect(split: Ints) -> Ints:
    """The triangles (i, split[i, j], j), from the whole polygon down."""
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

"""Triangulation, the first step of hole filling [liepa2003]: a rim closed with triangles between its own vertices.

The rim becomes a polygon that cuts join with the islands in the hole.
"""

from collections import deque
from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..execution import Progress, ignore_progress, part_of
from ..geometry import cross_product, cross_products, side_lengths, squared_length
from ..libraries import sparse, spatial
from ..mesh import Bools, Floats, Ints, Longs
from ..topology import BoundaryLoop, OneRings
from .vertex_pairs import VertexPairs, is_pair, vertex_pairs

#: A rim with more vertices than this is first cut in two by a short chord: time grows with the cube of this, memory with the
#: square.
LARGEST_WHOLE = 300
# A triangle whose doubled area is below this share of its summed squared edges is degenerate.
_THINNEST = 1e-7
# Angles that differ by less count as the same, so that ties are decided by area and not by rounding.
_SAME = 1e-9
# So do areas that differ by less than this share, the rounding of sums of some hundred of them.
_SAME_AREA = 1e-12
# The number of triangles tried between two calls of `progress`, about.
_BATCH = 20_000_000
#: The number of triangles around a chord that are replaced together.
WINDOW = 120
# The most triangulations of a polygon that are tried.
_MOST_TRIES = 20


class Polygon(NamedTuple):
    """A closed walk along border edges, and to an island and back along a cut."""

    # (k,) int32 of the mesh, one a corner of the polygon. A vertex is several corners where a cut begins or ends, and where parts
    # of the surface are attached by it alone.
    vertices: Ints
    opposite: Ints  # (k,) int32 the third vertex of the face of the mesh at the edge from each to the next, -1 at cuts


def polygon(rim: BoundaryLoop, islands: list[BoundaryLoop], points: Floats) -> Polygon:
    """The rim with each island joined by the shortest cut to the polygon so far, the nearest island first.

    It begins after the longest edge of the rim: the triangulation depends slightly on its first corner, which must not depend on
    the numbers of the vertices.
    """
    first = int(side_lengths(points[rim.vertices]).argmax()) + 1
    vertices, opposite = np.roll(rim.vertices, -first), np.roll(rim.opposite, -first)
    rest = list(islands)
    while rest:
        best = (np.inf, 0, 0, 0)
        places, same_as = np.unique(points[vertices], axis=0, return_index=True)
        tree = spatial.cKDTree(places)
        for number, island in enumerate(rest):
            apart, nearest = tree.query(points[island.vertices])
            j = int(apart.argmin())
            best = min(best, (float(apart[j]), number, int(same_as[nearest[j]]), j))
        i, j = best[2:]
        island = rest.pop(best[1])
        around, beyond = np.roll(island.vertices, -j), np.roll(island.opposite, -j)
        # To the island, once round it, back, and on along the rim.
        cut = np.array([-1], dtype=np.int32)
        vertices = np.concatenate([vertices[: i + 1], around, around[:1], vertices[i:]])
        opposite = np.concatenate([opposite[:i], cut, beyond, cut, opposite[i:]])
    return Polygon(vertices, opposite)


def triangulate_polygon(outline: Polygon, points: Floats, joined: VertexPairs, progress: Progress) -> Ints | None:
    """(b, 3) the vertices of triangles that close the polygon, without `joined` diagonals; None if no such surface exists."""
    corners = outline.vertices
    opposite = np.where(outline.opposite[:, None] < 0, np.nan, points[outline.opposite])
    forbidden = joined.with_pairs(*_corners_at_one_vertex(corners))
    for _ in range(_MOST_TRIES):
        triangles = triangulate_rim(points[corners], opposite, forbidden, progress=progress)
        if triangles is None:
            return None
        doubled = _doubled_diagonals(corners, triangles)
        if len(doubled) == 0:
            return np.asarray(corners[triangles])
        # Two corners at one vertex have diagonals to the same vertex: forbid the second.
        forbidden = forbidden.with_pairs(doubled[:, 0], doubled[:, 1])
    return None


def _corners_at_one_vertex(corners: Ints) -> tuple[Longs, Longs]:
    """Every two corners of a polygon that are the same vertex."""
    order = np.argsort(corners, kind="stable")
    first, second = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    step = 1
    while (same := corners[order[step:]] == corners[order[:-step]]).any():
        first.append(order[:-step][same])
        second.append(order[step:][same])
        step += 1
    return np.concatenate(first), np.concatenate(second)


def _doubled_diagonals(corners: Ints, triangles: Ints) -> Longs:
    """(d, 2) the corners of the diagonals that join the same two vertices as another diagonal before them."""
    ends = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    ends, uses = np.unique(ends, axis=0, return_counts=True)
    diagonals = ends[uses == 2]
    _, first = np.unique(np.sort(corners[diagonals], axis=1), axis=0, return_index=True)
    return np.asarray(np.delete(diagonals, first, axis=0), dtype=np.int64)


def joined_corners(corners: Ints, rings: OneRings, more: dict[int, set[int]]) -> VertexPairs:
    """Which corners of a polygon are joined by an edge that is no side of it.

    Args:
        corners: (k,) the vertices of the polygon.
        rings: the neighbours of every vertex of the mesh.
        more: further neighbours of vertices, by edges of the patches made before.
    """
    k = len(corners)
    own, index = np.unique(corners, return_inverse=True)
    ends = [[*rings.neighbours[rings.offsets[v] : rings.offsets[v + 1]], *more.get(v, ())] for v in own.tolist()]
    starts, others = np.repeat(np.arange(len(own)), [len(linked) for linked in ends]), np.concatenate(ends)
    place = np.minimum(np.searchsorted(own, others), len(own) - 1)
    within = own[place] == others
    linked = sparse.csr_array((np.ones(int(within.sum())), (starts[within], place[within])), shape=(len(own), len(own)))
    at = sparse.csr_array((np.ones(k), (np.arange(k), index)), shape=(k, len(own)))
    first, second = (at @ linked @ at.T).nonzero()
    side = (np.abs(first - second) == 1) | (np.abs(first - second) == k - 1)
    return vertex_pairs(k, first[~side], second[~side])


def triangulate_rim(
    points: Floats, opposite: Floats, forbidden: VertexPairs, *, progress: Progress = ignore_progress
) -> Ints | None:
    """The triangulation of a rim that minimises (largest dihedral angle, area), compared in this order [liepa2003].

    A rim of up to `LARGEST_WHOLE` vertices is triangulated by `minimal_triangulation`. A longer one is cut in two by the chord
    that is shortest relative to the rim between its ends, again and again; the parts are triangulated one after the other, each
    with the triangles of those before it as neighbours. Then what lies around each chord is triangulated again, so that it need
    not stay an edge: the result is at least as good as that of the parts.

    Args:
        points: (k, 3) the vertices of the rim in order, in the direction of the new faces.
        opposite: (k, 3) the third vertex of the face of the mesh at the edge from i to i + 1; NaN if there is none.
        forbidden: which diagonals must not be used: those that are edges of the mesh.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (k - 2, 3) indices from 0 to k - 1, in the rim's orientation; None if there is no triangulation without degenerate
        triangles and forbidden diagonals.
    """
    n = len(points)
    size = float(np.abs(points - points.mean(axis=0)).max())
    if n < 3 or not size > 0.0:
        return None
    # Products of four lengths stay in range in any unit.
    centre = points.mean(axis=0)
    p, q = (points - centre) / size, (opposite - centre) / size
    parts = [(np.arange(n, dtype=np.int32), q)]
    done: list[Ints] = []
    chords: list[tuple[int, int]] = []
    while parts:
        part, across = parts.pop()
        if len(part) > LARGEST_WHOLE:
            i, j = _chord(p[part], part, forbidden)
            if i >= 0:
                chords.append((int(part[i]), int(part[j])))
                # The part from i to j is done first; its triangle at the chord is then the neighbour of the other part.
                rest = np.concatenate([part[: i + 1], part[j:]])
                parts.append((rest, np.concatenate([across[:i], np.full((1, 3), np.nan), across[j:]])))
                parts.append((part[i : j + 1], np.concatenate([across[i:j], np.full((1, 3), np.nan)])))
                continue
        for k in np.flatnonzero(np.isnan(across[:, 0])):
            across[k] = _apex(done, int(part[k]), int(part[(k + 1) % len(part)]), p)
        before, own = sum(map(len, done)), len(part) - 2
        partial = part_of(progress, before / (n - 2), (before + own) / (n - 2))
        triangles = minimal_triangulation(p[part], across, forbidden.among(part), partial)
        if triangles is None:
            return None
        done.append(part[triangles])
    return retriangulated(np.concatenate(done), chords, p, q, forbidden)


def _apex(done: list[Ints], a: int, b: int, points: Floats) -> Floats:
    """The third vertex of the triangle with the edge from b to a among those made so far; NaN if there is none."""
    for triangles in done:
        for k in range(3):
            at = np.flatnonzero((triangles[:, k] == b) & (triangles[:, (k + 1) % 3] == a))
            if len(at):
                return np.asarray(points[triangles[at[0], (k + 2) % 3]])
    return np.full(3, np.nan)


@compiled
def _chord(p: Floats, part: Ints, forbidden: VertexPairs) -> tuple[int, int]:
    """The shortest diagonal relative to the shorter way along the rim between its ends; (-1, -1) if all are forbidden.

    Each of the two parts gets at least a quarter of the edges.
    """
    n = p.shape[0]
    along = np.zeros(n + 1)
    for i in range(n):
        j = (i + 1) % n
        along[i + 1] = along[i] + np.sqrt((p[j, 0] - p[i, 0]) ** 2 + (p[j, 1] - p[i, 1]) ** 2 + (p[j, 2] - p[i, 2]) ** 2)
    best, best_i, best_j = np.inf, -1, -1
    for i in range(n):
        for j in range(i + n // 4, min(n, i + n - n // 4)):
            way = min(along[j] - along[i], along[n] - along[j] + along[i])
            length = np.sqrt((p[j, 0] - p[i, 0]) ** 2 + (p[j, 1] - p[i, 1]) ** 2 + (p[j, 2] - p[i, 2]) ** 2)
            if length > 0.0 and length < best * way and not is_pair(forbidden, part[i], part[j]):
                best, best_i, best_j = length / way, i, j
    return best_i, best_j


class _BestParts(NamedTuple):
    """The best triangulation of the part of a polygon from corner i to corner j > i."""

    angle: Floats  # (k, k) its largest dihedral angle, as 1 - cos; infinite if there is none
    area: Floats  # (k, k) its doubled area
    split: Ints  # (k, k) the third corner of its triangle at the side from i to j, -1 if there is none
    normals: Floats  # (k, k, 3) the unit normal of that triangle


def minimal_triangulation(points: Floats, opposite: Floats, forbidden: Bools, progress: Progress) -> Ints | None:
    """The triangulation of a closed polygon that minimises (largest dihedral angle, area), compared in this order [liepa2003].

    By dynamic programming: the best triangulation of the part of the polygon from i to j is, for the best vertex m between, the
    triangle (i, m, j) and the best ones from i to m and from m to j. Dihedral angles are those between the normals of the two
    triangles at the new edges and at the sides, 0 if both lie in one plane. So the angle of a part depends on its last triangle,
    and the minimum is taken over the best parts, as in the paper. Time O(k^3).

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
    best = _BestParts(np.full((n, n), np.inf), np.full((n, n), np.inf), np.full((n, n), -1, dtype=np.int32), np.zeros((n, n, 3)))
    for i in range(n - 1):
        best.angle[i, i + 1] = best.area[i, i + 1] = 0.0
    side_normals = _side_normals(np.concatenate([points, opposite]))
    span = 2
    while span < n:
        until = span
        tried = 0
        while until < n and (tried == 0 or tried < _BATCH):
            tried += (n - until) * until
            until += 1
        _solve(points, side_normals, forbidden, span, until, best)
        span = until
        progress(span / n)
    if best.split[0, n - 1] < 0:
        return None
    return _collect(best.split)


@compiled
def _side_normals(points: Floats) -> Floats:
    """The unit normals of the faces of the mesh at the sides, 0 where there is no face or it is degenerate.

    `points` are the corners of the polygon, then the third vertices of these faces.
    """
    n = points.shape[0] // 2
    normals = np.empty((n, 3))
    for i in range(n):
        x, y, z, _ = _unit_normal(points, (i + 1) % n, i, n + i)
        normals[i, 0], normals[i, 1], normals[i, 2] = x, y, z
    return normals


@compiled
def _unit_normal(points: Floats, a: int, b: int, c: int) -> tuple[float, float, float, float]:
    """The unit normal of the triangle and its doubled area; zeros if it is degenerate."""
    x, y, z = cross_product(points, a, b, c)
    doubled = np.sqrt(x * x + y * y + z * z)
    if not doubled > _THINNEST * (squared_length(points, a, b) + squared_length(points, a, c) + squared_length(points, b, c)):
        return 0.0, 0.0, 0.0, 0.0
    return x / doubled, y / doubled, z / doubled, doubled


@compiled
def _bend(ax: float, ay: float, az: float, b: Floats) -> float:
    """1 - cos of the angle between two unit normals, which grows with the angle; 0 if the second normal is 0."""
    if b[0] == 0.0 and b[1] == 0.0 and b[2] == 0.0:
        return 0.0
    cosine: float = ax * b[0] + ay * b[1] + az * b[2]
    return 1.0 - cosine


@compiled
def _solve(p: Floats, side_normals: Floats, forbidden: Bools, span_from: int, span_to: int, best: _BestParts) -> None:
    """Enter the best triangulations of all parts of the polygon with `span_from` to less than `span_to` sides."""
    angle, area, split, normals = best
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
                x, y, z, doubled = _unit_normal(p, i, m, j)
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
    height, count = 1, 0
    while height > 0:
        height -= 1
        i, j = stack[height, 0], stack[height, 1]
        if j - i < 2:
            continue
        m = split[i, j]
        triangles[count, 0], triangles[count, 1], triangles[count, 2] = i, m, j
        count += 1
        stack[height, 0], stack[height, 1] = m, j
        stack[height + 1, 0], stack[height + 1, 1] = i, m
        height += 2
    return triangles


def retriangulated(
    triangles: Ints, chords: list[tuple[int, int]], points: Floats, opposite: Floats, forbidden: VertexPairs
) -> Ints:
    """The triangulation with the triangles around each chord triangulated anew, where that is better.

    The `WINDOW` triangles nearest to a chord, by the number of edges crossed, form a polygon, since a triangulated polygon is a
    tree of triangles. `minimal_triangulation` triangulates it anew, with the triangles around as neighbours, and its triangles
    are taken if their (largest dihedral angle, area) is less. The arguments are those of `triangulate_rim`, its result, and the
    two corners of each chord.
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
        (angle, area), (old_angle, old_area) = (_energy(points[corners], across, each) for each in (better, before))
        if angle < old_angle - _SAME or (angle <= old_angle + _SAME and area < old_area):
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
    near, queue = {first}, deque([first])
    while queue and len(near) < WINDOW:
        row = rows[queue.popleft()].tolist()
        for k in range(3):
            t = holder.get((row[(k + 1) % 3], row[k]))
            if t is not None and t not in near and len(near) < WINDOW:
                near.add(t)
                queue.append(t)
    return sorted(near)


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

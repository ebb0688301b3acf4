"""First step of hole filling [liepa2003]: joins a rim and the islands (loops) inside it to one polygon, and triangulates it."""

from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..compilation import compiled
from ..execution import Progress, ignore_progress
from ..geometry import cross_product, cross_products, side_lengths, squared_length
from ..libraries import sparse, spatial
from ..mesh import Bools, Floats, Ints, Longs
from ..topology import BoundaryLoop

#: A rim with more vertices is first cut in two by a chord: time grows with the cube of their number, memory with the square.
LARGEST_WHOLE = 300
# A triangle whose doubled area is below this share of its summed squared edges is degenerate.
_THINNEST = 1e-7
# Values of 1 - cos that differ by less than this count as equal, so that area decides ties, not rounding.
_SAME = 1e-9
# Areas that differ by less than this share count as equal: the rounding error of a sum of some hundred areas.
_SAME_AREA = 1e-12
#: The number of triangles around a chord that a new triangulation replaces together.
WINDOW = 120
# The most attempts to triangulate a polygon without two diagonals between the same two vertices.
_MOST_TRIES = 20


class VertexPairs(NamedTuple):
    """Unordered pairs of vertices 0 to size - 1."""

    size: int
    keys: Longs  # (p,) i size + j for each pair (i, j) and for (j, i), ascending

    def restricted(self, chosen: Ints) -> "VertexPairs":
        """The pairs with both vertices in `chosen`, an array of distinct vertices, as indices into `chosen`."""
        place = np.full(self.size, -1, dtype=np.int64)
        place[chosen] = np.arange(len(chosen))
        first, second = place[self.keys // self.size], place[self.keys % self.size]
        both = (first >= 0) & (second >= 0)
        return vertex_pairs(len(chosen), first[both], second[both])

    def among(self, chosen: Ints) -> Bools:
        """(k, k) whether two of the k distinct vertices `chosen` are a pair."""
        dense = np.zeros((len(chosen), len(chosen)), dtype=np.bool_)
        dense.ravel()[self.restricted(chosen).keys] = True
        return dense

    def with_pairs(self, first: ArrayLike, second: ArrayLike) -> "VertexPairs":
        return VertexPairs(self.size, np.union1d(self.keys, vertex_pairs(self.size, first, second).keys))


def vertex_pairs(count: int, first: ArrayLike = (), second: ArrayLike = ()) -> VertexPairs:
    """The pairs (first[i], second[i]) of vertices 0 to count - 1."""
    a, b = np.asarray(first, dtype=np.int64), np.asarray(second, dtype=np.int64)
    return VertexPairs(count, np.unique(np.concatenate([a * count + b, b * count + a])))


@compiled
def is_pair(pairs: VertexPairs, i: int, j: int) -> bool:
    """Whether (i, j) is one of the pairs."""
    key = i * pairs.size + j
    at = np.searchsorted(pairs.keys, key)
    return bool(at < pairs.keys.shape[0] and pairs.keys[at] == key)


def polygon(rim: BoundaryLoop, islands: list[BoundaryLoop], points: Floats) -> BoundaryLoop:
    """Joins the islands to the rim, the nearest first, each by the shortest cut to the polygon so far; `opposite` is -1 at cuts.

    A vertex is several corners if a cut ends there, or if the rim passes it several times. The polygon starts after the longest
    edge of the rim: the triangulation depends slightly on the first corner, but must not depend on vertex numbers.
    """
    first = int(side_lengths(points[rim.vertices]).argmax()) + 1
    vertices, opposite = np.roll(rim.vertices, -first), np.roll(rim.opposite, -first)
    remaining = list(islands)
    while remaining:
        best = (np.inf, 0, 0, 0)
        places, same_as = np.unique(points[vertices], axis=0, return_index=True)
        tree = spatial.cKDTree(places)
        for number, island in enumerate(remaining):
            apart, nearest = tree.query(points[island.vertices])
            j = int(apart.argmin())
            best = min(best, (float(apart[j]), number, int(same_as[nearest[j]]), j))
        i, j = best[2:]
        island = remaining.pop(best[1])
        around, beyond = np.roll(island.vertices, -j), np.roll(island.opposite, -j)
        # Go along the cut to the island, once round it, back along the cut, and on along the rim.
        cut = np.array([-1], dtype=np.int32)
        vertices = np.concatenate([vertices[: i + 1], around, around[:1], vertices[i:]])
        opposite = np.concatenate([opposite[:i], cut, beyond, cut, opposite[i:]])
    return BoundaryLoop(vertices, opposite)


def joined_corners(corners: Ints, neighbours: list[list[int]]) -> VertexPairs:
    """The pairs of corners that mesh edges join, except polygon sides; `neighbours` has a list for each distinct vertex."""
    k = len(corners)
    distinct, index = np.unique(corners, return_inverse=True)
    n = len(distinct)
    starts, others = np.repeat(np.arange(n), [len(ends) for ends in neighbours]), np.concatenate(neighbours)
    place = np.minimum(np.searchsorted(distinct, others), n - 1)
    within = distinct[place] == others
    linked = sparse.csr_array((np.ones(int(within.sum())), (starts[within], place[within])), shape=(n, n))
    at = sparse.csr_array((np.ones(k), (np.arange(k), index)), shape=(k, n))
    first, second = (at @ linked @ at.T).nonzero()
    side = (np.abs(first - second) == 1) | (np.abs(first - second) == k - 1)
    return vertex_pairs(k, first[~side], second[~side])


def triangulate_polygon(outline: BoundaryLoop, points: Floats, joined: VertexPairs, progress: Progress) -> Ints | None:
    """(b, 3) vertices of triangles that close the polygon without a diagonal in `joined`; None if this fails."""
    corners = outline.vertices
    opposite = np.where(outline.opposite[:, None] < 0, np.nan, points[outline.opposite])
    forbidden = joined
    distinct, vertex = np.unique(corners, return_inverse=True)
    if len(distinct) < len(corners):
        at = sparse.csr_array((np.ones(len(corners)), (np.arange(len(corners)), vertex)))
        forbidden = joined.with_pairs(*(at @ at.T).nonzero())  # two corners at the same vertex
    for _ in range(_MOST_TRIES):
        triangles = triangulate_rim(points[corners], opposite, forbidden, progress=progress)
        if triangles is None:
            return None
        doubled = _doubled_diagonals(corners, triangles)
        if len(doubled) == 0:
            return np.asarray(corners[triangles])
        forbidden = forbidden.with_pairs(doubled[:, 0], doubled[:, 1])
    return None


def _doubled_diagonals(corners: Ints, triangles: Ints) -> Longs:
    """(d, 2) the corners of each diagonal that joins the same two vertices as an earlier diagonal."""
    ends = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    ends, uses = np.unique(ends, axis=0, return_counts=True)
    diagonals = ends[uses == 2]
    _, first = np.unique(np.sort(corners[diagonals], axis=1), axis=0, return_index=True)
    return np.asarray(np.delete(diagonals, first, axis=0), dtype=np.int64)


def triangulate_rim(
    points: Floats, opposite: Floats, forbidden: VertexPairs, *, progress: Progress = ignore_progress
) -> Ints | None:
    """Triangulates a rim so that (largest dihedral angle, area), compared in this order, is least [liepa2003].

    A rim of more than `LARGEST_WHOLE` vertices is cut in two, repeatedly, by the chord that is shortest relative to the length of
    rim between its ends. Each part is triangulated with the triangles of the earlier parts as neighbours. Then the region around
    each chord is triangulated again, so that the chord need not stay an edge; this never makes the result worse.

    (k, 3) `points` are the rim vertices in the order in which new faces traverse them. (k, 3) `opposite` are the third vertices
    of the mesh faces at the edges from i to i + 1, NaN where there is no face. Returns (k - 2, 3) indices of points; None if
    no triangulation without degenerate triangles and `forbidden` diagonals is found.
    """
    n = len(points)
    centre = points.mean(axis=0)
    size = float(np.abs(points - centre).max())
    if n < 3 or not size > 0.0:
        return None
    # After the scaling, products of four lengths stay in range in any unit.
    points, opposite = (points - centre) / size, (opposite - centre) / size
    parts = [np.arange(n, dtype=np.int32)]
    rim = RimTriangles(points, opposite, forbidden, np.empty((n - 2, 3), dtype=np.int32), {})
    chords: list[tuple[int, int]] = []
    done = 0
    while parts:
        part = parts.pop()
        i, j = _chord(rim.points[part], part, forbidden) if len(part) > LARGEST_WHOLE else (-1, -1)
        if i >= 0:
            chords.append((int(part[i]), int(part[j])))
            # The part from i to j comes next: its triangle at the chord becomes a neighbour of the remaining part.
            parts += [np.concatenate([part[: i + 1], part[j:]]), part[i : j + 1]]
            continue
        triangles = minimal_triangulation(rim.points[part], rim.across(part), forbidden.among(part))
        if triangles is None:
            return None
        rim.enter(range(done, done + len(triangles)), part[triangles])
        done += len(triangles)
        progress(done / (n - 2))
    for chord in chords:
        retriangulate(rim, chord)
    return rim.triangles


class RimTriangles(NamedTuple):
    """A rim as for `triangulate_rim`, and the triangles made so far."""

    points: Floats  # (k, 3)
    opposite: Floats  # (k, 3)
    forbidden: VertexPairs
    triangles: Ints  # (k - 2, 3)
    holder: dict[tuple[int, int], int]  # the triangle of each directed edge

    def across(self, corners: Ints) -> Floats:
        """(c, 3) the third vertex of the triangle or mesh face across each side of a polygon; NaN if there is none yet."""
        beyond = np.full((len(corners), 3), np.nan)
        for i, (u, v) in enumerate(zip(corners.tolist(), np.roll(corners, -1).tolist(), strict=True)):
            t = self.holder.get((v, u))
            if t is not None:
                beyond[i] = self.points[int(self.triangles[t].sum()) - u - v]
            elif v == (u + 1) % len(self.points):
                beyond[i] = self.opposite[u]
        return beyond

    def enter(self, places: Iterable[int], triangles: Ints) -> None:
        """Writes triangles to the rows `places`; triangles that were there before must have covered the same region."""
        self.triangles[list(places)] = triangles
        for t, row in zip(places, triangles.tolist(), strict=True):
            self.holder.update(dict.fromkeys(_sides(row), t))


def _sides(triangle: list[int]) -> tuple[tuple[int, int], ...]:
    a, b, c = triangle
    return (a, b), (b, c), (c, a)


def retriangulate(rim: RimTriangles, chord: tuple[int, int]) -> None:
    """Triangulates the neighbourhood of a chord again, and keeps the result if it is better.

    In the dual graph the `WINDOW` triangles nearest to a triangle at the chord form a polygon, since the dual graph of a
    triangulated polygon is a tree. Another triangulation of it is better if (largest dihedral angle, area) is smaller.
    """
    if chord not in rim.holder:
        return  # no longer an edge
    chosen = _nearest(rim, rim.holder[chord])
    corners = np.unique(rim.triangles[chosen]).astype(np.int32)
    points, across = rim.points[corners], rim.across(corners)
    better = minimal_triangulation(points, across, rim.forbidden.among(corners))
    if better is None:
        return
    before = np.searchsorted(corners, rim.triangles[chosen]).astype(np.int32)
    (angle, area), (old_angle, old_area) = (_energy(points, across, each) for each in (better, before))
    if angle < old_angle - _SAME or (angle <= old_angle + _SAME and area < old_area):
        for row in rim.triangles[chosen].tolist():
            for side in _sides(row):
                del rim.holder[side]
        rim.enter(chosen, corners[better])


def _nearest(rim: RimTriangles, first: int) -> list[int]:
    near, queue = {first}, deque([first])
    while queue:
        for a, b in _sides(rim.triangles[queue.popleft()].tolist()):
            t = rim.holder.get((b, a))
            if t is not None and t not in near and len(near) < WINDOW:
                near.add(t)
                queue.append(t)
    return sorted(near)


def _energy(points: Floats, across: Floats, triangles: Ints) -> tuple[float, float]:
    """The largest dihedral angle, as 1 - cos, between triangles or with a face across a side; and the triangles' doubled area."""
    n = len(points)
    sides = np.arange(n)
    faces = np.concatenate([triangles, np.column_stack([np.roll(sides, -1), sides, n + sides])])
    normals = cross_products(np.concatenate([points, across]), faces)
    doubled = np.linalg.norm(normals, axis=1)
    if (doubled[: n - 2] == 0.0).any():
        return np.inf, np.inf
    with np.errstate(invalid="ignore"):
        normals /= doubled[:, None]
    holder = {side: t for t, row in enumerate(faces.tolist()) for side in _sides(row)}
    pairs = np.array([(t, holder[b, a]) for (a, b), t in holder.items() if t < n - 2])
    bends = 1.0 - np.einsum("ij,ij->i", normals[pairs[:, 0]], normals[pairs[:, 1]])
    return max(0.0, float(np.nanmax(bends))), float(doubled[: n - 2].sum())


@compiled
def _chord(p: Floats, part: Ints, forbidden: VertexPairs) -> tuple[int, int]:
    """The diagonal that is shortest relative to the shorter part of the rim between its ends; (-1, -1) if all are forbidden.

    Each of the two parts has at least a quarter of the edges.
    """
    n = p.shape[0]
    along = np.zeros(n + 1)
    for i in range(n):
        along[i + 1] = along[i] + np.sqrt(squared_length(p, i, (i + 1) % n))
    best, best_i, best_j = np.inf, -1, -1
    for i in range(n):
        for j in range(i + n // 4, min(n, i + n - n // 4)):
            rim_length = min(along[j] - along[i], along[n] - along[j] + along[i])
            length = np.sqrt(squared_length(p, i, j))
            if length > 0.0 and length < best * rim_length and not is_pair(forbidden, part[i], part[j]):
                best, best_i, best_j = length / rim_length, i, j
    return best_i, best_j


def minimal_triangulation(points: Floats, opposite: Floats, forbidden: Bools) -> Ints | None:
    """Triangulates a closed polygon so that (largest dihedral angle, area), compared in this order, is least [liepa2003].

    Dynamic programming in O(k^3): the best triangulation of the part from i to j is the triangle (i, m, j) and the best
    triangulations from i to m and from m to j, for the best m between i and j. Dihedral angles at the sides count too. Arguments
    as for `triangulate_rim`, except that `forbidden` is (k, k) and the coordinates are scaled to the order of 1.
    """
    n = len(points)
    angle, third = np.full((n, n), np.inf), np.full((n, n), -1, dtype=np.int32)
    _solve(np.concatenate([points, opposite]), forbidden, angle, angle.copy(), np.zeros((n, n, 3)), third)
    if third[0, n - 1] < 0:
        return None
    triangles, remaining = [], [(0, n - 1)]
    while remaining:
        i, j = remaining.pop()
        if j - i > 1:
            m = int(third[i, j])
            triangles.append((i, m, j))
            remaining += [(m, j), (i, m)]
    return np.array(triangles, dtype=np.int32)


@compiled
def _solve(points: Floats, forbidden: Bools, angle: Floats, area: Floats, normals: Floats, third: Ints) -> None:
    """Writes the best triangulation of every part from corner i to j > i: largest dihedral angle as 1 - cos, doubled area,
    unit normal and third corner of its triangle at (i, j). `points` are the corners, then the vertices across the sides.
    """
    n = forbidden.shape[0]
    for i in range(n):
        j = (i + 1) % n
        normals[i, j, 0], normals[i, j, 1], normals[i, j, 2], _ = _unit_normal(points, j, i, n + i)
        angle[i, j] = area[i, j] = 0.0
    for span in range(2, n):
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
                x, y, z, doubled = _unit_normal(points, i, m, j)
                if doubled == 0.0:
                    continue
                worst = max(worst, _bend(x, y, z, normals[i, m]), _bend(x, y, z, normals[m, j]))
                if last:
                    worst = max(worst, _bend(x, y, z, normals[j, i]))
                total = area[i, m] + area[m, j] + doubled
                if not _is_better(worst, total, abs(2 * m - i - j), best_angle, best_area, best_skew):
                    continue
                best_angle, best_area, best_skew = worst, total, abs(2 * m - i - j)
                angle[i, j], area[i, j], third[i, j] = worst, total, m
                normals[i, j, 0], normals[i, j, 1], normals[i, j, 2] = x, y, z


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
    """1 - cos of the angle between two unit normals; 0 if the second one is 0."""
    if b[0] == 0.0 and b[1] == 0.0 and b[2] == 0.0:
        return 0.0
    return float(1.0 - (ax * b[0] + ay * b[1] + az * b[2]))


@compiled
def _is_better(angle: float, area: float, skew: int, best_angle: float, best_area: float, best_skew: int) -> bool:
    """Whether a split is better than the best so far: by angle, then by area, then by the more even split.

    All triangulations of a flat convex polygon have the same bends and area: without the last rule rounding would pick needles.
    """
    if angle < best_angle - _SAME:
        return True
    if angle > best_angle + _SAME or area > best_area * (1.0 + _SAME_AREA):
        return False
    return area < best_area * (1.0 - _SAME_AREA) or skew < best_skew

"""Refinement, the second step of hole filling [liepa2003]: splits triangles until a patch is as dense as its rim, flips edges."""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..execution import Progress, ignore_progress
from ..geometry import angle_at, cross_product, cross_products, side_lengths, squared_length
from ..libraries import spatial
from ..mesh import Bools, Floats, Ints
from ..topology import diamond, faces_across, fan_size, flip
from .triangulation import VertexPairs, is_pair

#: The density factor of [liepa2003], see `refined_patch`.
DENSITY = np.sqrt(2.0)
# An edge between two rim vertices, unless forbidden, is not split if the height of an adjacent triangle is below this share of
# the target edge length: in a crack a new vertex has no room to move.
_CRACK = 0.25
_MOST_ROUNDS = 60
# The most vertices of a patch; a patch that is refined with `uniform_width` has far fewer.
_MOST_POINTS = 300_000
# The number of rounds is unknown in advance: after this many rounds the progress is one half.
_HALF = 8
# An edge is flipped if the angles opposite it sum to more than pi + `_GAIN`, and the flip lowers the sum by more than `_GAIN`.
# Without these margins, rounding errors could flip an edge back and forth for ever.
_GAIN = 1e-7
# A flip must not make a triangle whose doubled area is below this share of the sum of two squared sides.
_THINNEST = 1e-7
_MOST_SWEEPS = 200
#: A patch becomes as dense as its rim everywhere if at most about this many vertices suffice.
MOST_VERTICES = 60_000
#: In a larger patch only a band at the rim, at least `_LEAST_WIDTH` edges wide, is as dense as the rim; see `growing`.
_LEAST_WIDTH, SLOPE = 1.0, 0.4


class ForbiddenEdges(NamedTuple):
    """The edges that a patch must not have; its rim vertices are 0 to k - 1."""

    pairs: VertexPairs  # pairs of rim vertices with an edge outside the patch
    apart: Bools  # (k,) the rim vertices that must not be joined with each other
    alone: Bools  # (k,) the vertices that the rim passes more than once: a flip must not join them with any vertex


class Patch(NamedTuple):
    """Triangles that close a hole."""

    points: Floats  # (k + a, 3) the rim vertices, then the new vertices
    sizes: Floats  # (k + a,) the target edge length at each point
    triangles: Ints  # (b, 3) indices of `points`
    n_rim: int  # k


def refined_patch(
    patch: Patch, *, forbidden: ForbiddenEdges, uniform: float = np.inf, progress: Progress = ignore_progress
) -> Patch:
    """Splits triangles at their centroids, and flips edges after each round, until the patch is as dense as its rim [liepa2003].

    A triangle is split if, for each corner, `DENSITY` times the distance to the centroid exceeds the target length at the corner
    and the mean of the three target lengths. An edge is flipped while its two opposite angles sum to more than pi, unless the
    flip would fold the surface or double an edge. At the end, inner edges between two rim vertices are split at their midpoints,
    so that each triangle has a vertex that fairing can move; in cracks only `forbidden` edges are split. Edges of the rim
    stay. Triangles farther than `uniform` edges from the rim may be larger, see `growing`. A refined patch may be refined again.
    """
    points, sizes, triangles, n_rim = patch
    rim, triangles = points[:n_rim], np.ascontiguousarray(triangles, dtype=np.int32).copy()
    targets = growing(sizes, points, rim, uniform)
    flip_towards_delaunay(points, triangles, faces_across(triangles), forbidden)
    for done in range(_MOST_ROUNDS):
        progress(done / (done + _HALF))
        split = np.flatnonzero(_too_large(points, targets, triangles)).astype(np.int32)
        if len(split) == 0 or len(points) + len(split) > _MOST_POINTS:
            break
        centres, means = points[triangles[split]].mean(axis=1), sizes[triangles[split]].mean(axis=1)
        triangles = _split(len(points), triangles, split)
        points, sizes = np.concatenate([points, centres]), np.concatenate([sizes, means])
        targets = np.concatenate([targets, growing(means, centres, rim, uniform)])
        flip_towards_delaunay(points, triangles, faces_across(triangles), forbidden)
    points, sizes, triangles = _split_diagonals(points, sizes, triangles, n_rim, forbidden)
    forbidden = forbidden._replace(apart=np.ones(n_rim, dtype=np.bool_))
    flip_towards_delaunay(points, triangles, faces_across(triangles), forbidden)
    return Patch(points, sizes, triangles, n_rim)


def _split_diagonals(
    points: Floats, sizes: Floats, triangles: Ints, n_rim: int, forbidden: ForbiddenEdges
) -> tuple[Floats, Floats, Ints]:
    concerned = (triangles < n_rim).sum(axis=1) > 1  # triangles with an edge between rim vertices
    rows = triangles[concerned].tolist()
    row_of = {(row[k], row[(k + 1) % 3]): t for t, row in enumerate(rows) for k in range(3)}  # by directed edge
    inner = [(a, b) for a, b in row_of if max(a, b) < n_rim and (b, a) in row_of]
    if not inner:
        return points, sizes, triangles
    middles: list[tuple[int, int]] = []
    for a, b in inner:
        if (a, b) not in row_of:
            continue  # already split in the other direction
        if not ((forbidden.apart[a] and forbidden.apart[b]) or is_pair(forbidden.pairs, a, b)):
            heights = [_height(points[rows[row_of[edge]]]) for edge in ((a, b), (b, a)) if max(rows[row_of[edge]]) < len(points)]
            if heights and min(heights) < _CRACK * (sizes[a] + sizes[b]) / 2.0:
                continue
        v = len(points) + len(middles)
        middles.append((a, b))
        for start, end in ((a, b), (b, a)):
            t = row_of.pop((start, end))
            apex = rows[t][(rows[t].index(start) + 2) % 3]
            row_of[end, apex] = len(rows)
            rows[t] = [start, v, apex]
            rows.append([v, end, apex])
    ends = np.array(middles, dtype=np.int32).reshape(-1, 2)
    points, sizes = (np.concatenate([values, values[ends].mean(axis=1)]) for values in (points, sizes))
    return points, sizes, np.concatenate([triangles[~concerned], np.array(rows, dtype=np.int32)])


def _height(triangle: Floats) -> float:
    a, b, c = triangle
    longest = float(side_lengths(triangle).max())
    return float(np.linalg.norm(np.cross(b - a, c - a))) / longest if longest > 0.0 else 0.0


def _too_large(points: Floats, sizes: Floats, triangles: Ints) -> Bools:
    centroids, size = points[triangles].mean(axis=1), sizes[triangles].mean(axis=1)
    reach = DENSITY * np.linalg.norm(points[triangles] - centroids[:, None], axis=2)
    return np.asarray(((reach > size[:, None]) & (reach > sizes[triangles])).all(axis=1))


def _split(count: int, triangles: Ints, chosen: Ints) -> Ints:
    """Splits each chosen triangle into three at a new point (numbered from `count` on): one keeps the row, two are appended."""
    a, b, c = triangles[chosen].T
    v = count + np.arange(len(chosen), dtype=np.int32)
    split = np.concatenate([triangles, np.column_stack([b, c, v, c, a, v]).reshape(-1, 3)])
    split[chosen, 2] = v
    return split


@compiled
def flip_towards_delaunay(points: Floats, triangles: Ints, across: Ints, forbidden: ForbiddenEdges) -> None:
    """Flips edges in place until no allowed flip `_is_better`, in at most `_MOST_SWEEPS` sweeps; `across` is -1 at the rim."""
    for _ in range(_MOST_SWEEPS):
        flips = 0
        for t in range(triangles.shape[0]):
            for k in range(3):
                if across[t, k] > t:
                    a, b, c, d = diamond(triangles, across, t, k)
                    if (
                        _is_better(points, a, b, c, d)
                        and not _is_forbidden(forbidden, c, d)
                        and c != d
                        and fan_size(triangles, across, t, (k + 2) % 3, d) > 0
                    ):
                        flip(triangles, across, t, k)
                        flips += 1
        if flips == 0:
            break


@compiled
def _is_better(points: Floats, a: int, b: int, c: int, d: int) -> bool:
    """Whether the triangles (a, d, c) and (d, b, c) are better than (a, b, c) and (b, a, d)."""
    now = angle_at(points, c, a, b) + angle_at(points, d, b, a)
    if not (now > np.pi + _GAIN and now > angle_at(points, a, d, c) + angle_at(points, b, c, d) + _GAIN):
        return False
    # The new triangles must not be folded over each other, unless the old ones are folded at least as much.
    after = _facing(points, a, d, c, d, b, c)
    if after <= 0.0 and after < _facing(points, a, b, c, b, a, d):
        return False
    return not (_is_thin(points, a, d, c) or _is_thin(points, d, b, c))


@compiled
def _is_forbidden(forbidden: ForbiddenEdges, c: int, d: int) -> bool:
    pairs, apart, alone = forbidden
    n = apart.shape[0]
    if (c < n and alone[c]) or (d < n and alone[d]):
        return True
    return bool(c < n and d < n and ((apart[c] and apart[d]) or is_pair(pairs, c, d)))


@compiled
def _is_thin(points: Floats, a: int, b: int, c: int) -> bool:
    nx, ny, nz = cross_product(points, a, b, c)
    squares = squared_length(points, a, b) + squared_length(points, a, c)
    return not nx * nx + ny * ny + nz * nz > (_THINNEST * squares) ** 2


@compiled
def _facing(points: Floats, a: int, b: int, c: int, d: int, e: int, f: int) -> float:
    """Returns the cosine of the angle between the normals of the triangles (a, b, c) and (d, e, f), times their doubled areas."""
    x, y, z = cross_product(points, a, b, c)
    p, q, r = cross_product(points, d, e, f)
    return float(x * p + y * q + z * r)


def uniform_width(patch: Patch) -> float:
    """Returns the width, in edges, of the band along the rim that is as dense as the rim; infinite if this is the whole patch.

    Equilateral triangles with side h have one vertex per area h^2 sqrt(3) / 2. A band along k rim edges, u edges wide, has
    2 k u / sqrt(3) vertices. The inside, where edges grow by g = `SLOPE` per edge of distance, has at most 2 k / (g sqrt(3)). The
    result is the u for which band and inside together have `MOST_VERTICES`, but at least `_LEAST_WIDTH`.
    """
    vertex_area = np.sqrt(3.0) / 2.0  # of triangles with side 1
    areas = np.linalg.norm(cross_products(patch.points, patch.triangles), axis=1) / 2.0
    count = float((areas / (vertex_area * patch.sizes[patch.triangles].mean(axis=1) ** 2)).sum())
    if count <= MOST_VERTICES:
        return np.inf
    return max(_LEAST_WIDTH, float(MOST_VERTICES * vertex_area / patch.n_rim - 1.0 / SLOPE))


def growing(sizes: Floats, points: Floats, rim: Floats, uniform: float) -> Floats:
    """Returns (n,) target edge lengths: `sizes`, plus `SLOPE` x distance from a band of `uniform` edges along the (k, 3) rim."""
    if not np.isfinite(uniform) or len(points) == 0:
        return sizes
    distance, _ = spatial.cKDTree(rim).query(points)
    return np.asarray(sizes * np.maximum(1.0, 1.0 + SLOPE * (distance / sizes - uniform)))

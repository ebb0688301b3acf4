"""Stray points: single points, clumps and haze apart from the surface."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_finite, check_whole_number
from ..compilation import compiled
from ..execution import Progress, ignore_progress, in_parallel, over_range, part_of
from ..mesh import Bools, Floats, Ints, Longs
from ..neighbours import build_tree, check_cloud, leaf_ranges, search_leaves
from ..topology import root_of
from .local_outlier_probability import standard_distances

# A point is flat if its thickness (`thicknesses`) is at most this. With 12 neighbours most points are flat on surfaces with noise
# of 0.4 spacings, and 2 % are flat where points fill space.
_FLAT = 0.06
# A part fills space if its mean thickness is above `_FULL`: 0.16 to 0.19 where points fill space, up to 0.09 on surfaces. Such a
# part is kept if it has `_MORE` times `smallest_part` points.
_FULL, _MORE = 0.14, 3
# With enough links, the spacing limit is this factor larger: at 25 points per square metre, spacings in foliage are 2.7 medians.
_FOLIAGE = 2.0
#: Number of steps in which points linked to the surface join it.
JOIN_STEPS = 2
#: Marks a neighbour without link.
NO_LINK = -1
#: Thicknesses are rounded to multiples of this, so that their sum over up to 2^32 points is exact in any order.
_GRAIN = 2.0**-20


@dataclass(frozen=True)
class StrayRule:
    """The thresholds of `stray_points`."""

    neighbors: int
    sparseness: float
    smallest_part: int

    def on_surface(self, spacing: Floats, median: float, thickness: Floats, links: Longs) -> Bools:
        sparse = spacing / (self.sparseness * median or 1.0)
        return (sparse <= 1.0) | (self.is_joined(links) & ((sparse <= _FOLIAGE) | (thickness <= _FLAT)))

    def is_joined(self, links: Longs) -> Bools:
        """Returns (n,) whether a point has enough links: at least a quarter of the number of neighbours."""
        return 4 * links >= self.neighbors

    def too_small(self, sizes: Longs, sums: Longs) -> Bools:
        """Returns (p,) which parts are too small, by their `part_sums`."""
        thickness = sums * _GRAIN / np.maximum(sizes, 1)
        return np.asarray(sizes < np.where(thickness > _FULL, _MORE, 1) * self.smallest_part)


def stray_points(
    points: ArrayLike,
    *,
    neighbors: int = 16,
    sparseness: float = 1.5,
    smallest_part: int = 100,
    progress: Progress = ignore_progress,
) -> Bools:
    """Returns which points of a cloud are not part of any large enough surface.

    1. The spacing of a point is the root mean square distance to its k nearest neighbours. Its thickness is the least variance
       of the point and its neighbours along three principal axes, over the sum of the three; it is large where points fill space.
       Mutual neighbours are linked. A point off a surface has few links: surface points have nearer neighbours.
    2. Points are kept if their spacing is at most `sparseness` times the median of positive spacings. With k / 4 links or more,
       twice this limit or a thickness of at most 0.06 is enough. Then, twice, points with k / 4 links to kept points are kept.
    3. Kept points that are linked form a part. A part of fewer than `smallest_part` points is stray after all. A part that fills
       space, with a mean thickness above 0.14, is stray if it has fewer than three times `smallest_part` points.

    Args:
        points: (n, 3) finite coordinates.
        neighbors: k, from 1 to n - 1. Larger tells noisier surfaces from haze, bridges wider gaps and takes longer.
        sparseness: at least 1, in median spacings. Larger keeps points farther from a surface, and sparser haze.
        smallest_part: in points. Larger removes larger clumps, and larger islands of the surface too.
        progress: called with the share of the work done.

    Returns:
        (n,) bool, True for stray points.

    Raises:
        FilterInputError: a parameter is out of its bounds, or coordinates are missing, NaN or infinite.
    """
    check_finite("sparseness", sparseness, least=1.0)
    cloud, k = check_cloud(points, neighbors, "neighbors")
    rule = StrayRule(k, sparseness, check_whole_number("smallest_part", smallest_part, least=1))
    tree = build_tree(cloud, part_of(progress, 0.0, 0.2))
    n = tree.size
    index = tree.indices[:n]
    places = cloud[index] / tree.scale
    links: Ints = np.empty((n, k), np.int32)
    reaches, spacing = np.empty(n), np.empty(n)

    def find(first: int, last: int) -> None:
        rows, squared = search_leaves(tree, first, last, links)
        reaches[rows], spacing[rows] = squared.max(axis=1), standard_distances(squared)

    in_parallel(find, leaf_ranges(tree, k), part_of(progress, 0.2, 0.9))
    numbers = index.astype(np.int64)
    thickness = thicknesses(places, numbers, links)
    cut_links(places, numbers, links, reaches, numbers[links[:, -1]])
    apart = spacing[spacing > 0.0]
    median = float(np.quantile(apart, 0.5, method="lower")) if len(apart) else 0.0
    chosen = rule.on_surface(spacing, median, thickness, linked_to(links, np.ones(n, np.bool_)))
    for _ in range(JOIN_STEPS):
        chosen |= rule.is_joined(linked_to(links, chosen))
    parts = linked_parts(links, chosen)
    stray: Bools = np.empty(n, np.bool_)
    stray[index] = ~chosen | rule.too_small(*part_sums(parts, thickness, n))[parts]
    progress(1.0)
    return stray


def thicknesses(places: Floats, numbers: Longs, neighbours: Ints) -> Floats:
    """Returns (m,) the least variance of each point and its neighbours along three principal axes, over the sum of the three.

    With 16 neighbours it is 0 on a plane or a line, 0.07 on a plane with noise of half a spacing, 0.18 where points fill space.
    Overwrites the (m, k) `neighbours` of the first m of (n, 3) `places`: sorts them by distance, then by their (n,) `numbers`.
    """
    shares: Floats = np.empty(len(neighbours))
    over_range(_measure, len(neighbours), places, numbers, neighbours, shares)
    return shares


def cut_links(places: Floats, numbers: Longs, neighbours: Ints, reaches: Floats, lasts: Longs) -> None:
    """Replaces each neighbour q of a point p by `NO_LINK` unless p is among the k nearest of q; arrays as in `thicknesses`.

    (n,) `reaches` are the squared distances of points from their k-th neighbours, (n,) `lasts` the numbers of these neighbours.
    """
    over_range(_cut, len(neighbours), places, numbers, neighbours, reaches, lasts)


def linked_to(links: Ints, chosen: Bools) -> Longs:
    """Returns (m,) how many of the (m, k) links of each point lead to chosen points."""
    counts: Longs = np.empty(len(links), np.int64)
    over_range(_count, len(links), links, chosen, counts)
    return counts


def linked_parts(links: Ints, chosen: Bools) -> Longs:
    """Returns (m,) the part of each of m points, named by its lowest row.

    The (m, k) links join parts if both ends are chosen and among the m points.
    """
    parents: Longs = np.arange(len(links))
    _unite(links, chosen, parents)
    return parents


def part_sums(parts: Longs, thickness: Floats, count: int) -> tuple[Longs, Longs]:
    """Returns (count,) the number of points of each part, and (count,) the sum of their thicknesses in units of 2^-20."""
    sums = np.bincount(parts, np.rint(thickness / _GRAIN), minlength=count).astype(np.int64)
    return np.bincount(parts, minlength=count).astype(np.int64), sums


@compiled(nogil=True)
def _measure(places: Floats, numbers: Longs, neighbours: Ints, shares: Floats, first: int, last: int) -> None:
    k = neighbours.shape[1]
    squared = np.empty(k)
    for p in range(first, last):
        for i in range(k):  # sorts the neighbours, so that sums have a fixed order
            q = neighbours[p, i]
            dx, dy, dz = places[q, 0] - places[p, 0], places[q, 1] - places[p, 1], places[q, 2] - places[p, 2]
            distance, place = dx * dx + dy * dy + dz * dz, i
            while place > 0 and distance <= squared[place - 1]:
                if distance == squared[place - 1] and numbers[q] > numbers[neighbours[p, place - 1]]:
                    break
                neighbours[p, place], squared[place] = neighbours[p, place - 1], squared[place - 1]
                place -= 1
            neighbours[p, place], squared[place] = q, distance
        x = y = z = xx = xy = xz = yy = yz = zz = 0.0
        for i in range(k):
            q = neighbours[p, i]
            dx, dy, dz = places[q, 0] - places[p, 0], places[q, 1] - places[p, 1], places[q, 2] - places[p, 2]
            x, y, z = x + dx, y + dy, z + dz
            xx, yy, zz = xx + dx * dx, yy + dy * dy, zz + dz * dz
            xy, xz, yz = xy + dx * dy, xz + dx * dz, yz + dy * dz
        n = k + 1.0
        shares[p] = _least_share(xx - x * x / n, yy - y * y / n, zz - z * z / n, xy - x * y / n, xz - x * z / n, yz - y * z / n)


@compiled(nogil=True)
def _least_share(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> float:
    """Returns the least eigenvalue of a positive semidefinite matrix over its trace, by the trigonometric cubic formula."""
    trace = xx + yy + zz
    if not trace > 0.0:
        return 0.0
    a, b, c = xx / trace - 1.0 / 3.0, yy / trace - 1.0 / 3.0, zz / trace - 1.0 / 3.0
    d, e, f = xy / trace, xz / trace, yz / trace
    size = math.sqrt((a * a + b * b + c * c + 2.0 * (d * d + e * e + f * f)) / 6.0)
    if size == 0.0:
        return 1.0 / 3.0
    determinant = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)
    cosine = max(-1.0, min(1.0, determinant / (2.0 * size * size * size)))
    return max(0.0, 1.0 / 3.0 + 2.0 * size * math.cos((math.acos(cosine) + 2.0 * math.pi) / 3.0))


@compiled(nogil=True)
def _cut(places: Floats, numbers: Longs, neighbours: Ints, reaches: Floats, lasts: Longs, first: int, last: int) -> None:
    for p in range(first, last):
        for i in range(neighbours.shape[1]):
            q = neighbours[p, i]
            if q != NO_LINK:
                dx, dy, dz = places[q, 0] - places[p, 0], places[q, 1] - places[p, 1], places[q, 2] - places[p, 2]
                distance = dx * dx + dy * dy + dz * dz
                if distance > reaches[q] or (distance == reaches[q] and numbers[p] > lasts[q]):
                    neighbours[p, i] = NO_LINK


@compiled(nogil=True)
def _count(links: Ints, chosen: Bools, counts: Longs, first: int, last: int) -> None:
    for p in range(first, last):
        counts[p] = 0
        for i in range(links.shape[1]):
            q = links[p, i]
            if q != NO_LINK and chosen[q]:
                counts[p] += 1


@compiled(nogil=True)
def _unite(links: Ints, chosen: Bools, parents: Longs) -> None:
    n = links.shape[0]
    for p in range(n):
        if chosen[p]:
            for i in range(links.shape[1]):
                q = links[p, i]
                if q != NO_LINK and q < n and chosen[q]:
                    a, b = root_of(parents, p), root_of(parents, q)
                    parents[max(a, b)] = min(a, b)
    for p in range(n):
        parents[p] = parents[parents[p]]  # a parent has a lower row and already points to the root

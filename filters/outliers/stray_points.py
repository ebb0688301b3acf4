"""Stray points: those far from everything, and clumps and hazes apart from the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_finite, check_whole_number
from ..execution import Progress, ignore_progress, in_parallel, part_of
from ..mesh import Bools, Floats, Ints, Longs
from ..neighbours import LEAF, build_tree, check_cloud, leaf_ranges, search_leaves
from .factors import standard_distances
from .surface_links import cut_links, linked_parts, linked_to, mean_thicknesses, part_sums, thicknesses

# Surfaces have less thickness than that where noise is less than half of the spacing; of points that fill space 3 %.
_FLAT = 0.06
# With links points may be so many times sparser: foliage has 2.7 median spacings where a scan has 25 points in a square metre.
# A part with a greater mean thickness fills space: with 16 neighbours those have 0.17 to 0.19, surfaces up to 0.09. It takes so
# many times the points for it to be kept.
_FULL, _MORE = 0.14, 3
_FOLIAGE = 2.0
#: So often points join the surface that are linked to it: at its edges, and among stray points.
JOINED = 2


@dataclass(frozen=True)
class StrayRule:
    """What makes a point stray, see `stray_points`.

    Attributes:
        neighbors: k.
        sparseness: in median spacings.
        smallest_part: in points.
    """

    neighbors: int
    sparseness: float
    smallest_part: int

    def on_surface(self, spacing: Floats, median: float, thickness: Floats, links: Longs) -> Bools:
        """(n,) which points are on a surface by themselves, from their spacing, thickness and number of links."""
        sparse = spacing / (self.sparseness * median or 1.0)
        return (sparse <= 1.0) | (self.is_joined(links) & ((sparse <= _FOLIAGE) | (thickness <= _FLAT)))

    def is_joined(self, links: Longs) -> Bools:
        """(n,) whether as many links lead to a surface as it takes."""
        return 4 * links >= self.neighbors

    def too_small(self, sizes: Longs, sums: Longs) -> Bools:
        """(p,) which parts are stray, from what `part_sums` says of them."""
        least = np.where(mean_thicknesses(sizes, sums) > _FULL, _MORE, 1) * self.smallest_part
        return np.asarray(sizes < least)


def stray_points(
    points: ArrayLike,
    *,
    neighbors: int = 16,
    sparseness: float = 1.5,
    smallest_part: int = 100,
    progress: Progress = ignore_progress,
) -> Bools:
    """Which points of a cloud are not part of any surface that is large enough.

    1. The spacing of a point is the root mean square distance to its k nearest neighbours; its thickness the least of the
       variances of these along three axes over their sum; two points are linked if each is among the neighbours of the other. A
       point in front of a surface has hardly a link, since the points there have nearer neighbours; points that fill space are
       thick.
    2. Points are kept if their spacing is at most `sparseness` times the median of the cloud; with k / 4 links also if it is at
       most twice that, or the thickness at most 0.06. Twice, others are kept that have k / 4 links to points that are kept.
    3. Of the parts that links join these to, those of fewer than `smallest_part` points are stray after all, and those that fill
       space, with a mean thickness above 0.14, if they have fewer than three times as many points.

    The result depends neither on the unit nor on the place, nor on the order of the points.

    Args:
        points: (n, 3) finite coordinates.
        neighbors: k, from 1 to n - 1. More tell hazes from surfaces with more noise, bridge wider gaps and take longer.
        sparseness: at least 1, in median spacings. Larger keeps points farther from a surface, and denser hazes.
        smallest_part: in points. Larger removes larger clumps, and larger islands of the surface too.
        progress: called with the share of the work done.

    Returns:
        (n,) bool.

    Raises:
        FilterInputError: a parameter is out of its bounds, or coordinates are missing, NaN or infinite.
    """
    check_finite("sparseness", sparseness, least=1.0)
    cloud, k = check_cloud(points, neighbors, "neighbors")
    rule = StrayRule(k, sparseness, check_whole_number("smallest_part", smallest_part, least=1))
    tree = build_tree(cloud, part_of(progress, 0.0, 0.2))
    n = tree.count
    index = tree.indices[:n]
    places = cloud[index] / tree.scale
    links: Ints = np.empty((n, k), np.int32)
    reaches, spacing = np.empty(n), np.empty(n)

    def find(first: int, last: int) -> None:
        found, squared = search_leaves(tree, first, last, k)
        rows = slice(first * LEAF, first * LEAF + len(found))
        reaches[rows], spacing[rows] = squared.max(axis=1), standard_distances(squared)
        links[rows] = found

    in_parallel(find, leaf_ranges(tree, k), part_of(progress, 0.2, 0.9))
    numbers = index.astype(np.int64)
    thickness = thicknesses(places, numbers, links)
    cut_links(places, numbers, links, reaches, numbers[links[:, -1]])
    every = np.ones(n, np.bool_)
    median = float(np.partition(spacing, (n - 1) // 2)[(n - 1) // 2])
    chosen = rule.on_surface(spacing, median, thickness, linked_to(links, every))
    for _ in range(JOINED):
        chosen |= rule.is_joined(linked_to(links, chosen))
    parts = linked_parts(links, chosen)
    stray: Bools = np.empty(n, np.bool_)
    stray[index] = ~chosen | rule.too_small(*part_sums(parts, thickness, n))[parts]
    progress(1.0)
    return stray

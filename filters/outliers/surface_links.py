"""What the nearest neighbours of the points of a cloud say of its surface: how thick it is, and which of them are linked.

Points are rows: those that are asked for come first, and if they are a part of a cloud others follow, which are neighbours alone.
Distances are in the unit of a tree. No result depends on the order of the points, nor on the part of the cloud that they are in.
"""

from __future__ import annotations

import math

import numpy as np

from ..compilation import compiled
from ..execution import ignore_progress, in_parallel
from ..mesh import Bools, Floats, Ints, Longs

#: a neighbour that is not linked
NO_LINK = -1
#: Thicknesses are summed as whole multiples of this, exactly, in whatever order: of up to 2^32 points.
_GRAIN = 2.0**-20
#: rows of a task
_ROWS = 1 << 14


def thicknesses(places: Floats, numbers: Longs, neighbours: Ints) -> Floats:
    """(m,) the least of the variances of each point and its neighbours along three axes, over their sum.

    With 16 neighbours 0 on a plane or a line, 0.07 on a plane with noise of half of the spacing, 0.18 where points fill space.

    Args:
        places: (n, 3) coordinates.
        numbers: (n,) by which neighbours at one distance are put into order.
        neighbours: (m, k) rows of the nearest points of the first m; put into order by distance, in place.
    """
    found: Floats = np.empty(len(neighbours))
    in_parallel(
        lambda first, last: _measure(places, numbers, neighbours, found, first, last), _ranges(len(neighbours)), ignore_progress
    )
    return found


def cut_links(places: Floats, numbers: Longs, neighbours: Ints, reaches: Floats, lasts: Longs) -> None:
    """Replace neighbours by `NO_LINK` where the point is none of their own k nearest.

    Args:
        places: (n, 3) coordinates.
        numbers: (n,) by which neighbours at one distance are put into order.
        neighbours: (m, k) rows of the nearest points of the first m; changed in place.
        reaches: (n,) the squared distance of the k-th neighbour of every point.
        lasts: (n,) the number of that neighbour.
    """
    in_parallel(
        lambda first, last: _cut(places, numbers, neighbours, reaches, lasts, first, last),
        _ranges(len(neighbours)),
        ignore_progress,
    )


def linked_to(links: Ints, chosen: Bools) -> Longs:
    """(m,) how many of the (m, k) links of each point lead to those of (n,) points that are chosen."""
    counts: Longs = np.empty(len(links), np.int64)
    in_parallel(lambda first, last: _count(links, chosen, counts, first, last), _ranges(len(links)), ignore_progress)
    return counts


def linked_parts(links: Ints, chosen: Bools) -> Longs:
    """(m,) the connected part of each of m points: the lowest row in it; links to rows from m on, and others, join nothing.

    Args:
        links: (m, k) rows, or `NO_LINK`.
        chosen: (n,) which points may be joined.
    """
    parents: Longs = np.arange(len(links))
    _unite(links, chosen, parents)
    return parents


def part_sums(parts: Longs, thickness: Floats, count: int) -> tuple[Longs, Longs]:
    """(count,) the points of each part, and the sum of their thicknesses in a unit of its own, see `mean_thicknesses`."""
    grains = np.rint(thickness / _GRAIN)
    sizes = np.bincount(parts, minlength=count).astype(np.int64)
    return sizes, np.bincount(parts, grains, minlength=count).astype(np.int64)


def mean_thicknesses(sizes: Longs, sums: Longs) -> Floats:
    """(p,) the mean thickness of the points of each part, 0 of an empty one."""
    return np.asarray(sums * _GRAIN / np.maximum(sizes, 1))


def _ranges(rows: int) -> list[tuple[int, int]]:
    return [(first, min(first + _ROWS, rows)) for first in range(0, rows, _ROWS)]


@compiled(nogil=True)
def _measure(places: Floats, numbers: Longs, neighbours: Ints, found: Floats, first: int, last: int) -> None:
    k = neighbours.shape[1]
    squared = np.empty(k)
    for p in range(first, last):
        for i in range(k):  # sums in a fixed order
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
        found[p] = _least_share(xx - x * x / n, yy - y * y / n, zz - z * z / n, xy - x * y / n, xz - x * z / n, yz - y * z / n)


@compiled(nogil=True)
def _least_share(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> float:
    """The least eigenvalue of a positive semidefinite matrix over its trace; by the trigonometric solution of the cubic."""
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
                    a, b = _root(parents, p), _root(parents, q)
                    parents[max(a, b)] = min(a, b)
    for p in range(n):
        parents[p] = parents[parents[p]]  # a parent has a lower row, so that it leads to the root already


@compiled(nogil=True)
def _root(parents: Longs, row: int) -> int:
    while parents[row] != row:
        parents[row] = parents[parents[row]]
        row = parents[row]
    return row

"""Finds neighbours of the points of a tile in other cells of the cloud.

A cloud that does not fit into memory is cut into cells, each with a bounding box. A tile is a range of cells. Its points have
been compared with each other; this module compares them with the points of other cells. Neighbours are ordered as in
`nearest_neighbours`: by squared distance, then by number. Rounding is monotonic. So the computed distance to a point in a box
is at least the computed distance to the box, and at most the one to its farthest corner: no cell with a neighbour is left out.
The boxes form a binary tree: node 1 is the root, the children of node i are 2 i and 2 i + 1, and the last level has the cells.
"""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..mesh import Bools, Floats, Ints, Longs
from .kd_tree import STACK


class CellTree(NamedTuple):
    """The bounding boxes of all cells of a cloud, as a binary tree with w leaves."""

    # (2 w, 2, 3) the lowest and the highest coordinates of each node's points; infinity and -infinity for a node without points
    boxes: Floats
    counts: Longs  # (2 w,) the number of points in each node

    @classmethod
    def over(cls, boxes: Floats, counts: Longs) -> "CellTree":
        """Returns the tree over (c, 2, 3) boxes of cells with (c,) counts of points; consecutive cells should be neighbours."""
        width = 1 << max(len(boxes) - 1, 0).bit_length()
        nodes: Floats = np.empty((2 * width, 2, 3))
        nodes[:, 0], nodes[:, 1] = np.inf, -np.inf
        totals: Longs = np.zeros(2 * width, np.int64)
        nodes[width : width + len(boxes)], totals[width : width + len(boxes)] = boxes, counts
        while width > 1:
            half = width // 2
            nodes[half:width, 0] = nodes[width : 2 * width, 0].reshape(half, 2, 3).min(axis=1)
            nodes[half:width, 1] = nodes[width : 2 * width, 1].reshape(half, 2, 3).max(axis=1)
            totals[half:width] = totals[width : 2 * width].reshape(half, 2).sum(axis=1)
            width = half
        return cls(nodes, totals)


class Nearest(NamedTuple):
    """For each query point, the k nearest points found so far, ordered by squared distance, then by number."""

    squared: Floats  # (a, k) squared distances, infinite for missing neighbours
    numbers: Longs  # (a, k) indices of the neighbours in the input
    slots: Longs  # (a, k) rows of the neighbours in the files that hold the cells

    def of(self, rows: slice) -> "Nearest":
        """Returns a view of some rows, in the same memory."""
        return Nearest(self.squared[rows], self.numbers[rows], self.slots[rows])


def reaching_out(points: Floats, bounds: Floats, cells: CellTree, first: int, last: int) -> Bools:
    """Returns (n,) which points are within their (n,) `bounds` of the box of a cell outside of the tile.

    A bound is the squared distance of the k-th nearest point in the tile. The tile has the cells from `first` to `last` - 1.
    """
    counts: Longs = np.zeros(len(points), np.int64)
    list_cells(points, bounds, cells, first, last, counts, np.zeros(0, np.int64), np.empty(0, np.int32))
    return np.asarray(counts > 0)


def cells_within(
    points: Floats, bounds: Floats, cells: CellTree, first: int, last: int, k: int, *, most: int | None = None
) -> tuple[Longs, Ints]:
    """Lists the cells outside of a tile that can hold one of the k nearest neighbours of each point.

    `bounds` shrink in place: a box with more than k points holds k neighbours of every point, none farther away than the farthest
    corner of the box. The list ends before the point whose cells would make it longer than `most`, but has the cells of at least
    one point.

    Returns:
        (a + 1,) offsets into the list, for the first `a` points; and the list: the (c,) numbers of cells.
    """
    counts: Longs = np.zeros(len(points) + 1, np.int64)
    shrink_bounds(points, bounds, cells, k)
    list_cells(points, bounds, cells, first, last, counts[1:], np.zeros(0, np.int64), np.empty(0, np.int32))
    offsets: Longs = np.cumsum(counts)
    if most is not None:
        fit = max(1, int(np.searchsorted(offsets, most, "right")) - 1)
        offsets = offsets[: fit + 1]
    listed = len(offsets) - 1
    numbers: Ints = np.empty(int(offsets[-1]), np.int32)
    list_cells(points[:listed], bounds[:listed], cells, first, last, counts[1:], offsets, numbers)
    return offsets, numbers


@compiled(nogil=True)
def gap_to(boxes: Floats, node: int, x: float, y: float, z: float) -> float:
    """Returns the squared distance of a point from the box of a node."""
    dx = max(boxes[node, 0, 0] - x, x - boxes[node, 1, 0], 0.0)
    dy = max(boxes[node, 0, 1] - y, y - boxes[node, 1, 1], 0.0)
    dz = max(boxes[node, 0, 2] - z, z - boxes[node, 1, 2], 0.0)
    squared: float = dx * dx + dy * dy + dz * dz
    return squared


@compiled(nogil=True)
def _covered(node: int, width: int, first: int, last: int) -> bool:
    low, high = node, node + 1
    while low < width:
        low, high = 2 * low, 2 * high
    return low - width >= first and high - width <= last


@compiled(nogil=True)
def shrink_bounds(points: Floats, bounds: Floats, cells: CellTree, k: int) -> None:
    """Lowers each bound to the squared distance of the farthest corner of a box with more than k points, if this is smaller."""
    boxes, counts = cells
    width = boxes.shape[0] // 2
    stack = np.empty(STACK, np.int64)
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        stack[0], top = 1, 1
        while top > 0:
            top -= 1
            node = stack[top]
            if counts[node] <= k or gap_to(boxes, node, x, y, z) > bounds[p]:
                continue
            dx = max(abs(boxes[node, 0, 0] - x), abs(boxes[node, 1, 0] - x))
            dy = max(abs(boxes[node, 0, 1] - y), abs(boxes[node, 1, 1] - y))
            dz = max(abs(boxes[node, 0, 2] - z), abs(boxes[node, 1, 2] - z))
            bounds[p] = min(bounds[p], dx * dx + dy * dy + dz * dz)
            if node < width:
                left, right = 2 * node, 2 * node + 1
                if gap_to(boxes, left, x, y, z) < gap_to(boxes, right, x, y, z):
                    left, right = right, left
                stack[top], stack[top + 1] = left, right  # the nearer node is visited first
                top += 2


@compiled(nogil=True)
def list_cells(
    points: Floats, bounds: Floats, cells: CellTree, first: int, last: int, counts: Longs, offsets: Longs, numbers: Ints
) -> None:
    """Counts the cells that each point needs, see `cells_within`; with `offsets` it also writes their numbers."""
    boxes, _ = cells
    width = boxes.shape[0] // 2
    stack = np.empty(STACK, np.int64)
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        count = 0
        stack[0], top = 1, 1
        while top > 0:
            top -= 1
            node = stack[top]
            if gap_to(boxes, node, x, y, z) > bounds[p] or _covered(node, width, first, last):
                continue
            if node >= width:
                if offsets.shape[0]:
                    numbers[offsets[p] + count] = node - width
                count += 1
                continue
            stack[top], stack[top + 1] = 2 * node, 2 * node + 1
            top += 2
        counts[p] = count


@compiled(nogil=True)
def offer_cells(
    points: Floats,
    own_numbers: Longs,
    nearest: Nearest,
    cells_of_points: tuple[Longs, Ints],
    cells: CellTree,
    rows: Longs,
    offered: tuple[Floats, Longs, Longs],
) -> None:
    """Updates `nearest` in place with the points of the cells that `cells_within` has listed.

    `own_numbers` are the numbers of the `points`, so that no point becomes its own neighbour. `offered` has (r, 3) coordinates,
    (r,) numbers and (r,) slots of other points. `rows` has (c, 2) begin and end of each cell in these arrays, 0 for absent cells.
    """
    squared, numbers, slots = nearest
    offsets, listed = cells_of_points
    coordinates, offered_numbers, offered_slots = offered
    width = cells.boxes.shape[0] // 2
    k = squared.shape[1]
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        for a in range(offsets[p], offsets[p + 1]):
            cell = listed[a]
            if gap_to(cells.boxes, width + cell, x, y, z) > squared[p, k - 1]:
                continue
            for r in range(rows[cell, 0], rows[cell, 1]):
                dx, dy, dz = coordinates[r, 0] - x, coordinates[r, 1] - y, coordinates[r, 2] - z
                distance = dx * dx + dy * dy + dz * dz
                place = k
                number = offered_numbers[r]
                if number == own_numbers[p]:
                    continue
                while place > 0 and (
                    distance < squared[p, place - 1] or (distance == squared[p, place - 1] and number < numbers[p, place - 1])
                ):
                    place -= 1
                if place == k:
                    continue
                for i in range(k - 1, place, -1):
                    squared[p, i], numbers[p, i], slots[p, i] = squared[p, i - 1], numbers[p, i - 1], slots[p, i - 1]
                squared[p, place], numbers[p, place], slots[p, place] = distance, number, offered_slots[r]

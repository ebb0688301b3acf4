"""Walks down the tree over the cells of a cloud, and the comparison with the points of a cell: compiled kernels of `cells`."""

from __future__ import annotations

import numpy as np

from ..compilation import compiled
from ..mesh import Bools, Floats, Ints, Longs
from .kd_tree import STACK


@compiled(nogil=True)
def _gap_to(box: Floats, x: float, y: float, z: float) -> float:
    """The squared distance of a box."""
    dx = max(max(box[0, 0] - x, x - box[1, 0]), 0.0)
    dy = max(max(box[0, 1] - y, y - box[1, 1]), 0.0)
    dz = max(max(box[0, 2] - z, z - box[1, 2]), 0.0)
    squared: float = dx * dx + dy * dy + dz * dz
    return squared


@compiled(nogil=True)
def _farthest_of(box: Floats, x: float, y: float, z: float) -> float:
    """The squared distance of the farthest corner of a box."""
    dx = max(abs(box[0, 0] - x), abs(box[1, 0] - x))
    dy = max(abs(box[0, 1] - y), abs(box[1, 1] - y))
    dz = max(abs(box[0, 2] - z), abs(box[1, 2] - z))
    squared: float = dx * dx + dy * dy + dz * dz
    return squared


@compiled(nogil=True)
def _covered(node: int, width: int, first: int, last: int) -> bool:
    """Whether all cells of a node belong to the tile."""
    low, high = node, node + 1
    while low < width:
        low, high = 2 * low, 2 * high
    return low - width >= first and high - width <= last


@compiled(nogil=True)
def mark_reaching(points: Floats, bounds: Floats, boxes: Floats, first: int, last: int, reach: Bools) -> None:
    """Marks the points within whose bound a box outside of the tile lies."""
    width = boxes.shape[0] // 2
    stack = np.empty(STACK, np.int64)
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        reach[p] = False
        stack[0], top = 1, 1
        while top > 0:
            top -= 1
            node = stack[top]
            if _gap_to(boxes[node], x, y, z) > bounds[p] or _covered(node, width, first, last):
                continue
            if node >= width:
                reach[p] = True
                break
            stack[top], stack[top + 1] = 2 * node, 2 * node + 1
            top += 2


@compiled(nogil=True)
def shrink_bounds(points: Floats, bounds: Floats, boxes: Floats, counts: Longs, k: int) -> None:
    """Lowers bounds to what boxes with more than k points guarantee."""
    width = boxes.shape[0] // 2
    stack = np.empty(STACK, np.int64)
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        stack[0], top = 1, 1
        while top > 0:
            top -= 1
            node = stack[top]
            if counts[node] <= k or _gap_to(boxes[node], x, y, z) > bounds[p]:
                continue
            bounds[p] = min(bounds[p], _farthest_of(boxes[node], x, y, z))
            if node < width:
                left, right = 2 * node, 2 * node + 1
                if _gap_to(boxes[left], x, y, z) < _gap_to(boxes[right], x, y, z):
                    left, right = right, left
                stack[top], stack[top + 1] = left, right  # the nearer one is looked at first
                top += 2


@compiled(nogil=True)
def list_cells(
    points: Floats, bounds: Floats, boxes: Floats, first: int, last: int, counts: Longs, offsets: Longs, found: Ints
) -> None:
    """Counts the cells of each point, or if there are `offsets` writes them down."""
    width = boxes.shape[0] // 2
    stack = np.empty(STACK, np.int64)
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        count = 0
        stack[0], top = 1, 1
        while top > 0:
            top -= 1
            node = stack[top]
            if _gap_to(boxes[node], x, y, z) > bounds[p] or _covered(node, width, first, last):
                continue
            if node >= width:
                if offsets.shape[0]:
                    found[offsets[p] + count] = node - width
                count += 1
                continue
            stack[top], stack[top + 1] = 2 * node, 2 * node + 1
            top += 2
        counts[p] = count


@compiled(nogil=True)
def offer(
    points: Floats,
    own: Longs,
    squared: Floats,
    numbers: Longs,
    slots: Longs,
    offsets: Longs,
    asked: Ints,
    boxes: Floats,
    rows: Longs,
    coordinates: Floats,
    their_numbers: Longs,
    their_slots: Longs,
) -> None:
    """Inserts the points of cells among the nearest of those who asked for the cells."""
    width = boxes.shape[0] // 2
    k = squared.shape[1]
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        for a in range(offsets[p], offsets[p + 1]):
            cell = asked[a]
            if _gap_to(boxes[width + cell], x, y, z) > squared[p, k - 1]:
                continue
            for r in range(rows[cell, 0], rows[cell, 1]):
                dx, dy, dz = coordinates[r, 0] - x, coordinates[r, 1] - y, coordinates[r, 2] - z
                distance = dx * dx + dy * dy + dz * dz
                place = k
                number = their_numbers[r]
                if number == own[p]:
                    continue
                while place > 0 and (
                    distance < squared[p, place - 1] or (distance == squared[p, place - 1] and number < numbers[p, place - 1])
                ):
                    place -= 1
                if place == k:
                    continue
                for i in range(k - 1, place, -1):
                    squared[p, i], numbers[p, i], slots[p, i] = squared[p, i - 1], numbers[p, i - 1], slots[p, i - 1]
                squared[p, place], numbers[p, place], slots[p, place] = distance, number, their_slots[r]

"""Bilateral steps along vertex normals: the compiled part of `bilateral_fleishman`."""

import math
from typing import NamedTuple

import numpy as np

from ..compilation import compiled, prange
from ..mesh import Bools, Floats, Ints, Longs, mask_of
from ..robust import kernel_weight
from .neighbour_weights import REACH, Term

# Vertices are worked off in so many blocks, each with an array of marks of its own; results do not depend on the number.
_BLOCKS = 32


class HeightNeighbours(NamedTuple):
    """The neighbours whose heights each vertex averages, and the faces that its normal is made of."""

    moving: Ints  # int32 the vertices that move
    offsets: Longs  # with `neighbours` the one-rings of all vertices
    neighbours: Ints
    on_curve: Bools  # (n,) bool, the vertices that average over the border alone
    curve_offsets: Longs  # with `curve_neighbours` their neighbours along the border
    curve_neighbours: Ints
    end_offsets: Longs  # with `ends` the two other vertices of each face of a vertex, for its normal
    ends: Ints


def heights_of_rings(points: Floats, around: HeightNeighbours) -> Floats:
    """The heights n_i . (p_j - p_i) of all neighbours j in the one-rings of the vertices that move."""
    heights = np.zeros(len(around.neighbours))
    _heights(points, around, heights)
    result: Floats = heights[np.repeat(mask_of(around.moving, len(points)), np.diff(around.offsets))]
    return result


@compiled
def _normal(points: Floats, i: int, around: HeightNeighbours) -> tuple[float, float, float]:
    """The unit normal of the faces around i, weighted by area; 0 if they have none."""
    end_offsets, ends = around.end_offsets, around.ends
    x = y = z = 0.0
    px, py, pz = points[i, 0], points[i, 1], points[i, 2]
    for k in range(end_offsets[i], end_offsets[i + 1], 2):
        a, b = ends[k], ends[k + 1]
        ax, ay, az = points[a, 0] - px, points[a, 1] - py, points[a, 2] - pz
        bx, by, bz = points[b, 0] - px, points[b, 1] - py, points[b, 2] - pz
        x += ay * bz - az * by
        y += az * bx - ax * bz
        z += ax * by - ay * bx
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-100:
        return 0.0, 0.0, 0.0
    return x / length, y / length, z / length


@compiled(parallel=True)
def _heights(points: Floats, around: HeightNeighbours, heights: Floats) -> None:
    moving, offsets, neighbours = around.moving, around.offsets, around.neighbours
    for m in prange(moving.shape[0]):
        i = moving[m]
        x, y, z = _normal(points, i, around)
        for k in range(offsets[i], offsets[i + 1]):
            j = neighbours[k]
            heights[k] = x * (points[j, 0] - points[i, 0]) + y * (points[j, 1] - points[i, 1]) + z * (points[j, 2] - points[i, 2])


@compiled(parallel=True)
def bilateral_step(points: Floats, out: Floats, around: HeightNeighbours, space: Term, height: Term) -> None:
    """One step of all vertices at once, from `points` to `out`."""
    moving = around.moving
    count = moving.shape[0]
    blocks = min(_BLOCKS, 1 + count // 1024)
    for block in prange(blocks):
        seen = np.full(points.shape[0], -1, dtype=np.int32)
        queue = np.empty(points.shape[0], dtype=np.int32)
        for m in range(block * count // blocks, (block + 1) * count // blocks):
            i = moving[m]
            x, y, z = _normal(points, i, around)
            mean = _mean_height(points, i, (x, y, z), around, seen, queue, space, height)
            out[i, 0] = points[i, 0] + mean * x
            out[i, 1] = points[i, 1] + mean * y
            out[i, 2] = points[i, 2] + mean * z


@compiled
def _mean_height(
    points: Floats,
    i: int,
    normal: tuple[float, float, float],
    around: HeightNeighbours,
    seen: Ints,
    queue: Ints,
    space: Term,
    term: Term,
) -> float:
    """The weighted mean height of the vertices within reach of i, breadth first; `seen` and `queue` have room for all of them."""
    offsets, neighbours = around.offsets, around.neighbours
    if around.on_curve[i]:
        offsets, neighbours = around.curve_offsets, around.curve_neighbours
    reach = (REACH * space.sigma) ** 2
    px, py, pz = points[i, 0], points[i, 1], points[i, 2]
    x, y, z = normal
    total = sum_of_heights = 0.0
    queue[0], seen[i] = i, i
    first, last = 0, 1
    while first < last:
        v = queue[first]
        first += 1
        for k in range(offsets[v], offsets[v + 1]):
            j = neighbours[k]
            if seen[j] == i:
                continue
            seen[j] = i
            dx, dy, dz = points[j, 0] - px, points[j, 1] - py, points[j, 2] - pz
            squared = dx * dx + dy * dy + dz * dz
            if squared > reach:
                continue
            height = x * dx + y * dy + z * dz
            share = kernel_weight(space.code, math.sqrt(squared), space.sigma) * kernel_weight(term.code, height, term.sigma)
            total += share
            sum_of_heights += share * height
            queue[last] = j
            last += 1
    return sum_of_heights / total if total > 0.0 else 0.0

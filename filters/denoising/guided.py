"""Guide normals: for every face the mean normal of the most even patch around that contains it [zhang2015]."""

import math

import numpy as np

from ..compilation import compiled, prange
from ..execution import threads_for
from ..mesh import Floats, Ints, Longs
from .face_neighbourhoods import FaceNeighbourhoods

# Keeps the measure of a patch without any bend from being 0 / 0.
_EPSILON = 1e-9


def guide_normals(normals: Floats, table: Floats, patches: FaceNeighbourhoods, edge_neighbours: FaceNeighbourhoods) -> Floats:
    """(m, 3) the guide normal of every face.

    The patch of face i is i and its neighbours in `patches`. It is the more even the smaller H = D R, with D the largest
    |n_j - n_k| of two of its faces and R the largest over the sum of |n_j - n_k| over the edges inside it: R is small where the
    bends are spread and near 1 where one edge has them all. Among the patches of i and of the faces in its patch, the one with
    the smallest H gives the guide, the mean of its normals weighted by area.

    Args:
        normals: (m, 3) unit normals.
        table: (m, 8) of `measure_faces`, for the areas.
        patches: the neighbourhoods "vertex".
        edge_neighbours: the neighbourhoods "edge".
    """
    measures, means, guides = np.empty(len(normals)), np.empty_like(normals), np.empty_like(normals)
    with threads_for(len(patches.neighbours)):
        _measure_patches(
            normals,
            np.ascontiguousarray(table[:, 3]),
            patches.offsets,
            patches.neighbours,
            edge_neighbours.offsets,
            edge_neighbours.neighbours,
            measures,
            means,
        )
        _choose(measures, means, patches.offsets, patches.neighbours, guides)
    return guides


@compiled(parallel=True)
def _measure_patches(
    normals: Floats,
    areas: Floats,
    offsets: Longs,
    neighbours: Ints,
    edge_offsets: Longs,
    edge_neighbours: Ints,
    measures: Floats,
    means: Floats,
) -> None:
    for i in prange(normals.shape[0]):
        size = offsets[i + 1] - offsets[i] + 1
        patch = np.empty(size, dtype=np.int32)
        patch[0] = i
        patch[1:] = neighbours[offsets[i] : offsets[i + 1]]
        x = y = z = 0.0
        largest = 0.0
        for a in range(size):
            j = patch[a]
            x += areas[j] * normals[j, 0]
            y += areas[j] * normals[j, 1]
            z += areas[j] * normals[j, 2]
            for b in range(a + 1, size):
                largest = max(largest, _squared_difference(normals, j, patch[b]))
        total = steepest = 0.0
        for a in range(size):
            j = patch[a]
            for k in range(edge_offsets[j], edge_offsets[j + 1]):
                h = edge_neighbours[k]
                if h <= j:
                    continue
                for b in range(size):
                    if patch[b] == h:
                        difference = math.sqrt(_squared_difference(normals, j, h))
                        total += difference
                        steepest = max(steepest, difference)
                        break
        measures[i] = math.sqrt(largest) * steepest / (total + _EPSILON)
        length = math.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            means[i, 0], means[i, 1], means[i, 2] = x / length, y / length, z / length
        else:
            means[i, 0], means[i, 1], means[i, 2] = normals[i, 0], normals[i, 1], normals[i, 2]


@compiled(parallel=True)
def _choose(measures: Floats, means: Floats, offsets: Longs, neighbours: Ints, guides: Floats) -> None:
    for i in prange(measures.shape[0]):
        best = np.int32(i)
        for k in range(offsets[i], offsets[i + 1]):
            j = neighbours[k]
            # Equal measures, as on exact planes, go to the patch around i itself, then to the lowest face.
            if measures[j] < measures[best] or (measures[j] == measures[best] and best != i and j < best):
                best = j
        guides[i, 0], guides[i, 1], guides[i, 2] = means[best, 0], means[best, 1], means[best, 2]


@compiled
def _squared_difference(normals: Floats, i: int, j: int) -> float:
    x, y, z = normals[j, 0] - normals[i, 0], normals[j, 1] - normals[i, 1], normals[j, 2] - normals[i, 2]
    return float(x * x + y * y + z * z)

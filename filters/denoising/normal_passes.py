"""The passes of a filter of face normals over a measured mesh.

Guides are, for every face, the mean normal of the most even patch around that contains it [zhang2015]. Filtering on vertices
instead of faces is there for comparison: at a crease vertex normals are means across it [yadav2021].
"""

import math
from typing import NamedTuple

import numpy as np

from ..compilation import compiled, prange
from ..execution import Progress, threads_for
from ..geometry import AREA, CENTRE, NORMAL, mean_normals_at_vertices, squared_length
from ..libraries import sparse
from ..mesh import Floats, Ints, Longs
from ..topology import one_rings
from .adjacency import Adjacency
from .face_neighbourhoods import RINGS_OF_NEIGHBORHOOD, FaceNeighbourhoods, mean_centre_distance
from .normal_filter import NormalFilter
from .normal_filters import mean_normals, weighted_normals

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
        _measure_patches(normals, np.ascontiguousarray(table[:, 3]), patches, edge_neighbours, measures, means)
        _choose(measures, means, *patches, guides)
    return guides


@compiled(parallel=True)
def _measure_patches(
    normals: Floats, areas: Floats, patches: FaceNeighbourhoods, edge: FaceNeighbourhoods, measures: Floats, means: Floats
) -> None:
    offsets, neighbours = patches
    edge_offsets, edge_neighbours = edge
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
                largest = max(largest, squared_length(normals, j, patch[b]))
        total = steepest = 0.0
        for a in range(size):
            j = patch[a]
            for k in range(edge_offsets[j], edge_offsets[j + 1]):
                h = edge_neighbours[k]
                if h <= j:
                    continue
                for b in range(size):
                    if patch[b] == h:
                        difference = math.sqrt(squared_length(normals, j, h))
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


def vertex_neighbourhoods(faces: Ints, n_vertices: int, rings: int) -> FaceNeighbourhoods:
    """The vertices at most that many edges away from every vertex, ascending, without itself."""
    near = one_rings(faces, n_vertices)
    step = sparse.csr_matrix(
        (np.ones(len(near.neighbours), dtype=np.bool_), near.neighbours, near.offsets), (n_vertices, n_vertices)
    )
    around = step
    for _ in range(rings - 1):
        around = around + around @ step
    pairs = around.tocoo()
    others = pairs.row != pairs.col
    around = sparse.csr_matrix((np.ones(int(others.sum()), dtype=np.bool_), (pairs.row[others], pairs.col[others])), around.shape)
    around.sort_indices()
    return FaceNeighbourhoods(around.indptr.astype(np.int64), around.indices.astype(np.int32))


def measure_vertices(vertices: Floats, faces: Ints, table: Floats) -> Floats:
    """(n, 8) the table of `measure_faces` for vertices: unit normal, area, coordinates.

    The normal is the mean of those of the faces at the vertex by area; the area is the sum of theirs.

    Args:
        vertices: (n, 3) coordinates of ordinary size.
        faces: (m, 3) triangles.
        table: (m, 8) of `measure_faces`.
    """
    rows = np.zeros((len(vertices), 8))
    rows[:, AREA] = np.bincount(faces.ravel(), np.repeat(table[:, AREA], 3), len(vertices))
    rows[:, NORMAL] = mean_normals_at_vertices(table[:, AREA, None] * table[:, NORMAL], faces, len(vertices))
    rows[:, CENTRE] = vertices
    return rows


class NormalPasses(NamedTuple):
    """A filter, and the neighbourhoods that it looks at."""

    settings: NormalFilter  # the filter
    adjacency: Adjacency  # the connectivity of the mesh
    edge: FaceNeighbourhoods  # the neighbours whose mean distance is the unit of `space_sigma`
    patches: FaceNeighbourhoods  # those over which "averaged" and "guided" take their means
    averaged: FaceNeighbourhoods  # those that the weighted mean goes over
    cut_off: Ints  # the faces whose averaged neighbours a border cuts off; see `follow_trend`
    distance: float | None = None  # that mean distance, if this is a part of a mesh; None to measure it

    @staticmethod
    def over(points: Floats, adjacency: Adjacency, settings: NormalFilter, distance: float | None = None) -> "NormalPasses":
        """The passes over a mesh of (n, 3) points, in the order of `adjacency`."""
        if settings.method == "vertex_normals":
            rings = RINGS_OF_NEIGHBORHOOD[settings.neighborhood]
            near = vertex_neighbourhoods(adjacency.faces, len(points), 1)
            wide = near if rings == 1 else vertex_neighbourhoods(adjacency.faces, len(points), rings)
            return NormalPasses(settings, adjacency, near, near, wide, np.empty(0, dtype=np.int32))
        edge = adjacency.around("edge")
        patches = adjacency.around("vertex") if settings.method in ("averaged", "guided") else edge
        averaged = adjacency.within(settings.neighborhood, points, settings.radius)
        return NormalPasses(
            settings, adjacency, edge, patches, averaged, adjacency.cut_off(settings.neighborhood, settings.radius), distance
        )

    def filtered(self, points: Floats, table: Floats, progress: Progress) -> Floats:
        """(m, 3) the filtered unit normals of the faces.

        Args:
            points: (n, 3) coordinates of ordinary size.
            table: (m, 8) of `measure_faces` for these points; its normals are overwritten.
            progress: called after every pass.
        """
        if self.settings.method != "vertex_normals":
            return self._passed(table, progress)
        normals = self._passed(measure_vertices(points, self.adjacency.faces, table), progress)
        sums = normals[self.adjacency.faces].sum(axis=1)
        lengths = np.linalg.norm(sums, axis=1, keepdims=True)
        # A face whose vertices' normals cancel out keeps its own.
        return np.where(lengths > 0.0, sums / np.where(lengths > 0.0, lengths, 1.0), table[:, NORMAL])

    def _passed(self, table: Floats, progress: Progress) -> Floats:
        """The normals of the table of faces or vertices after all passes, which overwrite it: a copy is large."""
        settings = self.settings
        distance = mean_centre_distance(table, self.edge) if self.distance is None else self.distance
        normals = np.ascontiguousarray(table[:, NORMAL])
        for iteration in range(settings.normal_iterations):
            if settings.method == "mean":
                normals = mean_normals(normals, table, self.averaged, overwrite=True)
            else:
                guide = self._guide(normals, table)
                normals = weighted_normals(
                    normals,
                    table,
                    self.averaged,
                    guide=guide,
                    range_kernel=settings.range_kernel,
                    range_sigma=settings.range_sigma,
                    range_measure=settings.range_measure,
                    range_floor=settings.range_floor,
                    space_kernel="constant" if settings.method == "unilateral" else settings.space_kernel,
                    space_sigma=settings.space_sigma * distance,
                    # A normal deviates from itself by 0, which outweighs all others in a kernel such as 1 / x; a guide is a mean.
                    itself=guide is not None,
                    cut_off=self.cut_off,
                    overwrite=True,
                )
            progress((iteration + 1) / settings.normal_iterations)
        return normals

    def _guide(self, normals: Floats, table: Floats) -> Floats | None:
        """The normals on which deviations are measured; None for the filtered ones themselves."""
        if self.settings.method == "averaged":
            return mean_normals(normals, table, self.patches, overwrite=True)
        if self.settings.method == "guided":
            return guide_normals(normals, table, self.patches, self.edge)
        return None

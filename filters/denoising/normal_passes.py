"""The passes of a filter of face normals over a measured mesh."""

import math
from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..execution import Progress, over_range
from ..geometry import NORMAL
from ..mesh import Floats, Ints, Longs
from ..robust import KERNEL_CODES
from .border_trend import follow_trend
from .face_neighbourhoods import RINGS_OF_NEIGHBORHOOD, FaceNeighbourhoods, mean_centre_distance
from .guided import guide_normals
from .neighbour_weight import Weighting
from .normal_filter import NormalFilter
from .normal_filters import mean_normals, weighted_normals
from .surroundings import Surroundings
from .vertex_normals import corner_means, measure_vertices, vertex_neighbourhoods

_GAUSSIAN = KERNEL_CODES["gaussian"]


class NormalPasses(NamedTuple):
    """A filter, and the neighbourhoods that it looks at.

    Attributes:
        settings: the filter.
        known: the connectivity of the mesh.
        edge: the neighbours whose mean distance is the unit of `space_sigma`.
        patches: those over which "averaged" and "guided" take their means.
        averaged: those that the weighted mean goes over.
        cut_off: the faces whose averaged neighbours a border cuts off; see `follow_trend`.
        distance: that mean distance, if this is a part of a mesh; None to measure it.
    """

    settings: NormalFilter
    known: Surroundings
    edge: FaceNeighbourhoods
    patches: FaceNeighbourhoods
    averaged: FaceNeighbourhoods
    cut_off: Ints
    distance: float | None = None

    @staticmethod
    def over(points: Floats, known: Surroundings, settings: NormalFilter, distance: float | None = None) -> "NormalPasses":
        """The passes over a mesh of (n, 3) points, in the order of `known`."""
        if settings.method == "vertex_normals":
            rings = RINGS_OF_NEIGHBORHOOD[settings.neighborhood]
            near = vertex_neighbourhoods(known.faces, len(points), 1)
            wide = near if rings == 1 else vertex_neighbourhoods(known.faces, len(points), rings)
            return NormalPasses(settings, known, near, near, wide, np.empty(0, dtype=np.int32))
        edge = known.around("edge")
        patches = known.around("vertex") if settings.method in ("averaged", "guided") else edge
        averaged = known.within(settings.neighborhood, points, settings.radius)
        return NormalPasses(
            settings, known, edge, patches, averaged, known.cut_off(settings.neighborhood, settings.radius), distance
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
        normals = self._passed(measure_vertices(points, self.known.faces, table), progress)
        return corner_means(normals, self.known.faces, table[:, NORMAL])

    def _passed(self, table: Floats, progress: Progress) -> Floats:
        """The normals of the table of faces or vertices after all passes, which overwrite it: a copy is large."""
        settings = self.settings
        distance = mean_centre_distance(table, self.edge) if self.distance is None else self.distance
        normals = np.ascontiguousarray(table[:, NORMAL])
        for iteration in range(settings.normal_iterations):
            if self._is_gaussian:
                table[:, NORMAL] = normals
                normals = gaussian_means(
                    table, self.averaged, settings.range_sigma, settings.space_sigma * distance, cut_off=self.cut_off
                )
            elif settings.method == "mean":
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

    @property
    def _is_gaussian(self) -> bool:
        """Whether the filter is the bilateral one with Gaussians of the distance and of the difference of the normals."""
        settings = self.settings
        plain = settings.method in ("bilateral", "vertex_normals") and settings.range_measure == "euclidean"
        return plain and settings.range_kernel == settings.space_kernel == "gaussian" and settings.range_floor == 0.0

    def _guide(self, normals: Floats, table: Floats) -> Floats | None:
        """The normals on which deviations are measured; None for the filtered ones themselves."""
        if self.settings.method == "averaged":
            return mean_normals(normals, table, self.patches, overwrite=True)
        if self.settings.method == "guided":
            return guide_normals(normals, table, self.patches, self.edge)
        return None


def gaussian_means(
    rows: Floats, neighbourhoods: FaceNeighbourhoods, range_sigma: float, space_sigma: float, *, cut_off: Ints | None = None
) -> Floats:
    """`weighted_normals` with two Gaussians, to the bit, in two thirds of its time.

    Args:
        rows: (m, 8) of `measure_faces`, with the normals that are averaged.
        neighbourhoods: which faces are averaged over.
        range_sigma: the standard deviation of the kernel of the difference of two normals.
        space_sigma: that of the kernel of the distance of two centres.
        cut_off: see `weighted_normals`.
    """
    # A Gaussian of scale 0 lets nothing but what is equal count.
    scales = [max(math.sqrt(2.0) * sigma, 1e-150) for sigma in (space_sigma, range_sigma)]
    per_space, per_range = (1.0 / (scale * scale) for scale in scales)
    result = np.empty((len(rows), 3))
    over_range(_gaussian_means, len(rows), rows, neighbourhoods.offsets, neighbourhoods.neighbours, per_space, per_range, result)
    if cut_off is not None:
        weighting = Weighting(_GAUSSIAN, scales[1], 0, 0.0, _GAUSSIAN, scales[0], itself=False)
        follow_trend(result, cut_off, np.ascontiguousarray(rows[:, NORMAL]), rows, neighbourhoods, weighting)
    return result


# The exponentials of a neighbourhood are taken one after the other: calls between the sums would put these aside each time.
# Unsigned indices need no look whether they count from the end.
@compiled(nogil=True)
def _gaussian_means(
    rows: Floats,
    offsets: Longs,
    neighbours: Ints,
    per_space: float,
    per_range: float,
    result: Floats,
    first: int,
    last: int,
) -> None:
    weights = np.empty(64)
    for i in range(first, last):
        gx, gy, gz = rows[i, 0], rows[i, 1], rows[i, 2]
        cx, cy, cz = rows[i, 4], rows[i, 5], rows[i, 6]
        start, count = np.uint64(offsets[i]), np.uint64(offsets[i + 1] - offsets[i])
        if count > weights.shape[0]:
            weights = np.empty(2 * count)
        for k in range(count):
            j = np.uint32(neighbours[start + k])
            dx, dy, dz = rows[j, 4] - cx, rows[j, 5] - cy, rows[j, 6] - cz
            rx, ry, rz = rows[j, 0] - gx, rows[j, 1] - gy, rows[j, 2] - gz
            distance, deviation = dx * dx + dy * dy + dz * dz, rx * rx + ry * ry + rz * rz
            weights[k] = -(distance * per_space + deviation * per_range)
        for k in range(count):
            weights[k] = math.exp(weights[k])
        x = y = z = 0.0
        for k in range(count):
            j = np.uint32(neighbours[start + k])
            weight = rows[j, 3] * weights[k]
            x += weight * rows[j, 0]
            y += weight * rows[j, 1]
            z += weight * rows[j, 2]
        length = math.sqrt(x * x + y * y + z * z)
        if length > 1e-300:
            result[i, 0], result[i, 1], result[i, 2] = x / length, y / length, z / length
        else:
            result[i, 0], result[i, 1], result[i, 2] = gx, gy, gz

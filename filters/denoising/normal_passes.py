"""The passes of a filter of face normals over a measured mesh."""

from typing import NamedTuple

import numpy as np

from ..execution import Progress
from ..geometry import NORMAL
from ..mesh import Floats, Ints
from .adjacency import Adjacency
from .face_neighbourhoods import RINGS_OF_NEIGHBORHOOD, FaceNeighbourhoods, mean_centre_distance
from .guided import guide_normals
from .normal_filter import NormalFilter
from .normal_filters import mean_normals, weighted_normals
from .vertex_normals import corner_means, measure_vertices, vertex_neighbourhoods


class NormalPasses(NamedTuple):
    """A filter, and the neighbourhoods that it looks at.

    Attributes:
        settings: the filter.
        adjacency: the connectivity of the mesh.
        edge: the neighbours whose mean distance is the unit of `space_sigma`.
        patches: those over which "averaged" and "guided" take their means.
        averaged: those that the weighted mean goes over.
        cut_off: the faces whose averaged neighbours a border cuts off; see `follow_trend`.
        distance: that mean distance, if this is a part of a mesh; None to measure it.
    """

    settings: NormalFilter
    adjacency: Adjacency
    edge: FaceNeighbourhoods
    patches: FaceNeighbourhoods
    averaged: FaceNeighbourhoods
    cut_off: Ints
    distance: float | None = None

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
        return corner_means(normals, self.adjacency.faces, table[:, NORMAL])

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

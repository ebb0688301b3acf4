"""What is around what on a mesh, found once for all passes of a filter, and for all filters of one run."""

from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from ..geometry import CENTRE, measure_faces
from ..mesh import Bools, Floats, Ints, worth_reordering
from ..topology import Corners, stars, vertex_corners
from .face_neighbourhoods import FaceNeighbourhoods, Neighborhood, face_neighbourhoods, mean_centre_distance

_Values = TypeVar("_Values", Floats, Bools)


@dataclass(frozen=True)
class Surroundings:
    """The connectivity of a mesh, to be shared by all that filter meshes of the same faces.

    Attributes:
        order: None, or (n,) a permutation: vertex i here is vertex ``order[i]`` of the mesh, so that neighbours lie near each
            other in memory. No result depends on it.
        faces: (m, 3) the triangles, by the numbers of the vertices here.
        corners: the faces at every vertex, by the same numbers.
    """

    order: Ints | None
    faces: Ints
    corners: Corners
    _kept: dict[Neighborhood, FaceNeighbourhoods] = field(default_factory=dict, repr=False)

    @staticmethod
    def of(faces: Ints, n_vertices: int) -> "Surroundings":
        """Of the (m, 3) triangles of a mesh of n vertices."""
        order = stars(faces, n_vertices, reorder=True).order if worth_reordering(faces, n_vertices) else None
        if order is not None:
            place = np.empty_like(order)
            place[order] = np.arange(n_vertices, dtype=order.dtype)
            faces = np.ascontiguousarray(place[faces])
        return Surroundings(order, faces, vertex_corners(faces, n_vertices))

    def ordered(self, values: _Values) -> _Values:
        """(n, ...) values of the vertices of the mesh, in the order here."""
        return values if self.order is None else np.ascontiguousarray(values[self.order])

    def restored(self, values: _Values) -> _Values:
        """(n, ...) values in the order here, in that of the mesh."""
        if self.order is None:
            return values
        result = np.empty_like(values)
        result[self.order] = values
        return result

    def around(self, kind: Neighborhood) -> FaceNeighbourhoods:
        """The neighbourhoods "edge", "vertex", "two_ring" or "three_ring" of the faces."""
        if kind not in self._kept:
            self._kept[kind] = face_neighbourhoods(self.faces, self.corners, kind)
        return self._kept[kind]

    def within(self, kind: Neighborhood, points: Floats, radius: float) -> FaceNeighbourhoods:
        """Any neighbourhood; for "radius" and "geodesic", the radius in mean distances of the centres of the (n, 3) points."""
        if kind not in ("radius", "geodesic"):
            return self.around(kind)
        table = measure_faces(points, self.faces)
        reach = radius * mean_centre_distance(table, self.around("edge"))
        if not reach > 0.0:
            # Where nothing has a size, all faces are in one place.
            return self.around("vertex")
        centres = np.ascontiguousarray(table[:, CENTRE])
        return face_neighbourhoods(self.faces, self.corners, kind, centres=centres, radius=reach)

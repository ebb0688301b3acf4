"""Vertex-face and face-face adjacency of a mesh, computed once for all passes of a filter and for all filters of one run.

Compressed rows hold lists of neighbours whose lengths come out of a first pass, and which a second one fills.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..compilation import allowed_threads
from ..execution import threads_for
from ..geometry import CENTRE, measure_faces
from ..mesh import Bools, Floats, Ints, Longs, NormalisedMesh, order_by_place, worth_reordering
from ..topology import VertexFaces, border_vertices, vertex_faces
from .border_trend import cut_off_by_border
from .face_neighbourhoods import FaceNeighbourhoods, Neighborhood, face_neighbourhoods, mean_centre_distance


def compressed_rows(count: int, visit: Callable[[int, Longs, Ints], None]) -> tuple[Longs, Ints]:
    """The lists of `count` elements, those of element i between its two offsets.

    Args:
        count: the number of elements.
        visit: called twice with a number of parts that may run at once, the offsets and the neighbours. First the neighbours are
            empty, and it adds the number of neighbours of element i to ``offsets[i + 1]``; then it writes them from
            ``offsets[i]`` on.

    Returns:
        (count + 1,) int64 offsets and int32 neighbours.
    """
    offsets = np.zeros(count + 1, dtype=np.int64)
    with threads_for(count):
        # Each thread has its own marks, so there are as many parts as threads; the result does not depend on their number.
        parts = allowed_threads()
        visit(parts, offsets, np.empty(0, dtype=np.int32))
        np.cumsum(offsets, out=offsets)
        neighbours = np.empty(offsets[-1], dtype=np.int32)
        visit(parts, offsets, neighbours)
    return offsets, neighbours


@dataclass(frozen=True)
class Adjacency:
    """The adjacency of a mesh, to be shared by all that filter meshes with the same faces.

    Attributes:
        places: None, or (k,) a permutation: point i here is point ``places[i]`` of the normalised mesh, so that neighbours lie
            near each other in memory. No result depends on it.
        faces: (m, 3) the triangles, by the numbers of the points here.
        at_vertices: the faces at every point, by the same numbers.
        on_border: (n,) the points on a border.
        ends: whether the surface ends at the border; not if this is cut out of a larger one.
    """

    places: Ints | None
    faces: Ints
    at_vertices: VertexFaces
    on_border: Bools
    ends: bool = True
    _kept: dict[Neighborhood, FaceNeighbourhoods] = field(default_factory=dict, repr=False)

    @staticmethod
    def of(mesh: NormalisedMesh, *, ends: bool = True) -> "Adjacency":
        """Of a mesh of triangles."""
        places = order_by_place(mesh.points, mesh.cells) if worth_reordering(mesh.cells, len(mesh)) else None
        faces = mesh.in_order(places).cells
        return Adjacency(places, faces, vertex_faces(faces, len(mesh)), border_vertices(faces, len(mesh)), ends)

    def around(self, kind: Neighborhood) -> FaceNeighbourhoods:
        """The neighbourhoods "edge", "vertex", "two_ring" or "three_ring" of the faces."""
        if kind not in self._kept:
            self._kept[kind] = face_neighbourhoods(self.faces, self.at_vertices, kind)
        return self._kept[kind]

    def within(self, kind: Neighborhood, points: Floats, radius: float) -> FaceNeighbourhoods:
        """Any neighbourhood; for "radius" and "geodesic", the radius in mean distances of the centres of the (n, 3) points."""
        if kind not in ("radius", "geodesic"):
            return self.around(kind)
        table = measure_faces(points, self.faces)
        reach = radius * mean_centre_distance(table, self.around("edge"))
        if not reach > 0.0:
            # All centres coincide, so that a radius selects nothing.
            return self.around("vertex")
        centres = np.ascontiguousarray(table[:, CENTRE])
        return face_neighbourhoods(self.faces, self.at_vertices, kind, centres=centres, radius=reach)

    def cut_off(self, kind: Neighborhood, radius: float) -> Ints:
        """The faces whose neighbourhoods the end of the surface cuts off."""
        return cut_off_by_border(self.faces, self.on_border & self.ends, kind, radius)

"""Vertex-face and face-face adjacency of a mesh, computed once for all passes of a filter and for all filters of one run."""

from dataclasses import dataclass, field

import numpy as np

from ..geometry import CENTRE, measure_faces
from ..mesh import Bools, Floats, Ints, NormalisedMesh, order_by_place, order_of_faces, worth_reordering
from ..topology import VertexFaces, border_vertices, vertex_faces
from .border_trend import cut_off_by_border
from .face_neighbourhoods import FaceNeighbourhoods, Neighborhood, face_neighbourhoods, mean_centre_distance

# Of a vertex and its faces the passes read so many times as much as three coordinates: a row of 8 numbers for each of two faces.
_SIZE = 6


@dataclass(frozen=True)
class Adjacency:
    """The adjacency of a mesh, to be shared by all that filter meshes with the same faces."""

    # None, or (k,) a permutation: point i here is point ``places[i]`` of the normalised mesh, so that neighbours lie near each
    # other in memory. No result depends on it.
    places: Ints | None
    faces: Ints  # (m, 3) the triangles, by the numbers of the points here
    at_vertices: VertexFaces  # the faces at every point, by the same numbers, in the order of the faces of the mesh
    on_border: Bools  # (n,) the points on a border
    ends: bool = True  # whether the surface ends at the border; not if this is cut out of a larger one
    face_places: Ints | None = None  # None, or (m,) a permutation: triangle f here is triangle ``face_places[f]`` of the mesh
    _kept: dict[Neighborhood, FaceNeighbourhoods] = field(default_factory=dict, repr=False)

    @staticmethod
    def of(mesh: NormalisedMesh, *, ends: bool = True, sweeps: int = 0) -> "Adjacency":
        """Of a mesh of triangles.

        Args:
            mesh: the mesh.
            ends: see the attribute.
            sweeps: how often all faces or vertices will be visited, if faces may be put into an order too in which neighbours lie
                near each other in memory: a sum over the faces around a face or a vertex has the same bits then, one over all
                faces may not. 0 if they may not.
        """
        sorts_faces = worth_reordering(mesh.cells, len(mesh), sweeps, size=_SIZE)
        reorders = sorts_faces or worth_reordering(mesh.cells, len(mesh))
        places = order_by_place(mesh.points, mesh.cells) if reorders else None
        faces, face_places = mesh.in_order(places).cells, None
        at_vertices, on_border = vertex_faces(faces, len(mesh)), border_vertices(faces, len(mesh))
        if sorts_faces:
            face_places = order_of_faces(faces, len(mesh))
            numbers = np.empty_like(face_places)
            numbers[face_places] = np.arange(len(faces), dtype=np.int32)
            at_vertices.rows[:, 0] = numbers[at_vertices.rows[:, 0]]
            faces = faces[face_places]
        return Adjacency(places, faces, at_vertices, on_border, ends, face_places)

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

"""Neighbourhoods of faces: across edges, at vertices, in k rings, or within a Euclidean or geodesic radius."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from ..checks import FilterInputError, check_choice
from ..compilation import compiled
from ..execution import over_range
from ..geometry import CENTRE, measure_faces, squared_length
from ..mesh import Bools, Floats, Ints, Longs, NormalisedMesh, order_by_place, order_of_faces, worth_reordering
from ..topology import VertexFaces, border_vertices, vertex_faces

#: "edge", "vertex": faces that share an edge or a vertex. "two_ring", "three_ring": faces within two or three steps between
#: faces that share a vertex. "radius": faces that such steps reach if all centres on the way lie in a ball around the face's
#: centre. "geodesic": faces within a distance along the surface, see `_visit_within`.
Neighborhood: TypeAlias = Literal["edge", "vertex", "two_ring", "three_ring", "radius", "geodesic"]

#: The largest number of steps in each neighbourhood without a radius.
RINGS_OF_NEIGHBORHOOD: dict[str, int] = {"edge": 1, "vertex": 1, "two_ring": 2, "three_ring": 3}
_WITHOUT_LIMIT = 1 << 30
# The radius that covers about one ring of faces that share a vertex, in mean distances of the centres of edge neighbours.
_DISTANCES_OF_RING = 2.0
# The `size` for `worth_reordering`, in units of 3 numbers: a pass reads about 2 faces, of 8 numbers each, per vertex.
_SIZE = 6


class FaceNeighbourhoods(NamedTuple):
    """The neighbours of each face i: ``neighbours[offsets[i]:offsets[i + 1]]``, each once, without i."""

    offsets: Longs  # (m + 1,) int64
    neighbours: Ints  # int32; nearer rings come first, except in "geodesic" neighbourhoods


def face_neighbourhoods(
    faces: Ints, at_vertices: VertexFaces, kind: Neighborhood, *, centres: Floats | None = None, radius: float = 0.0
) -> FaceNeighbourhoods:
    """Returns the neighbourhood of each face; `at_vertices` is from `vertex_faces`.

    "radius" and "geodesic" need the (m, 3) centres of the faces and a `radius`. The time grows with the square of the radius.
    """
    check_choice("neighborhood", kind, Neighborhood)
    touching = _listed(len(faces), _visit_touching, faces, at_vertices, kind == "edge")
    rings = RINGS_OF_NEIGHBORHOOD.get(kind, _WITHOUT_LIMIT)
    if rings == 1:
        return touching
    if rings < _WITHOUT_LIMIT:
        centres = np.empty((0, 3))
    elif centres is None or not radius > 0.0:
        raise FilterInputError("give the centres of the faces" if radius > 0.0 else f"radius is {radius}: it must be above 0")
    places = np.ascontiguousarray(centres)
    if kind == "geodesic":
        return _listed(len(faces), _visit_within, touching, places, radius)
    return _listed(len(faces), _visit, touching, rings, places, radius * radius)


def _listed(count: int, kernel: Callable[..., None], *arguments: Any) -> FaceNeighbourhoods:
    """Lists the neighbours of `count` faces by two calls of ``kernel(*arguments, offsets, neighbours, first, last)``.

    In the first call `neighbours` is empty, and the kernel writes the number of neighbours of face i to ``offsets[i + 1]``. In
    the second call it writes the neighbours from ``offsets[i]`` on.
    """
    offsets = np.zeros(count + 1, dtype=np.int64)
    over_range(kernel, count, *arguments, offsets, np.empty(0, dtype=np.int32))
    np.cumsum(offsets, out=offsets)
    neighbours = np.empty(offsets[-1], dtype=np.int32)
    over_range(kernel, count, *arguments, offsets, neighbours)
    return FaceNeighbourhoods(offsets, neighbours)


def mean_centre_distance(table: Floats, edge_neighbours: FaceNeighbourhoods) -> float:
    """Returns the mean distance between centres of edge neighbours, by the table of `measure_faces`; 0 if there are none."""
    count = len(edge_neighbours.neighbours)
    # An exact sum does not depend on the order of the faces. Iterating over the buffer is faster than over the array.
    return math.fsum(centre_distance_sums(table, edge_neighbours).data) / count if count else 0.0


def centre_distance_sums(table: Floats, edge_neighbours: FaceNeighbourhoods) -> Floats:
    """Returns (m,) the sum of the distances from each face's centre to its neighbours' centres."""
    sums: Floats = np.empty(len(table))
    over_range(_sum_distances, len(table), table[:, CENTRE], *edge_neighbours, sums)
    return sums


@dataclass(frozen=True)
class Adjacency:
    """The face neighbourhoods of a mesh, shared by all filter passes on meshes with the same faces."""

    # None, or (n,) a permutation that puts neighbours near each other in memory: point i here is point ``places[i]`` of the
    # normalised mesh.
    places: Ints | None
    faces: Ints  # (m, 3) the triangles, as indices of the permuted points
    at_vertices: VertexFaces  # the faces at each permuted point, in the order of the faces of the mesh
    on_border: Bools  # (n,) which points are on a border
    ends: bool = True  # whether the surface ends at the border; False if the mesh is cut out of a larger mesh
    face_places: Ints | None = None  # None, or (m,) a permutation: triangle f here is triangle ``face_places[f]`` of the mesh
    _kept: dict[Neighborhood, FaceNeighbourhoods] = field(default_factory=dict, repr=False)

    @staticmethod
    def of(mesh: NormalisedMesh, *, ends: bool = True, sweeps: int = 0) -> "Adjacency":
        """Returns the adjacency of a triangle mesh; faces are reordered in memory if that saves time in `sweeps` filter passes.

        With 0 sweeps faces keep their order. Reordering may change bits of sums over all faces, never of sums around one face.
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
        """Returns the neighbourhoods of a kind without a radius."""
        if kind not in self._kept:
            self._kept[kind] = face_neighbourhoods(self.faces, self.at_vertices, kind)
        return self._kept[kind]

    def within(self, kind: Neighborhood, points: Floats, radius: float) -> FaceNeighbourhoods:
        """Returns neighbourhoods of any kind for vertices `points`; `radius` is in mean centre distances of edge neighbours."""
        if kind in RINGS_OF_NEIGHBORHOOD:
            return self.around(kind)
        table = measure_faces(points, self.faces)
        reach = radius * mean_centre_distance(table, self.around("edge"))
        if not reach > 0.0:  # no edge neighbours, or their centres coincide
            return self.around("vertex")
        return face_neighbourhoods(self.faces, self.at_vertices, kind, centres=table[:, CENTRE], radius=reach)

    def cut_off(self, kind: Neighborhood, radius: float) -> Ints:
        """Returns the faces, ascending, whose neighbourhoods may be cut off where the surface ends; `radius`: see `within`."""
        near = self.on_border & self.ends
        cut = near[self.faces].any(axis=1)
        for _ in range(1, RINGS_OF_NEIGHBORHOOD.get(kind, math.ceil(radius / _DISTANCES_OF_RING)) if cut.any() else 0):
            near[self.faces[cut]] = True
            cut = near[self.faces].any(axis=1)
        return np.flatnonzero(cut).astype(np.int32)


@compiled(nogil=True)
def _sum_distances(centres: Floats, offsets: Longs, neighbours: Ints, sums: Floats, first: int, last: int) -> None:
    for i in range(first, last):
        total = 0.0
        for k in range(offsets[i], offsets[i + 1]):
            total += np.sqrt(squared_length(centres, i, neighbours[k]))
        sums[i] = total


@compiled(nogil=True)
def _visit_touching(
    faces: Ints, at_vertices: VertexFaces, whole_edges: bool, offsets: Longs, neighbours: Ints, first: int, last: int
) -> None:
    """Lists for `_listed` the faces that share a vertex, or an edge if `whole_edges`, each once."""
    row_offsets, rows = at_vertices
    for i in range(first, last):
        a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
        if a == b or b == c or c == a:
            continue
        at = start = offsets[i] if neighbours.shape[0] else 0
        for corner, (v, following, before) in enumerate(((a, b, c), (b, c, a), (c, a, b))):
            for k in range(row_offsets[v], row_offsets[v + 1]):
                p, q = rows[k, 1], rows[k, 2]
                has_following, has_before = p == following or q == following, p == before or q == before
                if whole_edges:
                    # A face with the same three corners was listed at the first edge.
                    if not has_following or (corner > 0 and has_before):
                        continue
                elif (corner > 0 and has_before) or (corner == 2 and has_following):
                    continue
                if rows[k, 0] != i:
                    if neighbours.shape[0]:
                        neighbours[at] = rows[k, 0]
                    at += 1
        if not neighbours.shape[0]:
            offsets[i + 1] = at - start


@compiled(nogil=True)
def _visit(
    touching: FaceNeighbourhoods,
    rings: int,
    centres: Floats,
    square: float,
    offsets: Longs,
    neighbours: Ints,
    first: int,
    last: int,
) -> None:
    """Lists for `_listed` the faces within `rings` steps; with `centres`, steps stay within sqrt(`square`) of i's centre."""
    near_offsets, near = touching
    seen = np.full(near_offsets.shape[0] - 1, -1, dtype=np.int32)
    queue = np.empty(64, dtype=np.int32)
    for i in range(first, last):
        seen[i] = i
        queue[0] = i
        begin, end, count = 0, 1, 1
        for _ in range(rings):
            for at in range(begin, end):
                for k in range(near_offsets[queue[at]], near_offsets[queue[at] + 1]):
                    h = near[k]
                    if seen[h] == i:
                        continue
                    seen[h] = i
                    if centres.shape[0] and squared_length(centres, i, h) > square:
                        continue
                    if count == queue.shape[0]:
                        queue = np.concatenate((queue, queue))
                    queue[count] = h
                    count += 1
            begin, end = end, count
            if begin == end:
                break
        if neighbours.shape[0]:
            neighbours[offsets[i] : offsets[i + 1]] = queue[1:count]
        else:
            offsets[i + 1] = count - 1


@compiled(nogil=True)
def _visit_within(
    touching: FaceNeighbourhoods, centres: Floats, radius: float, offsets: Longs, neighbours: Ints, first: int, last: int
) -> None:
    """Lists for `_listed` the faces j with d(i, j) <= radius, where d is the length of the shortest path along face centres.

    A path steps between faces that share a vertex. On a plane of equilateral triangles paths are up to 3.6 % longer than straight
    lines; across a right-angled edge they are up to 29 % shorter than paths on the surface. The search extends each path that it
    has found or shortened, until none changes; for few faces this is faster than a priority queue.
    """
    near_offsets, near = touching
    seen = np.full(centres.shape[0], -1, dtype=np.int32)
    place = np.empty(centres.shape[0], dtype=np.int32)
    met, length, shortened = np.empty(64, dtype=np.int32), np.empty(64), np.empty(64, dtype=np.bool_)
    for i in range(first, last):
        seen[i], place[i] = i, 0
        met[0], length[0], shortened[0] = i, 0.0, True
        count, changed = 1, True
        while changed:
            changed = False
            at = 0
            while at < count:
                if shortened[at]:
                    shortened[at] = False
                    g = met[at]
                    for k in range(near_offsets[g], near_offsets[g + 1]):
                        h = near[k]
                        distance = length[at] + np.sqrt(squared_length(centres, g, h))
                        if distance > radius or (seen[h] == i and distance >= length[place[h]]):
                            continue
                        if seen[h] != i:
                            if count == met.shape[0]:
                                met, length = np.concatenate((met, met)), np.concatenate((length, length))
                                shortened = np.concatenate((shortened, shortened))
                            seen[h], place[h], met[count] = i, count, h
                            count += 1
                        length[place[h]], shortened[place[h]] = distance, True
                        changed = True
                at += 1
        if neighbours.shape[0]:
            neighbours[offsets[i] : offsets[i + 1]] = met[1:count]
        else:
            offsets[i + 1] = count - 1

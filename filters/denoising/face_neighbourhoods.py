"""The faces around a face: across its edges, at its vertices, in k rings, or within a radius, straight or along the surface."""

import math
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from ..checks import FilterInputError, check_choice
from ..compilation import compiled, prange
from ..execution import over_range
from ..geometry import CENTRE
from ..mesh import Floats, Ints, Longs
from ..topology import VertexFaces
from .compressed_rows import compressed_rows

#: "edge": the faces that share an edge with it. "vertex": those that share a vertex. "two_ring" and "three_ring": two and three
#: steps between faces that share a vertex. "radius": those whose centres lie within a distance, reached by steps between such
#: faces alone. "geodesic": those within a distance along the surface, see `_within_geodesic_radius`.
Neighborhood: TypeAlias = Literal["edge", "vertex", "two_ring", "three_ring", "radius", "geodesic"]
NEIGHBORHOODS: tuple[Neighborhood, ...] = get_args(Neighborhood)

#: how many steps between faces that share a vertex the neighbourhoods are, those that have no radius
RINGS_OF_NEIGHBORHOOD: dict[str, int] = {"edge": 1, "vertex": 1, "two_ring": 2, "three_ring": 3}
_WITHOUT_LIMIT = 1 << 30


class FaceNeighbourhoods(NamedTuple):
    """The faces around every face i: ``neighbours[offsets[i]:offsets[i + 1]]``, each once, without i, nearer rings first."""

    offsets: Longs  # (m + 1,) int64
    neighbours: Ints  # int32


def face_neighbourhoods(
    faces: Ints, at_vertices: VertexFaces, kind: Neighborhood, *, centres: Floats | None = None, radius: float = 0.0
) -> FaceNeighbourhoods:
    """The neighbourhood of every face, in time linear in the neighbours.

    Args:
        faces: (m, 3) triangles.
        at_vertices: the faces at every vertex, of `vertex_faces`.
        kind: which faces are neighbours.
        centres: (m, 3) centres of the faces, for "radius" and "geodesic".
        radius: the largest distance of two centres, for these, in the unit of the centres. Larger is slower, by its square.

    Raises:
        FilterInputError: no such neighbourhood, or no radius.
    """
    check_choice("neighborhood", kind, NEIGHBORHOODS)
    if kind in ("radius", "geodesic"):
        if centres is None or not radius > 0.0:
            raise FilterInputError(f"radius {radius} is not above 0")
        if kind == "geodesic":
            near = _touching(faces, at_vertices, whole_edges=False)
            return _within_geodesic_radius(near, np.ascontiguousarray(centres), radius)
        return _gather(faces, at_vertices, _WITHOUT_LIMIT, np.ascontiguousarray(centres), radius * radius)
    if kind in ("edge", "vertex"):
        return _touching(faces, at_vertices, whole_edges=kind == "edge")
    return _gather(faces, at_vertices, RINGS_OF_NEIGHBORHOOD[kind], np.empty((0, 3)), 0.0)


def mean_centre_distance(table: Floats, edge_neighbours: FaceNeighbourhoods) -> float:
    """The mean distance of the centres of two faces that share an edge, in mesh units; 0 if no two faces do.

    Args:
        table: (m, 8) of `measure_faces`.
        edge_neighbours: the neighbourhoods "edge".
    """
    sums = centre_distance_sums(table, edge_neighbours)
    count = len(edge_neighbours.neighbours)
    # Exact, so that the order of the faces does not matter; the buffer gives its numbers faster than the array does.
    return math.fsum(sums.data) / count if count else 0.0


def centre_distance_sums(table: Floats, edge_neighbours: FaceNeighbourhoods) -> Floats:
    """(m,) for each face the sum of the distances of its centre from those of its neighbours; see `mean_centre_distance`."""
    sums: Floats = np.empty(len(table))
    over_range(_sum_distances, len(table), table[:, CENTRE], edge_neighbours.offsets, edge_neighbours.neighbours, sums)
    return sums


def _touching(faces: Ints, at_vertices: VertexFaces, *, whole_edges: bool) -> FaceNeighbourhoods:
    """The faces that share a vertex with each face, or if `whole_edges` an edge."""

    def visit(parts: int, offsets: Longs, neighbours: Ints) -> None:
        over_range(_visit_touching, len(faces), faces, at_vertices.offsets, at_vertices.rows, whole_edges, offsets, neighbours)

    return FaceNeighbourhoods(*compressed_rows(len(faces), visit))


@compiled(nogil=True)
def _visit_touching(
    faces: Ints,
    row_offsets: Longs,
    rows: Ints,
    whole_edges: bool,
    offsets: Longs,
    neighbours: Ints,
    first: int,
    last: int,
) -> None:
    """`compressed_rows` asks for it. A face that touches in several places is listed at the first: its row tells its corners."""
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
                    # A face with all three corners has been met at the first edge.
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


def _gather(faces: Ints, at_vertices: VertexFaces, rings: int, centres: Floats, squared_radius: float) -> FaceNeighbourhoods:
    def visit(parts: int, offsets: Longs, neighbours: Ints) -> None:
        _visit(faces, at_vertices.offsets, at_vertices.rows, rings, centres, squared_radius, parts, offsets, neighbours)

    return FaceNeighbourhoods(*compressed_rows(len(faces), visit))


@compiled(parallel=True)
def _visit(
    faces: Ints,
    row_offsets: Longs,
    rows: Ints,
    rings: int,
    centres: Floats,
    squared_radius: float,
    parts: int,
    offsets: Longs,
    neighbours: Ints,
) -> None:
    """`compressed_rows` asks for it."""
    for part in prange(parts):
        first, last = part * faces.shape[0] // parts, (part + 1) * faces.shape[0] // parts
        _visit_some(faces, row_offsets, rows, rings, centres, squared_radius, first, last, offsets, neighbours)


@compiled
def _visit_some(
    faces: Ints,
    row_offsets: Longs,
    rows: Ints,
    rings: int,
    centres: Floats,
    squared_radius: float,
    first: int,
    last: int,
    offsets: Longs,
    neighbours: Ints,
) -> None:
    """`_visit` for the faces from `first` to before `last`."""
    seen = np.full(faces.shape[0], -1, dtype=np.int32)
    queue = np.empty(64, dtype=np.int32)
    for i in range(first, last):
        if faces[i, 0] == faces[i, 1] or faces[i, 1] == faces[i, 2] or faces[i, 2] == faces[i, 0]:
            continue
        seen[i] = i
        queue[0] = i
        begin, end, found = 0, 1, 1
        for _ in range(rings):
            for at in range(begin, end):
                g = queue[at]
                for corner in range(3):
                    v = faces[g, corner]
                    for k in range(row_offsets[v], row_offsets[v + 1]):
                        h = rows[k, 0]
                        if seen[h] == i:
                            continue
                        seen[h] = i
                        if centres.shape[0] and _squared_distance(centres, i, h) > squared_radius:
                            continue
                        if found == queue.shape[0]:
                            queue = np.concatenate((queue, queue))
                        queue[found] = h
                        found += 1
            begin, end = end, found
            if begin == end:
                break
        if neighbours.shape[0]:
            neighbours[offsets[i] : offsets[i + 1]] = queue[1:found]
        else:
            offsets[i + 1] = found - 1


@compiled
def _squared_distance(centres: Floats, i: int, j: int) -> float:
    x, y, z = centres[j, 0] - centres[i, 0], centres[j, 1] - centres[i, 1], centres[j, 2] - centres[i, 2]
    return float(x * x + y * y + z * z)


@compiled(nogil=True)
def _sum_distances(centres: Floats, offsets: Longs, neighbours: Ints, sums: Floats, first: int, last: int) -> None:
    for i in range(first, last):
        total = 0.0
        for k in range(offsets[i], offsets[i + 1]):
            total += np.sqrt(_squared_distance(centres, i, neighbours[k]))
        sums[i] = total


def _within_geodesic_radius(near: FaceNeighbourhoods, centres: Floats, radius: float) -> FaceNeighbourhoods:
    """The faces j around every face i with d(i, j) <= radius, d the length of the shortest path of steps from centre to centre.

    A step goes straight to the centre of a face that shares a vertex. On a plane of equal triangles such paths are up to 3.6 %
    longer than straight lines, 2.2 % in the mean. Across a crease a step is shorter than the path on the surface, at a right
    angle by up to 29 %, at the rim of a thin wall by more. Two sheets that lie close together without being connected nearby are
    as far apart as the path along the surface is long. Faces are listed in the order of the search; `near` are those that share a
    vertex.
    """

    def visit(parts: int, offsets: Longs, neighbours: Ints) -> None:
        _visit_within(*near, centres, radius, parts, offsets, neighbours)

    return FaceNeighbourhoods(*compressed_rows(len(centres), visit))


@compiled(parallel=True)
def _visit_within(
    near_offsets: Longs, near: Ints, centres: Floats, radius: float, parts: int, offsets: Longs, neighbours: Ints
) -> None:
    """`compressed_rows` asks for it."""
    for part in prange(parts):
        first, last = part * centres.shape[0] // parts, (part + 1) * centres.shape[0] // parts
        _visit_some_within(near_offsets, near, centres, radius, first, last, offsets, neighbours)


@compiled
def _visit_some_within(
    near_offsets: Longs, near: Ints, centres: Floats, radius: float, first: int, last: int, offsets: Longs, neighbours: Ints
) -> None:
    """`_visit_within` for the faces from `first` to before `last`.

    A face whose path has become shorter passes this on to its neighbours, until none has. With few faces this is faster than a
    queue ordered by length, and the lengths are the same.
    """
    seen = np.full(centres.shape[0], -1, dtype=np.int32)
    place = np.empty(centres.shape[0], dtype=np.int32)
    met, length, shortened = np.empty(64, dtype=np.int32), np.empty(64), np.empty(64, dtype=np.bool_)
    for i in range(first, last):
        seen[i], place[i] = i, 0
        met[0], length[0], shortened[0] = i, 0.0, True
        found, again = 1, True
        while again:
            again = False
            at = 0
            while at < found:
                if shortened[at]:
                    shortened[at] = False
                    g = met[at]
                    for k in range(near_offsets[g], near_offsets[g + 1]):
                        h = near[k]
                        x, y, z = centres[h, 0] - centres[g, 0], centres[h, 1] - centres[g, 1], centres[h, 2] - centres[g, 2]
                        way = length[at] + np.sqrt(x * x + y * y + z * z)
                        if way > radius or (seen[h] == i and way >= length[place[h]]):
                            continue
                        if seen[h] != i:
                            if found == met.shape[0]:
                                met, length = np.concatenate((met, met)), np.concatenate((length, length))
                                shortened = np.concatenate((shortened, shortened))
                            seen[h], place[h], met[found] = i, found, h
                            found += 1
                        length[place[h]], shortened[place[h]] = way, True
                        again = True
                at += 1
        if neighbours.shape[0]:
            neighbours[offsets[i] : offsets[i + 1]] = met[1:found]
        else:
            offsets[i + 1] = found - 1

"""Measures of triangles and loops, in the unit of the coordinates: lengths, angles, normals, areas, quality, closest points."""

import math
from typing import NamedTuple

import numpy as np

from .compilation import compiled, prange
from .execution import blocks, over_range, threads_for
from .mesh import Bools, Floats, Ints, Longs
from .topology import edges, face_adjacency, vertex_faces

__all__ = [
    "AREA",
    "CENTRE",
    "NORMAL",
    "WalkableSurface",
    "angle_at",
    "angles_between",
    "area_vector",
    "closest_weights",
    "corner_angles",
    "cross_product",
    "cross_products",
    "edge_lengths",
    "face_areas",
    "face_normals",
    "looking_away",
    "mean_edge_length",
    "mean_normals_at_vertices",
    "measure_faces",
    "nearest_by_walk",
    "quality_and_normal",
    "roughness",
    "seen_from_one_side",
    "side_lengths",
    "squared_length",
    "turned_faces",
    "unit_vectors",
    "vector_lengths",
    "vertex_normals_by_angle",
    "vertex_normals_by_area",
]

#: The columns in the table of `measure_faces`: the unit normal, the area, the centre; the eighth column is unused.
NORMAL, AREA, CENTRE = slice(0, 3), 3, slice(4, 7)
# Lengths in this range can be squared without overflow or underflow.
_SQUARED = 1e-140, 1e140
# The most steps of one walk; queries start at most a few faces away.
_LONGEST_WALK = 64


@compiled
def cross_product(points: Floats, a: int, b: int, c: int) -> tuple[float, float, float]:
    """Returns (b - a) x (c - a): its length is twice the area, and (a, b, c) is counter-clockwise if seen from its tip."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@compiled
def squared_length(points: Floats, a: int, b: int) -> float:
    """The square of the distance between two points."""
    x, y, z = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    return float(x * x + y * y + z * z)


@compiled
def angle_at(points: Floats, a: int, b: int, c: int) -> float:
    """The angle at a between b and c, from 0 to pi; 0 or pi if two points coincide."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    nx, ny, nz = cross_product(points, a, b, c)
    return float(np.arctan2(np.sqrt(nx * nx + ny * ny + nz * nz), ux * vx + uy * vy + uz * vz))


@compiled
def quality_and_normal(points: Floats, a: int, b: int, c: int) -> tuple[float, float, float, float]:
    """Returns the quality l / (sqrt(3) R) and the unit normal of the triangle (a, b, c); zeros if it has no area.

    Here l is the shortest edge and R the circumradius. The quality is 1 for equilateral triangles and near 0 for slivers.
    """
    nx, ny, nz = cross_product(points, a, b, c)
    doubled = np.sqrt(nx * nx + ny * ny + nz * nz)
    if not doubled > 0.0:
        return 0.0, 0.0, 0.0, 0.0
    first, second = np.sqrt(squared_length(points, a, b)), np.sqrt(squared_length(points, a, c))
    third = np.sqrt(squared_length(points, b, c))
    # R is the product of the edge lengths divided by four times the area.
    quality = 2.0 * doubled * min(first, second, third) / (np.sqrt(3.0) * first * second * third)
    return quality, nx / doubled, ny / doubled, nz / doubled


def angles_between(first: Floats, second: Floats) -> Floats:
    """(k,) the angles between two sets of (k, 3) vectors of any length, in radians from 0 to pi; 0 or pi if one vector is 0.

    They come from the arc tangent, since the arc cosine loses digits of small angles.
    """
    sines = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.arctan2(sines, np.einsum("ij,ij->i", first, second)))


def corner_angles(vertices: Floats, faces: Ints) -> Floats:
    """(m, 3) the angle of every face at each of its vertices, in radians; 0 or pi if two of these vertices coincide."""
    angles = np.empty(faces.shape)
    _fill_corner_angles(np.ascontiguousarray(vertices, dtype=np.float64), faces, angles)
    return angles


@compiled(nogil=True)
def _fill_corner_angles(points: Floats, faces: Ints, angles: Floats) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f]
        angles[f] = angle_at(points, a, b, c), angle_at(points, b, c, a), angle_at(points, c, a, b)


def area_vector(loop: Floats) -> Floats:
    """(3,) half the sum of p_i x p_(i + 1): a plane loop's area times the unit normal around which it is counter-clockwise."""
    centred = loop - loop.mean(axis=0)
    return np.asarray(np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0) / 2.0)


def side_lengths(loop: Floats) -> Floats:
    """(k,) the length of each side of a closed loop, from each point to the next."""
    return np.asarray(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1))


def mean_edge_length(vertices: Floats, faces_or_edges: Ints) -> float:
    """The mean length of the edges of faces, or of (e, 2) edges of two different vertices, each edge once; 0 without edges."""
    if faces_or_edges.shape[1] == 3:
        pairs = edges(faces_or_edges)
    else:
        pairs = np.sort(faces_or_edges[faces_or_edges[:, 0] != faces_or_edges[:, 1]], axis=1)
        pairs = pairs[np.sort(np.unique(pairs @ np.array([1 << 32, 1]), return_index=True)[1])]  # in the given order
    if len(pairs) == 0:
        return 0.0
    return float(edge_lengths(vertices, pairs).mean())


def edge_lengths(vertices: Floats, pairs: Ints) -> Floats:
    """(e,) the lengths of (e, 2) edges, however long or short. An edge whose length is far below the longest may get 0."""
    lengths = np.empty(len(pairs))
    points, ends = np.ascontiguousarray(vertices, dtype=np.float64), np.ascontiguousarray(pairs, dtype=np.int32)
    over_range(_measure_edges, len(pairs), points, ends, lengths)
    if len(pairs) and not _SQUARED[0] < lengths.max() < _SQUARED[1]:
        return vector_lengths(vertices[pairs[:, 1]] - vertices[pairs[:, 0]])
    return lengths


@compiled(nogil=True)
def _measure_edges(vertices: Floats, pairs: Ints, lengths: Floats, first: int, last: int) -> None:
    for e in range(first, last):
        lengths[e] = math.sqrt(squared_length(vertices, pairs[e, 0], pairs[e, 1]))


def vector_lengths(vectors: Floats) -> Floats:
    """(n,) the lengths of (n, 3) vectors, however long or short. A vector whose length is far below the longest may get 0."""
    with np.errstate(over="ignore", under="ignore"):
        lengths = np.asarray(np.linalg.norm(vectors, axis=1))
    if len(vectors) and not _SQUARED[0] < lengths.max() < _SQUARED[1]:
        exponent = int(np.frexp(np.abs(vectors).max())[1])
        return np.asarray(np.ldexp(np.linalg.norm(np.ldexp(vectors, -exponent), axis=1), exponent))
    return lengths


@compiled
def closest_weights(
    ux: float, uy: float, uz: float, vx: float, vy: float, vz: float, px: float, py: float, pz: float
) -> tuple[float, float]:
    """Returns s and t, where s u + t v is the point of the triangle (0, u, v) nearest to p.

    If p projects outside the triangle, s = 0, t = 0 or s + t = 1 exactly.
    """
    d1, d2 = ux * px + uy * py + uz * pz, vx * px + vy * py + vz * pz
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    determinant = uu * vv - uv * uv
    s, t = vv * d1 - uv * d2, uu * d2 - uv * d1
    if determinant > 0.0 and s >= 0.0 and t >= 0.0 and s + t <= determinant:
        return s / determinant, t / determinant
    # Each edge has a nearest point; the result is the nearest of the three.
    s1 = min(max(d1 / uu, 0.0), 1.0) if uu > 0.0 else 0.0
    t2 = min(max(d2 / vv, 0.0), 1.0) if vv > 0.0 else 0.0
    ww = uu - 2.0 * uv + vv
    t3 = min(max((d2 - d1 - uv + uu) / ww, 0.0), 1.0) if ww > 0.0 else 0.0
    s, t, best = s1, 0.0, s1 * s1 * uu - 2.0 * s1 * d1
    other = t2 * t2 * vv - 2.0 * t2 * d2
    if other < best:
        s, t, best = 0.0, t2, other
    s3 = 1.0 - t3
    other = s3 * s3 * uu + 2.0 * s3 * t3 * uv + t3 * t3 * vv - 2.0 * (s3 * d1 + t3 * d2)
    if other < best:
        s, t = s3, t3
    return s, t


def measure_faces(vertices: Floats, faces: Ints, table: Floats | None = None) -> Floats:
    """(m, 8) the unit normal, the area and the centre of every face, and an unused number.

    A row fills one cache line, so a sweep over neighbouring faces loads one line per face. A face without area has the normal 0.
    The coordinates are of ordinary size, as in a `NormalisedMesh`: no square over- or underflows. A given `table` is overwritten.
    """
    table = np.zeros((len(faces), 8)) if table is None else table
    over_range(_measure_faces, len(faces), vertices, faces, table)
    return table


def face_normals(vertices: Floats, faces: Ints) -> Floats:
    """(m, 3) the unit normals of the faces; 0 where a face has no area."""
    return _measured(vertices, faces, NORMAL, np.empty((len(faces), 3)))


def face_areas(vertices: Floats, faces: Ints) -> Floats:
    """(m,) the areas of the faces."""
    return _measured(vertices, faces, AREA, np.empty(len(faces)))


def _measured(vertices: Floats, faces: Ints, columns: slice | int, values: Floats) -> Floats:
    """Fills `values` with columns of `measure_faces`, block by block: the table of all faces would not fit into the cache."""
    for part in blocks(len(faces)):
        values[part] = measure_faces(vertices, faces[part])[:, columns]
    return values


def roughness(points: Floats, faces: Ints) -> float:
    """The mean of |n_f - n_g| over the unit normals of adjacent faces: 0 in a plane, 2 at folds; 0 without adjacent faces."""
    pairs, _ = face_adjacency(faces)
    sides = face_normals(points, faces)[pairs]
    return float(np.linalg.norm(sides[:, 0] - sides[:, 1], axis=1).mean()) if len(pairs) else 0.0


def cross_products(vertices: Floats, faces: Ints) -> Floats:
    """(m, 3) (b - a) x (c - a) of the faces (a, b, c): normals whose length is twice the area."""
    crosses = np.empty((len(faces), 3))
    _fill_crosses(np.ascontiguousarray(vertices, dtype=np.float64), np.ascontiguousarray(faces, dtype=np.int32), crosses)
    return crosses


@compiled(nogil=True)
def _fill_crosses(points: Floats, faces: Ints, crosses: Floats) -> None:
    for f in range(faces.shape[0]):
        crosses[f, 0], crosses[f, 1], crosses[f, 2] = cross_product(points, faces[f, 0], faces[f, 1], faces[f, 2])


def seen_from_one_side(vertices: Floats, faces: Ints) -> float:
    """How much faces look to one side, |sum A n| / sum A of areas A and normals n: 1 for a plane, 0 if closed or without area."""
    crosses = cross_products(vertices, faces)
    total = float(np.linalg.norm(crosses, axis=1).sum())
    return float(np.linalg.norm(crosses.sum(axis=0))) / total if total > 0.0 else 0.0


def turned_faces(before: Floats, after: Floats, faces: Ints) -> int:
    """Counts the faces that turn by more than a right angle from `before` to `after`, (n, 3) coordinates of ordinary size."""
    return int(((cross_products(before, faces) * cross_products(after, faces)).sum(axis=1) < 0.0).sum())


@compiled(nogil=True)
def _measure_faces(vertices: Floats, faces: Ints, table: Floats, first: int, last: int) -> None:
    for f in range(first, last):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        x, y, z = cross_product(vertices, a, b, c)
        length = np.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            table[f, 0], table[f, 1], table[f, 2] = x / length, y / length, z / length
        else:
            table[f, 0] = table[f, 1] = table[f, 2] = 0.0
        table[f, 3] = 0.5 * length
        for k in range(3):
            table[f, 4 + k] = (vertices[a, k] + vertices[b, k] + vertices[c, k]) / 3.0


def vertex_normals_by_area(points: Floats, faces: Ints) -> Floats:
    """(n, 3) area-weighted means of the face normals, scaled to length 1; 0 without a face. Coordinates are of ordinary size."""
    return mean_normals_at_vertices(cross_products(points, faces), faces, len(points))


def mean_normals_at_vertices(of_faces: Floats, faces: Ints, n_vertices: int) -> Floats:
    """(n, 3) unit vectors, each along the sum of the (m, 3) vectors of the faces at a vertex; 0 for vertices without a face."""
    normals = np.stack([np.bincount(faces.ravel(), np.repeat(column, 3), n_vertices) for column in of_faces.T], axis=1)
    return unit_vectors(np.asarray(normals, np.float64))


def unit_vectors(vectors: Floats) -> Floats:
    """(n, 3) the vectors scaled to length 1; 0 stays 0."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0.0, lengths, 1.0))


def vertex_normals_by_angle(vertices: Floats, faces: Ints) -> Floats:
    """(n, 3) unit normals of the vertices: angle-weighted means of the face normals [thurmer1998]; 0 without a face."""
    normals = np.zeros((len(vertices), 3))
    _add_by_angle(vertices, faces, normals)
    return unit_vectors(normals)


@compiled
def _add_by_angle(vertices: Floats, faces: Ints, normals: Floats) -> None:
    sides = np.empty((3, 3))
    for f in range(faces.shape[0]):
        for k in range(3):
            a, b = faces[f, k], faces[f, (k + 1) % 3]
            x, y, z = (vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2])
            largest = max(abs(x), abs(y), abs(z))
            if largest > 0.0:
                x, y, z = x / largest, y / largest, z / largest
            length = math.sqrt(x * x + y * y + z * z)
            if length > 0.0:
                x, y, z = x / length, y / length, z / length
            sides[k, 0], sides[k, 1], sides[k, 2] = x, y, z
        x = sides[0, 1] * sides[1, 2] - sides[0, 2] * sides[1, 1]
        y = sides[0, 2] * sides[1, 0] - sides[0, 0] * sides[1, 2]
        z = sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0]
        length = math.sqrt(x * x + y * y + z * z)
        if length == 0.0:
            continue
        for k in range(3):
            before = (k + 2) % 3
            cosine = -(sides[k, 0] * sides[before, 0] + sides[k, 1] * sides[before, 1] + sides[k, 2] * sides[before, 2])
            angle = math.acos(min(max(cosine, -1.0), 1.0)) / length
            i = faces[f, k]
            normals[i, 0] += angle * x
            normals[i, 1] += angle * y
            normals[i, 2] += angle * z


def looking_away(normals: Floats, faces: Ints, count: int) -> Bools:
    """(m,) whether a face looks away from the sum of the normals of all faces at its three vertices.

    The lengths of the (m, 3) normals are proportional to the areas of the faces; `count` is the number of vertices.
    """
    away = np.empty(len(faces), dtype=np.bool_)
    _mark_looking_away(normals, faces, np.zeros((count, 3)), away)
    return away


@compiled(nogil=True)
def _mark_looking_away(normals: Floats, faces: Ints, sums: Floats, away: Bools) -> None:
    for f in range(len(faces)):
        for k in range(3):
            for c in range(3):
                sums[faces[f, k], c] += normals[f, c]
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        product = square = 0.0
        for d in range(3):
            product += normals[f, d] * (sums[a, d] + sums[b, d] + sums[c, d])
            square += normals[f, d] * normals[f, d]
        away[f] = product < -1e-9 * square  # not < 0: normals of coincident, opposite faces cancel only up to rounding


class WalkableSurface(NamedTuple):
    """A triangle mesh with the faces at every vertex."""

    points: Floats  # (n, 3) coordinates
    faces: Ints  # (m, 3) triangles
    offsets: Longs  # (n + 1,)
    around: Ints  # the faces at vertex i are ``around[offsets[i]:offsets[i + 1]]``, ascending

    @classmethod
    def of(cls, points: Floats, faces: Ints) -> "WalkableSurface":
        around = vertex_faces(faces, len(points))
        return cls(points, faces, around.offsets, np.ascontiguousarray(around.rows[:, 0]))

    def first_faces(self) -> Ints:
        """(n,) int32 the face of lowest index at every vertex; 0 at vertices without a face."""
        has_faces = np.diff(self.offsets) > 0
        first = np.zeros(len(self.points), dtype=np.int32)
        first[has_faces] = self.around[self.offsets[:-1][has_faces]]
        return first

    def closest(self, queries: Floats, start: Ints, enough: float = 0.0) -> tuple[Floats, Ints, Floats]:
        """Returns the (q, 3) points nearest to the queries, (q,) their faces, and (q,) the distances.

        Each walk starts at a face of `start` and steps to the nearest face that shares a vertex, until no such face is nearer,
        the distance is at most `enough`, or 64 steps are done. It stays on one sheet; another sheet of the surface may be nearer.
        """
        nearest, faces = np.empty_like(queries), np.array(start, dtype=np.int32)
        distances = np.empty(len(queries))
        with threads_for(len(queries)):
            _walk(self, queries, enough * enough, nearest, faces, distances)
        return nearest, faces, distances


@compiled
def _closest_on_triangle(points: Floats, a: int, b: int, c: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    s, t = closest_weights(ux, uy, uz, vx, vy, vz, x - points[a, 0], y - points[a, 1], z - points[a, 2])
    return points[a, 0] + s * ux + t * vx, points[a, 1] + s * uy + t * vy, points[a, 2] + s * uz + t * vz


@compiled
def nearest_by_walk(
    surface: WalkableSurface, x: float, y: float, z: float, start: int, enough: float
) -> tuple[float, float, float, int, float]:
    """`WalkableSurface.closest` for kernels: the nearest point, its face and the squared distance; `enough` is squared too."""
    points, faces, offsets, around = surface
    face = start
    nx, ny, nz = _closest_on_triangle(points, faces[face, 0], faces[face, 1], faces[face, 2], x, y, z)
    best = (nx - x) ** 2 + (ny - y) ** 2 + (nz - z) ** 2
    for _ in range(_LONGEST_WALK):
        if best <= enough:
            break
        here = face
        for k in range(3):
            vertex = faces[here, k]
            for m in range(offsets[vertex], offsets[vertex + 1]):
                g = around[m]
                cx, cy, cz = _closest_on_triangle(points, faces[g, 0], faces[g, 1], faces[g, 2], x, y, z)
                square = (cx - x) ** 2 + (cy - y) ** 2 + (cz - z) ** 2
                if square < best:
                    best, face, nx, ny, nz = square, g, cx, cy, cz
        if face == here:
            break
    return nx, ny, nz, face, best


@compiled(parallel=True)
def _walk(surface: WalkableSurface, queries: Floats, enough: float, nearest: Floats, at: Ints, distances: Floats) -> None:
    for q in prange(queries.shape[0]):
        nearest[q, 0], nearest[q, 1], nearest[q, 2], at[q], square = nearest_by_walk(
            surface, queries[q, 0], queries[q, 1], queries[q, 2], at[q], enough
        )
        distances[q] = np.sqrt(square)

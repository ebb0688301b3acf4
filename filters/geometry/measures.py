"""Lengths and angles of edges, loops and corners; for kernels the area, angles and quality of single triangles."""

import math

import numpy as np

from ..compilation import compiled
from ..execution import over_range
from ..mesh import Floats, Ints
from ..topology import edges

#: Squares of lengths between these are ordinary numbers.
_SQUARED = 1e-140, 1e140


@compiled
def cross_product(points: Floats, a: int, b: int, c: int) -> tuple[float, float, float]:
    """(b - a) x (c - a): normal to the triangle (a, b, c), counter-clockwise seen from its tip, and twice its area long."""
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
    """The angle at a between b and c, from 0 to pi; 0 if two of them coincide."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    nx, ny, nz = cross_product(points, a, b, c)
    angle: float = np.arctan2(np.sqrt(nx * nx + ny * ny + nz * nz), ux * vx + uy * vy + uz * vz)
    return angle


@compiled
def quality_and_normal(points: Floats, a: int, b: int, c: int) -> tuple[float, float, float, float]:
    """The quality l / (sqrt(3) R) and the unit normal of the triangle (a, b, c); zeros if it has no area.

    Here l is the shortest edge and R the circumradius: 1 for equilateral triangles, towards 0 for slivers.
    """
    nx, ny, nz = cross_product(points, a, b, c)
    doubled = np.sqrt(nx * nx + ny * ny + nz * nz)
    if not doubled > 0.0:
        return 0.0, 0.0, 0.0, 0.0
    first, second = np.sqrt(squared_length(points, a, b)), np.sqrt(squared_length(points, a, c))
    third = np.sqrt(squared_length(points, b, c))
    # R is the product of the edges over four areas.
    quality = 2.0 * doubled * min(first, second, third) / (np.sqrt(3.0) * first * second * third)
    return quality, nx / doubled, ny / doubled, nz / doubled


def angles_between(first: Floats, second: Floats) -> Floats:
    """(k,) the angles between two sets of (k, 3) vectors of any length, in radians from 0 to pi; 0 if one vector is 0.

    From the arc tangent, which keeps the digits of small angles that the arc cosine loses.
    """
    sines = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.arctan2(sines, np.einsum("ij,ij->i", first, second)))


def corner_angles(vertices: Floats, faces: Ints) -> Floats:
    """(m, 3) the angle of every face at each of its vertices, in radians; 0 where two of them coincide."""
    angles = np.empty(faces.shape)
    _fill_corner_angles(np.ascontiguousarray(vertices, dtype=np.float64), faces, angles)
    return angles


@compiled(nogil=True)
def _fill_corner_angles(points: Floats, faces: Ints, angles: Floats) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f]
        angles[f] = angle_at(points, a, b, c), angle_at(points, b, c, a), angle_at(points, c, a, b)


def area_vector(loop: Floats) -> Floats:
    """(3,) half the sum of p_i x p_(i + 1): for a plane loop its area times the normal from which it is counter-clockwise."""
    centred = loop - loop.mean(axis=0)
    return np.asarray(np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0) / 2.0)


def side_lengths(loop: Floats) -> Floats:
    """(k,) the length of the side from each point to the next."""
    return np.asarray(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1))


def mean_edge_length(vertices: Floats, faces_or_edges: Ints) -> float:
    """The mean length of the edges, each counted once, in mesh units; 0 if there are none."""
    pairs = edges(faces_or_edges) if faces_or_edges.shape[1] == 3 else faces_or_edges
    if len(pairs) == 0:
        return 0.0
    return float(edge_lengths(vertices, pairs).mean())


def edge_lengths(vertices: Floats, pairs: Ints) -> Floats:
    """(e,) the length of each of the (e, 2) edges, of any size."""
    lengths = np.empty(len(pairs))
    points, ends = np.ascontiguousarray(vertices, dtype=np.float64), np.ascontiguousarray(pairs, dtype=np.int32)
    over_range(_measure, len(pairs), points, ends, lengths)
    if len(pairs) and not _SQUARED[0] < lengths.max() < _SQUARED[1]:
        return vector_lengths(vertices[pairs[:, 1]] - vertices[pairs[:, 0]])
    return lengths


@compiled(nogil=True)
def _measure(vertices: Floats, pairs: Ints, lengths: Floats, first: int, last: int) -> None:
    for e in range(first, last):
        a, b = pairs[e, 0], pairs[e, 1]
        x, y, z = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
        lengths[e] = math.sqrt(x * x + y * y + z * z)


def vector_lengths(vectors: Floats) -> Floats:
    """(n,) the length of each of (n, 3) vectors, of any size: no square leaves the range of numbers."""
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
    """The s and t of the point s u + t v of the triangle (0, u, v) nearest to p.

    Inside if all barycentric coordinates are positive, else on an edge: there s = 0, t = 0 or s + t = 1 to the bit.
    """
    d1, d2 = ux * px + uy * py + uz * pz, vx * px + vy * py + vz * pz
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    determinant = uu * vv - uv * uv
    s, t = vv * d1 - uv * d2, uu * d2 - uv * d1
    if determinant > 0.0 and s >= 0.0 and t >= 0.0 and s + t <= determinant:
        return s / determinant, t / determinant
    # The nearest of the nearest points of the three edges.
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

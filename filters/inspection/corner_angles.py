"""The angles at the corners of the faces, and how far those around a vertex are from those of a plane."""

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from ..mesh import Bools, Floats, Ints, check_mesh, normalised_mesh
from ..topology import border_vertices


def angle_deficits(vertices: ArrayLike, faces: ArrayLike) -> Floats:
    """(n,) the angle deficit of every vertex, in radians [meyer2003].

    2 pi - sum theta over the corners at an inner vertex: the integral of the Gaussian curvature over its surroundings. pi - sum
    theta at a vertex of the border: how far the border turns there. So the deficits of every mesh without non-manifold vertices
    add up to 2 pi chi, chi the Euler characteristic (Gauss-Bonnet), whether it is closed or not. 0 at vertices without a face.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles; one that names a vertex twice is none.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    deficits = np.zeros(len(points))
    if len(mesh.cells):
        deficits[mesh.used] = deficits_of(mesh.points, mesh.cells, border_vertices(mesh.cells, len(mesh)))
    return deficits


def deficits_of(points: Floats, faces: Ints, on_border: Bools) -> Floats:
    """(k,) the angle deficits of `angle_deficits`, of (k, 3) points of ordinary size that all have a face."""
    deficits = np.where(on_border, math.pi, 2.0 * math.pi)
    _subtract_angles(points, faces, deficits)
    return deficits


def mesh_normals(vertices: ArrayLike, faces: ArrayLike) -> Floats:
    """(n, 3) the `vertex_normals` of a mesh of any size and place.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles; one that names a vertex twice is none.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    normals = np.zeros((len(points), 3))
    if len(mesh.cells):
        normals[mesh.used] = vertex_normals(mesh.points, mesh.cells)
    return normals


def vertex_normals(points: Floats, faces: Ints) -> Floats:
    """(n, 3) the unit normals of the vertices: those of the faces, weighted with their angles there; 0 where that is nothing.

    The weights make the normal independent of how the surroundings are cut into triangles.

    Args:
        points: (n, 3) coordinates of ordinary size.
        faces: (m, 3) triangles.
    """
    normals = np.zeros((len(points), 3))
    _add_normals(points, faces, normals)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0))


@njit(cache=True)
def corner_angles(points: Floats, a: int, b: int, c: int) -> tuple[float, float, float]:
    """The angles at the corners of a triangle, which add up to pi.

    Coincident corners have the angles of the thin triangle that becomes them: two right angles, or three of 60 degrees.
    """
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    wx, wy, wz = points[c, 0] - points[b, 0], points[c, 1] - points[b, 1], points[c, 2] - points[b, 2]
    uu, vv, ww = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, wx * wx + wy * wy + wz * wz
    if uu == 0.0 or vv == 0.0 or ww == 0.0:
        if uu == 0.0 and vv == 0.0:
            return math.pi / 3, math.pi / 3, math.pi / 3
        if uu == 0.0:
            return math.pi / 2, math.pi / 2, 0.0
        if vv == 0.0:
            return math.pi / 2, 0.0, math.pi / 2
        return 0.0, math.pi / 2, math.pi / 2
    cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    doubled = math.sqrt(cx * cx + cy * cy + cz * cz)
    at_a = math.atan2(doubled, ux * vx + uy * vy + uz * vz)
    at_b = math.atan2(doubled, -(ux * wx + uy * wy + uz * wz))
    at_c = math.atan2(doubled, vx * wx + vy * wy + vz * wz)
    return at_a, at_b, at_c


@njit(cache=True)
def _subtract_angles(points: Floats, faces: Ints, deficits: Floats) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a != b and b != c and c != a:
            at_a, at_b, at_c = corner_angles(points, a, b, c)
            deficits[a] -= at_a
            deficits[b] -= at_b
            deficits[c] -= at_c


@njit(cache=True)
def _add_normals(points: Floats, faces: Ints, normals: Floats) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = math.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            angles = corner_angles(points, a, b, c)
            for k in range(3):
                share, i = angles[k] / length, faces[f, k]
                normals[i, 0] += share * x
                normals[i, 1] += share * y
                normals[i, 2] += share * z

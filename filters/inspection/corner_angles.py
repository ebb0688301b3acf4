"""What the angles at the corners of the faces tell: how curved a vertex is, and where its normal looks."""

import math

import numpy as np
from numpy.typing import ArrayLike

from ..compilation import compiled
from ..geometry import angle_at, corner_angles, cross_product
from ..mesh import Bools, Floats, Ints, check_mesh, normalised_mesh
from ..topology import border_vertices, proper_faces


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
    mesh = normalised_mesh(points, triangles[proper_faces(triangles)])
    deficits = np.zeros(len(points))
    if len(mesh.cells):
        deficits[mesh.used] = deficits_of(mesh.points, mesh.cells, border_vertices(mesh.cells, len(mesh)))
    return deficits


def deficits_of(points: Floats, faces: Ints, on_border: Bools) -> Floats:
    """(k,) the angle deficits of `angle_deficits`, of (k, 3) points of ordinary size that all have a face.

    Args:
        points: (k, 3) coordinates.
        faces: (m, 3) triangles, none of which names a vertex twice.
        on_border: (k,) which points lie on the border.
    """
    angles = _angles(points, faces)
    full = np.where(on_border, math.pi, 2.0 * math.pi)
    return np.asarray(full - np.bincount(faces.ravel(), angles.ravel(), minlength=len(points)))


def mesh_normals(vertices: ArrayLike, faces: ArrayLike) -> Floats:
    """(n, 3) the `vertex_normals` of a mesh of any size and place; 0 at vertices without a face.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles; one that names a vertex twice is none.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles[proper_faces(triangles)])
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
    sums = np.zeros((len(points), 3))
    _add_normals(points, faces, sums)
    return _unit(sums)


@compiled(nogil=True)
def _add_normals(points: Floats, faces: Ints, sums: Floats) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f]
        x, y, z = cross_product(points, a, b, c)
        length = math.sqrt(x * x + y * y + z * z)
        if not length > 0.0:
            continue
        at_a, at_b, at_c = angle_at(points, a, b, c), angle_at(points, b, c, a), angle_at(points, c, a, b)
        rest = (math.pi - at_a - at_b - at_c) / 3.0
        for corner, angle in ((a, at_a + rest), (b, at_b + rest), (c, at_c + rest)):
            sums[corner, 0] += angle * x / length
            sums[corner, 1] += angle * y / length
            sums[corner, 2] += angle * z / length


def _angles(points: Floats, faces: Ints) -> Floats:
    """(m, 3) the angles of the faces, which add up to pi in each of them.

    Where corners coincide the angle that is missing is spread over the three, and elsewhere the rounding.
    """
    angles = corner_angles(points, faces)
    return np.asarray(angles + (math.pi - angles.sum(axis=1, keepdims=True)) / 3.0)


def _unit(vectors: Floats) -> Floats:
    """(n, 3) the vectors at length 1; those of length 0 as they are."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0.0))

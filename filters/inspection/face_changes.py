"""Faces that a filter has changed: folded ones, their shapes, sharp edges, and the sides of the bounding box without noise."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import cross_products, looking_away
from ..libraries import spatial
from ..mesh import Bools, Floats, Ints, check_mesh, normalised_mesh
from ..operators import uniform_laplacian
from ..topology import face_adjacency
from .surface_measures import dihedral_angles, face_measures

#: The least angle between the normals of two faces at a sharp edge, in degrees.
SHARP = 40.0
# Steps p <- p + 2/3 L p with the uniform operator average over some two edges to all sides: noise of single vertices becomes an
# eighth, the loss of an end that is six edges across stays.
_STEPS, _STEP = 12, 2.0 / 3.0


class SharpEdges(NamedTuple):
    """The edges at which two faces meet sharply."""

    pairs: Ints  # (k, 2) their vertices
    faces: Ints  # (k, 2) their faces
    middles: Floats  # (k, 3) their middles
    lengths: Floats  # (k,) their lengths


def sharp_edges(vertices: ArrayLike, faces: ArrayLike) -> SharpEdges:
    """The edges with exactly two faces whose normals differ by at least `SHARP` degrees.

    Noise of half an edge makes every edge sharp: on a noisy scan this measures the noise.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    neighbours, shared = face_adjacency(triangles)
    normals = face_measures((points - mesh.middle) * mesh.scale, triangles)[0]
    sharp = np.degrees(dihedral_angles(normals, triangles, neighbours)) >= SHARP  # false for faces without area
    pairs = shared[sharp]
    ends = points[pairs]
    lengths = np.linalg.norm((ends[:, 1] - ends[:, 0]) * mesh.scale, axis=1) / mesh.scale
    return SharpEdges(pairs, neighbours[sharp], ends[:, 0] * 0.5 + ends[:, 1] * 0.5, lengths)


def share_kept(before: SharpEdges, after: SharpEdges, *, within: float) -> float | None:
    """The share of the length of the sharp edges of `before` near which `after` has one; None if there were none.

    The middles of edges may be `within` so many mesh units; larger finds more of them kept.
    """
    total = math.fsum(before.lengths)
    if total == 0.0:
        return None
    if not len(after.pairs):
        return 0.0
    origin = before.middles[0]
    distances, _ = spatial.cKDTree(after.middles - origin).query(before.middles - origin)
    return math.fsum(before.lengths[distances <= within]) / total


def side_changes(before: ArrayLike, after: ArrayLike, faces: ArrayLike) -> Floats:
    """The change of each side as a share of it: sides(q) / sides(q - S(q - p)) - 1.

    p and q are the vertices before and after, S averages vectors over neighbourhoods. What neighbours have moved together is a
    change of shape and stays in S; noise that was taken off, or came, is averaged away. q - S(q - p) is then what the surface
    was before, with the noise that it has after, so that both boxes are as much larger by noise at their ends.

    Returns:
        (3,) the changes along x, y and z; nan where there was no side. -0.02 is 2 % shorter. With independent noise of 0.5 mean
        edges taken off they are right within 0.01 on shapes 27 edges thick, where the boxes themselves differ by 0.1. Vertices
        without a face do not count.

    Raises:
        FilterInputError: not a mesh.
    """
    first, triangles = check_mesh(before, faces)
    second, _ = check_mesh(after, faces)
    moved = second - first
    laplacian = uniform_laplacian(triangles, len(first))
    for _ in range(_STEPS):
        moved = moved + _STEP * laplacian.apply(moved)
    used = np.unique(triangles)
    new, old = (np.ptp(p[used], axis=0) if len(used) else np.zeros(3) for p in (second, second - moved))
    return np.asarray(np.divide(new, old, out=np.full(3, np.nan), where=old > 0.0) - 1.0)


def triangle_shapes(vertices: ArrayLike, faces: ArrayLike) -> Floats:
    """(m,) l / (sqrt(3) R) of every face, l its shortest edge and R its circumradius: 1 if equilateral, towards 0 for slivers.

    A right-angled isosceles triangle has 0.816. 0 where a face has no area.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    return face_measures((points - mesh.middle) * mesh.scale, triangles)[2]


def folded_faces(vertices: ArrayLike, faces: ArrayLike) -> Bools:
    """(m,) which faces look away from the mean of the normals of the faces at their vertices, weighted by area.

    Where faces do not agree on the outside, those of the smaller side count.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    # Scaled by a power of two, not moved: what other vertices do changes no bit here.
    local = np.zeros_like(points)
    local[mesh.used] = mesh.scale * points[mesh.used]
    return looking_away(cross_products(local, triangles), triangles, len(points))

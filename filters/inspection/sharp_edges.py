"""The sharp edges of a surface, and how many of them another surface still has."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..libraries import spatial
from ..mesh import Floats, Ints, check_mesh, normalised_mesh
from ..topology import face_adjacency
from .face_measures import dihedral_angles, face_measures, faces_agree

#: The least angle between the normals of two faces at a sharp edge, in degrees.
SHARP = 40.0


class SharpEdges(NamedTuple):
    """The edges at which two faces meet sharply.

    Attributes:
        pairs: (k, 2) their vertices.
        faces: (k, 2) their faces.
        middles: (k, 3) their middles.
        lengths: (k,) their lengths.
    """

    pairs: Ints
    faces: Ints
    middles: Floats
    lengths: Floats


def sharp_edges(vertices: ArrayLike, faces: ArrayLike) -> SharpEdges:
    """The edges with exactly two faces whose normals differ by at least `SHARP` degrees.

    Noise of half an edge makes every edge sharp: on a noisy scan this measures the noise.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    local = (points - mesh.middle) * mesh.scale
    neighbours, shared = face_adjacency(triangles)
    normals = face_measures(local, triangles)[0]
    angles = np.degrees(dihedral_angles(normals, neighbours, faces_agree(triangles, neighbours, shared)))
    sharp = angles >= SHARP  # false for faces without area
    pairs = shared[sharp]
    ends = points[pairs]
    lengths = np.linalg.norm((ends[:, 1] - ends[:, 0]) * mesh.scale, axis=1) / mesh.scale
    return SharpEdges(pairs, neighbours[sharp], ends[:, 0] * 0.5 + ends[:, 1] * 0.5, lengths)


def share_kept(before: SharpEdges, after: SharpEdges, *, within: float) -> float | None:
    """The share of the length of the sharp edges of `before` near which `after` has one; None if there were none.

    Args:
        before: the sharp edges of one surface.
        after: those of the other.
        within: how far the middle of an edge may be from the nearest one, in mesh units; larger finds more of them kept.
    """
    total = math.fsum(before.lengths)
    if total == 0.0:
        return None
    if not len(after.pairs):
        return 0.0
    origin = before.middles[0]
    distances, _ = spatial.cKDTree(after.middles - origin).query(before.middles - origin)
    return math.fsum(before.lengths[distances <= within]) / total

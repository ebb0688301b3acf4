"""What a filter has changed: folded faces, triangle shapes, sharp edges, and the sides of the bounding box without noise."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import cross_products, looking_away
from ..libraries import spatial
from ..mesh import Bools, Floats, Ints, check_mesh, normalised_mesh, scaled_to_unit
from ..operators import uniform_laplacian
from ..topology import face_adjacency
from .surface_measures import dihedral_angles, face_measures

SHARP = 40.0  # The smallest angle between the normals of the two faces of a sharp edge, in degrees.
# `side_changes` smooths displacements by 12 steps d <- d + 2/3 L d with the uniform operator L, over about two edges in all
# directions. Independent noise falls to an eighth; if an end of a shape six edges wide moves, most of the displacement remains.
_STEPS, _STEP = 12, 2.0 / 3.0


class SharpEdges(NamedTuple):
    """The result of `sharp_edges`."""

    pairs: Ints  # (k, 2) the vertices
    faces: Ints  # (k, 2) the two faces
    middles: Floats  # (k, 3) the midpoints
    lengths: Floats  # (k,)


def sharp_edges(vertices: ArrayLike, faces: ArrayLike) -> SharpEdges:
    """Returns the edges with exactly two faces whose normals differ by at least `SHARP` degrees.

    Noise of half an edge length makes about half of all edges sharp, so on a noisy scan the result only measures the noise.
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
    """The share of the sharp edges of `before`, by length, that `after` still has nearby; None if `before` has none.

    An edge is kept if a sharp edge of `after` has its midpoint at most `within` mesh units away; a larger `within` keeps more.
    """
    total = math.fsum(before.lengths)
    if total == 0.0:
        return None
    if not len(after.pairs):
        return 0.0
    origin = before.middles[0]
    distances, _ = spatial.cKDTree(after.middles - origin).query(before.middles - origin)
    return math.fsum(before.lengths[distances <= within]) / total


def carried(points: Floats, source: Floats, target: Floats) -> Floats:
    """Moves (n, 3) points by the similarity, maybe with a reflection, that takes (k, 3) `source` nearest to `target`; k >= 1."""
    (p, scale_p), (q, scale_q) = scaled_to_unit(source), scaled_to_unit(target)
    p, q = p - p[0], q - q[0]
    a, b = p.mean(axis=0), q.mean(axis=0)
    u, stretch, v = np.linalg.svd(np.einsum("ki,kj->ij", q - b, p - a))
    growth = float(stretch.sum()) / (float(((p - a) ** 2).sum()) or 1.0)
    return np.asarray(((((points - source[0]) * scale_p - a) @ (u @ v).T) * growth + b) / scale_q + target[0])


def side_changes(before: ArrayLike, after: ArrayLike, faces: ArrayLike) -> Floats:
    """The relative change of each side of the bounding box, without noise: sides(q) / sides(q - S(q - p)) - 1.

    p and q are the vertices before and after; S averages displacements over neighbourhoods. S keeps the common displacement of
    neighbours, which changes the shape, and averages out the noise that was removed or added. So q - S(q - p) has the shape of p
    and the noise of q, which enlarges both boxes equally.

    Returns:
        (3,) the changes along x, y and z; nan where the side was 0. -0.02 means 2 % shorter. If a filter removes independent
        noise of 0.5 mean edges, the error is below 0.01 on shapes 27 edges thick, where the boxes themselves differ by 0.1.
        Vertices without a face do not count.
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
    """(m,) l / (sqrt(3) R) of every face, l its shortest edge and R its circumradius: 1 if equilateral, near 0 for slivers.

    A face without area has 0.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    return face_measures((points - mesh.middle) * mesh.scale, triangles)[2]


def folded_faces(vertices: ArrayLike, faces: ArrayLike) -> Bools:
    """(m,) which faces look away from the area-weighted mean normal of the faces at their vertices.

    A face whose orientation is opposite to that of most faces around it counts as folded, too.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    # Scaling by a power of two, without moving, is exact: distant parts of the mesh do not change the result at a face.
    local = np.zeros_like(points)
    local[mesh.used] = mesh.scale * points[mesh.used]
    return looking_away(cross_products(local, triangles), triangles, len(points))

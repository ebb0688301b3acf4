"""How sharply a surface bends at the rim of a hole, and around it."""

import numpy as np

from ..geometry import angles_between, cross_products
from ..mesh import Floats, Ints
from ..topology import face_adjacency


def bends_around(points: Floats, faces: Ints, at: Ints) -> tuple[Floats, Floats]:
    """The angles between the normals of the two faces of every edge, summed at its ends.

    Args:
        points: (n, 3) the vertices of the mesh.
        faces: (m, 3) its triangles.
        at: (k,) the vertices where the sums are wanted; others may get less than their sum.

    Returns:
        (n,) the sums in radians, and (n,) how many angles each sums up.
    """
    n = len(points)
    asked = np.zeros(n, dtype=np.bool_)
    asked[at] = True
    near = faces[asked[faces].any(axis=1)]
    pairs, shared = face_adjacency(near)
    pairs, shared = pairs[asked[shared].any(axis=1)], shared[asked[shared].any(axis=1)]
    normals = cross_products(points, near)
    angles = angles_between(normals[pairs[:, 0]], normals[pairs[:, 1]])
    total, number = np.zeros(n), np.zeros(n)
    for k in range(2):
        np.add.at(total, shared[:, k], angles)
        np.add.at(number, shared[:, k], 1.0)
    return total, number


def bend_at_rim(points: Floats, triangles: Ints, sides: Ints) -> float:
    """The mean angle between the normals of the patch and of the mesh along the rim, in radians.

    Args:
        points: (n, 3) the vertices of the patch and of the faces around it.
        triangles: (b, 3) the patch.
        sides: (k, 3) for every edge of the rim its start, its end in the direction of the patch, and the third vertex of the
            face of the mesh.
    """
    n = len(points)
    keys = np.concatenate([triangles[:, k].astype(np.int64) * n + triangles[:, (k + 1) % 3] for k in range(3)])
    order = np.argsort(keys, kind="stable")
    inside = triangles[order[np.searchsorted(keys[order], sides[:, 0].astype(np.int64) * n + sides[:, 1])] % len(triangles)]
    return float(angles_between(cross_products(points, inside), -cross_products(points, sides)).mean())

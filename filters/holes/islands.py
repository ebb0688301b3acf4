"""Outer borders told apart from holes, and islands: sheets that lie in a hole without touching its rim."""

import numpy as np

from ..mesh import Bools, Floats, Ints
from .rims import Rim

#: A rim round which the surface turns by more than this is an outer border; it is 2 pi for a flat disc, -2 pi for a
#: hole in a plane, 0 for the end of a tube, 2 pi cos t for a cap of the sphere out to the angle t from its pole.
OUTER_TURN = 1.5 * np.pi

# An island may lie this far above or below the middle plane of its hole, as a share of the root of the hole's area.
_HEIGHT = 0.5


def outer_borders(rims: list[Rim], vertices: Floats, faces: Ints) -> list[bool]:
    """Whether each rim goes round the outside of a sheet: whether its geodesic curvature sums to more than `OUTER_TURN`.

    The sum is that of pi less the angle of the surface, over the vertices of the rim. By the theorem of Gauss and Bonnet it is,
    for a disc, 2 pi less the curvature inside, however ragged the border.
    """
    n = len(vertices)
    visits = np.zeros(n)
    for rim in rims:
        np.add.at(visits, rim.vertices, 1.0)
    a, b, c = faces.T
    near = faces[(visits[faces] > 0.0).any(axis=1) & (a != b) & (b != c) & (c != a)]
    angles = np.zeros(n)
    for k in range(3):
        at = near[:, k]
        u, v = vertices[near[:, (k + 1) % 3]] - vertices[at], vertices[near[:, (k + 2) % 3]] - vertices[at]
        np.add.at(angles, at, np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v)))
    return [float((np.pi - angles[rim.vertices] / visits[rim.vertices]).sum()) > OUTER_TURN for rim in rims]


def holes_around(islands: list[Rim], holes: list[Rim], vertices: Floats, components: Ints) -> list[int]:
    """For every island's rim the index of the smallest hole that it lies in, -1 if there is none.

    It lies in a hole of another component if, seen along the normal of the hole's rim, all its vertices are inside the rim and
    not far above or below, and its sheet looks the same way as what is around.
    """
    if not holes:
        return [-1] * len(islands)
    middles = np.array([vertices[hole.vertices].mean(axis=0) for hole in holes])
    reaches = np.array(
        [np.linalg.norm(vertices[hole.vertices] - m, axis=1).max() for hole, m in zip(holes, middles, strict=True)]
    )
    found = []
    for island in islands:
        points = vertices[island.vertices]
        close = np.flatnonzero(np.linalg.norm(middles - points.mean(axis=0), axis=1) < reaches)
        best, smallest = -1, np.inf
        for h in close.tolist():
            if components[holes[h].vertices[0]] == components[island.vertices[0]]:
                continue
            size = _size_if_inside(points, vertices[holes[h].vertices])
            if size < smallest:
                best, smallest = h, size
        found.append(best)
    return found


def _size_if_inside(island: Floats, hole: Floats) -> float:
    """The area of the hole's projection, infinite if the island is not in it."""
    middle = hole.mean(axis=0)
    normal = _area_vector(hole)
    size = float(np.linalg.norm(normal))
    # The island's rim runs the other way round: its own faces are on the left of it as the new ones are to be.
    if not size > 0.0 or float(normal @ _area_vector(island)) >= 0.0:
        return np.inf
    normal = normal / size
    if np.abs((island - middle) @ normal).max() > _HEIGHT * np.sqrt(size):
        return np.inf
    x = np.eye(3)[np.abs(normal).argmin()]
    x = np.cross(normal, x) / np.linalg.norm(np.cross(normal, x))
    plane = np.column_stack([x, np.cross(normal, x)])
    return size if _inside((island - middle) @ plane, (hole - middle) @ plane).all() else np.inf


def _area_vector(loop: Floats) -> Floats:
    centred = loop - loop.mean(axis=0)
    return np.asarray(np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0) / 2.0)


def _inside(points: Floats, loop: Floats) -> Bools:
    """Whether a ray from each point crosses the loop an odd number of times."""
    a, b = loop, np.roll(loop, -1, axis=0)
    over = (a[:, 1] > points[:, None, 1]) != (b[:, 1] > points[:, None, 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = a[:, 0] + (points[:, None, 1] - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    inside: Bools = ((over & (x > points[:, None, 0])).sum(axis=1) % 2).astype(np.bool_)
    return inside

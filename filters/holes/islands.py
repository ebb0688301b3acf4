"""Outer borders told apart from holes, and islands: sheets that lie in a hole without touching its rim."""

from typing import Literal, TypeAlias

import numpy as np

from ..mesh import Bools, Floats, Ints
from ..topology import connected_components
from .rims import Rim

#: A rim round which the surface turns by more than this is an outer border; it is 2 pi for a flat disc, -2 pi for a
#: hole in a plane, 0 for the end of a tube, 2 pi cos t for a cap of the sphere out to the angle t from its pole.
OUTER_TURN = 1.5 * np.pi
#: And so is probably one that spans more than this share of the area of its component: for the cap above it is (1 + cos t) / 2,
#: so the borders of caps of up to 109 degrees are outer ones. A sheet that was seen from one side spans the mean cosine of the
#: angle between its normals and the view.
OUTER_SHARE = 1 / 3
#: But not if the surface turns by less than this: then it is the inner border of a narrow frame. A sheet that one would have to
#: fold around more than three quarters of a ball turns like that, too.
FRAME_TURN = -np.pi

#: Whether a rim goes round the outside of a sheet.
Outer: TypeAlias = Literal["no", "probably", "surely"]

# An island may lie this far above or below the middle plane of its hole, as a share of the root of the hole's area.
_HEIGHT = 0.5

# So many pairs of a point and a side are tested at once.
_AT_ONCE = 2_000_000


def outer_borders(rims: list[Rim], vertices: Floats, faces: Ints) -> list[Outer]:
    """Whether each rim goes round the outside of a sheet.

    Surely, where its geodesic curvature sums to more than `OUTER_TURN`. The sum is that of pi less the angle of the surface, over
    the vertices of the rim. By the theorem of Gauss and Bonnet it is, for a disc, 2 pi less the curvature inside, however ragged
    the border. So it says little of the border of a curved sheet, as of a range map of a ball; such a rim is probably an outer
    border if it spans more than `OUTER_SHARE` of the area of its component and its curvature is above `FRAME_TURN`. It spans the
    area of its projection along the normal for which that is largest.
    """
    if not rims:
        return []
    turns = _turns(rims, vertices, faces)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    components, count = connected_components(faces, len(vertices))
    areas = np.bincount(components[faces[:, 0]], np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0, minlength=count)
    found: list[Outer] = []
    for rim, turn in zip(rims, turns, strict=True):
        spans = float(np.linalg.norm(_area_vector(vertices[rim.vertices])))
        if turn > OUTER_TURN:
            found.append("surely")
        elif turn > FRAME_TURN and spans > OUTER_SHARE * areas[components[rim.vertices[0]]]:
            found.append("probably")
        else:
            found.append("no")
    return found


def _turns(rims: list[Rim], vertices: Floats, faces: Ints) -> list[float]:
    """The sums of the geodesic curvatures of the rims."""
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
    return [float((np.pi - angles[rim.vertices] / visits[rim.vertices]).sum()) for rim in rims]


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
    if len(points) > _AT_ONCE // len(loop) + 1:
        # In parts, since the arrays below have an entry for every point and side.
        step = _AT_ONCE // len(loop) + 1
        return np.concatenate([_inside(points[i : i + step], loop) for i in range(0, len(points), step)])
    over = (a[:, 1] > points[:, None, 1]) != (b[:, 1] > points[:, None, 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = a[:, 0] + (points[:, None, 1] - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    inside: Bools = ((over & (x > points[:, None, 0])).sum(axis=1) % 2).astype(np.bool_)
    return inside

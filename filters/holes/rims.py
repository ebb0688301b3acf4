"""Rims of a mesh: holes, outer borders of open sheets, and islands within holes."""

from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import area_vector, corner_angles, cross_products, side_lengths
from ..mesh import Bools, Floats, Ints, check_mesh, normalised_mesh
from ..topology import BoundaryLoop, boundary_loops, connected_components, is_seam, proper_faces
from .filling import ISLAND_IN_IT, OpenRim, left_open_as

#: A rim whose total geodesic curvature is above this is an outer border. It is 2 pi for a flat disc, -2 pi for a hole in a plane,
#: 0 for the end of a tube, 2 pi cos t for a cap of the sphere up to the angle t from its pole.
OUTER_TURN = 1.5 * np.pi
#: A rim that spans more than this share of the area of its component is probably an outer border. The share is (1 + cos t) / 2
#: for the cap above, so the borders of caps of up to 109 degrees are outer ones. For a sheet scanned from one side it is the mean
#: cosine of the angle between its normals and the view.
OUTER_SHARE = 1 / 3
#: But a rim whose total geodesic curvature is below this is a hole: the inner border of a narrow frame. A sheet that covers more
#: than three quarters of a ball has such a border, too.
FRAME_TURN = -np.pi
#: And a rim with a squared length below this share of the area of its sheet is a hole, whatever its curvature.
#: The share is 4 pi for the border of a flat disc, the least of flat sheets, and 4.2 for the cap of a ball of 109 degrees.
SHORT_RIM = 1.0
#: Whether a rim goes round the outside of a sheet.
Outer: TypeAlias = Literal["no", "probably", "surely"]
# An island may lie this far above or below the middle plane of its hole, as a share of the root of the hole's area.
_HEIGHT = 0.5
# The number of pairs of a point and a side that are tested at once.
_AT_ONCE = 2_000_000
#: The largest number of edges of a hole and the islands in it together, or `max_edges` if that is larger: memory grows with its
#: square.
MOST_JOINED = 10_000


class Rim(NamedTuple):
    """One boundary loop.

    Attributes:
        edges: how many it has.
        length: of them all.
        middle: (3,) the mean of its vertices.
        outer: whether it seems to be the outer border of an open sheet and no hole.
    """

    edges: int
    length: float
    middle: Floats
    outer: bool


def find_rims(vertices: ArrayLike, faces: ArrayLike) -> list[Rim]:
    """The boundary loops of a mesh, the largest first; border edges on no loop are left out.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    loops = boundary_loops(mesh.points, mesh.cells).loops
    outer = outer_borders(loops, mesh.points, mesh.cells)
    measured = []
    for loop, kind in zip(loops, outer, strict=True):
        places = mesh.points[loop.vertices]
        length = float(side_lengths(places).sum()) / mesh.scale
        measured.append(Rim(len(places), length, places.mean(axis=0) / mesh.scale + mesh.middle, kind != "no"))
    return sorted(measured, key=lambda rim: -rim.edges)


def outer_borders(rims: list[BoundaryLoop], vertices: Floats, faces: Ints) -> list[Outer]:
    """Whether each rim is the outer border of a sheet.

    Surely, if its total geodesic curvature is above `OUTER_TURN`: the sum over its vertices of pi less the angle of the surface
    there. By the theorem of Gauss and Bonnet this is 2 pi less the Gaussian curvature inside for a disc, however ragged its
    border. So it is no criterion for the border of a curved sheet, such as a range map of a ball. Such a rim is probably an outer
    border if it spans more than `OUTER_SHARE` of the area of its component and its curvature is above `FRAME_TURN`. The area
    that a rim spans is that of its largest projection to a plane. A rim too short to go round its sheet is none, see `SHORT_RIM`.
    """
    if not rims:
        return []
    turns = _turns(rims, vertices, faces)
    components, count = connected_components(faces, len(vertices))
    proper = faces[proper_faces(faces)]  # others may name vertices that belong to no component
    areas = np.bincount(components[proper[:, 0]], np.linalg.norm(cross_products(vertices, proper), axis=1) / 2.0, minlength=count)
    verdicts: list[Outer] = []
    for rim, turn in zip(rims, turns, strict=True):
        spans = float(np.linalg.norm(area_vector(vertices[rim.vertices])))
        if side_lengths(vertices[rim.vertices]).sum() ** 2 < SHORT_RIM * areas[components[rim.vertices[0]]]:
            verdicts.append("no")
        elif turn > OUTER_TURN:
            verdicts.append("surely")
        elif turn > FRAME_TURN and spans > OUTER_SHARE * areas[components[rim.vertices[0]]]:
            verdicts.append("probably")
        else:
            verdicts.append("no")
    return verdicts


def _turns(rims: list[BoundaryLoop], vertices: Floats, faces: Ints) -> list[float]:
    """The total geodesic curvature of each rim."""
    n = len(vertices)
    visits = np.bincount(np.concatenate([rim.vertices for rim in rims]), minlength=n)
    near = faces[(visits[faces] > 0).any(axis=1) & proper_faces(faces)]
    angles = np.bincount(near.T.ravel(), corner_angles(vertices, near).T.ravel(), n)
    return [float((np.pi - angles[rim.vertices] / visits[rim.vertices]).sum()) for rim in rims]


def holes_around(islands: list[BoundaryLoop], holes: list[BoundaryLoop], vertices: Floats, components: Ints) -> list[int]:
    """For every island's rim the index of the smallest hole that it lies in, -1 if there is none.

    It lies in a hole of another component if, projected along the normal of the hole's rim, all its vertices are inside the rim
    and not far from its middle plane, and its sheet is oriented as the surface around the hole.
    """
    if not holes:
        return [-1] * len(islands)
    middles = np.array([vertices[hole.vertices].mean(axis=0) for hole in holes])
    reaches = np.array(
        [np.linalg.norm(vertices[hole.vertices] - m, axis=1).max() for hole, m in zip(holes, middles, strict=True)]
    )
    numbers = []
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
        numbers.append(best)
    return numbers


def _size_if_inside(island: Floats, hole: Floats) -> float:
    """The area of the hole's projection, infinite if the island is not in it."""
    middle = hole.mean(axis=0)
    normal = area_vector(hole)
    size = float(np.linalg.norm(normal))
    # An island oriented as the surface around has a rim that runs the other way round than that of the hole.
    if not size > 0.0 or float(normal @ area_vector(island)) >= 0.0:
        return np.inf
    normal = normal / size
    if np.abs((island - middle) @ normal).max() > _HEIGHT * np.sqrt(size):
        return np.inf
    x = np.eye(3)[np.abs(normal).argmin()]
    x = np.cross(normal, x) / np.linalg.norm(np.cross(normal, x))
    plane = np.column_stack([x, np.cross(normal, x)])
    return size if _inside((island - middle) @ plane, (hole - middle) @ plane).all() else np.inf


def _inside(points: Floats, loop: Floats) -> Bools:
    """Whether a ray from each point crosses the loop an odd number of times."""
    a, b = loop, np.roll(loop, -1, axis=0)
    if len(points) > _AT_ONCE // len(loop) + 1:
        # In parts: the arrays below have an entry for every point and side.
        step = _AT_ONCE // len(loop) + 1
        return np.concatenate([_inside(points[i : i + step], loop) for i in range(0, len(points), step)])
    over = (a[:, 1] > points[:, None, 1]) != (b[:, 1] > points[:, None, 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = a[:, 0] + (points[:, None, 1] - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    inside: Bools = ((over & (x > points[:, None, 0])).sum(axis=1) % 2).astype(np.bool_)
    return inside


def sorted_rims(
    rims: list[BoundaryLoop],
    points: Floats,
    triangles: Ints,
    max_edges: int,
    selected: Bools | None,
    islands: Literal["join", "leave"],
) -> tuple[list[BoundaryLoop], list[list[BoundaryLoop]], list[OpenRim]]:
    """The holes to close, for each the rims of the islands in it, and the other rims with the reason.

    Separates holes from outer borders and islands first, then drops the holes that are too large, seams or not selected.
    """
    outer = outer_borders(rims, points, triangles)
    holes = [rim for rim, outside in zip(rims, outer, strict=True) if outside == "no"]
    borders = [(rim, outside) for rim, outside in zip(rims, outer, strict=True) if outside != "no"]
    around = [-1] * len(borders)
    if islands == "join" and borders and holes:
        components, _ = connected_components(triangles, len(points))
        around = holes_around([rim for rim, _ in borders], holes, points, components)
    in_hole: dict[int, list[BoundaryLoop]] = {}
    left = []
    for (rim, outside), number in zip(borders, around, strict=True):
        if number >= 0:
            in_hole.setdefault(id(holes[number]), []).append(rim)
        elif outside == "probably" and selected is not None and selected[rim.vertices].any():
            holes.append(rim)
        elif is_seam(rim, points):
            left.append(left_open_as(rim, "seam"))
        else:
            left.append(left_open_as(rim, "outer" if outside == "surely" else "probably_outer"))
    holes.sort(key=lambda rim: tuple(rim.vertices[:2].tolist()))
    closed: list[BoundaryLoop] = []
    inside: list[list[BoundaryLoop]] = []
    for hole in holes:
        group = in_hole.get(id(hole), [])
        refused = _refused(hole, group, points, max_edges, selected)
        if refused is None:
            closed.append(hole)
            inside.append(group)
        else:
            left.append(refused)
            left += [left_open_as(rim, "seam" if is_seam(rim, points) else "outer") for rim in group]
    return closed, inside, left


def _refused(
    hole: BoundaryLoop, islands: list[BoundaryLoop], points: Floats, max_edges: int, selected: Bools | None
) -> OpenRim | None:
    """The hole with the reason why it must not be closed; None if it may be."""
    if len(hole.vertices) > max_edges:
        return left_open_as(hole, "size", f": it has more than {max_edges}; to close it, raise max_edges to {len(hole.vertices)}")
    if is_seam(hole, points):
        return left_open_as(hole, "seam")
    if selected is not None and not selected[hole.vertices].any():
        return left_open_as(hole, "selection")
    if any(is_seam(rim, points) for rim in islands):
        return left_open_as(hole, "island", ISLAND_IN_IT)
    return None

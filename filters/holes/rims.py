"""Sorts rims (boundary loops) into holes, outer borders of sheets, and borders of islands in holes; says why rims stay open."""

from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import area_vector, corner_angles, cross_products, side_lengths
from ..mesh import Bools, Floats, Ints, check_mesh, normalised_mesh
from ..topology import BoundaryLoop, BrokenBorder, boundary_loops, connected_components, is_seam, proper_faces

#: A rim with a larger total geodesic curvature is an outer border. The curvature is 2 pi for a flat disc, -2 pi for a hole in a
#: plane, 0 for the end of a tube, 2 pi cos t for a spherical cap up to the angle t from its pole.
OUTER_TURN = 1.5 * np.pi
#: A rim whose largest projection has a larger share of the area of its component is probably an outer border. The share is
#: (1 + cos t) / 2 for the cap above, so caps of up to 109 degrees have outer borders.
OUTER_SHARE = 1 / 3
#: A rim with a smaller curvature is always a hole: the inner border of a narrow frame, or the rim of a cap above 120 degrees.
FRAME_TURN = -np.pi
#: A rim is also a hole if its squared length over the area of its component is below this. The ratio is 4 pi for a flat disc,
#: the least of all flat sheets, and 4.2 for the cap of 109 degrees.
SHORT_RIM = 1.0
#: Whether a rim is the outer border of a sheet.
Outer: TypeAlias = Literal["no", "probably", "surely"]
# The largest distance of an island from the middle plane of its hole, as a share of the square root of the hole's area.
_HEIGHT = 0.5
#: The largest number of edges of a hole together with its islands, unless `max_edges` is larger; the limit saves time.
MOST_JOINED = 10_000
#: Why a rim was left open, see `_WHY`. "size": more edges than `max_edges`. "island" also stands for a hole around an island.
Reason: TypeAlias = Literal[
    "size", "selection", "outer", "probably_outer", "island", "seam", "orientation", "non_manifold", "no_triangulation"
]
ISLAND_IN_IT = ": an island lies in it, and cannot be joined to it; to fill the hole, delete the island or set islands to 'leave'"
_WHY: dict[Reason, str] = {
    "selection": ": none of its vertices is selected",
    "outer": ": it is the outer border of an open sheet",
    "probably_outer": ": it seems to be the outer border, as it spans much of the area of its sheet; if it is a hole, "
    "select a vertex of it and close only the holes at the selection",
    "island": ": it is the border of an island that cannot be joined to the hole around it",
    "seam": ": its two sides coincide, so merge close vertices",
    "no_triangulation": ": each triangulation has edges with more than two faces, or triangles without area because vertices of "
    "the rim coincide or lie on a line",
    "non_manifold": "an edge with more than two faces ends there: delete or separate its faces",
    "orientation": "the faces there are not coherently oriented: orient them first",
}


class OpenRim(NamedTuple):
    """A rim that was left open."""

    vertices: Ints  # (k,) int32 in order along the rim; ascending for "orientation" and "non_manifold", which form no loop
    reason: Reason
    message: str  # the reason as a sentence, with the numbers


def left_open_as(rim: BoundaryLoop, reason: Reason, explanation: str = "") -> OpenRim:
    """Returns the rim with its reason and a message; `explanation` replaces the text of `_WHY`."""
    edges, why = len(rim.vertices), explanation or _WHY[reason]
    return OpenRim(rim.vertices, reason, f"the rim of {edges} edges through vertex {rim.vertices[0]} was left open{why}")


def broken_left_open(border: BrokenBorder) -> OpenRim:
    """Returns the `OpenRim` of a part of the border that forms no loop."""
    others = len(border.vertices) - 1
    message = f"the border through vertex {border.vertex} (and {others} others) was left open: {_WHY[border.reason]}"
    return OpenRim(border.vertices, border.reason, message)


class Rim(NamedTuple):
    """One boundary loop."""

    edges: int
    length: float  # sum of the edge lengths
    middle: Floats  # (3,) mean of the vertices
    outer: bool  # whether it is, surely or probably, the outer border of a sheet


def find_rims(vertices: ArrayLike, faces: ArrayLike) -> list[Rim]:
    """Returns the boundary loops of a mesh, most edges first; border edges that lie on no loop are left out."""
    mesh = normalised_mesh(*check_mesh(vertices, faces))
    loops = boundary_loops(mesh.points, mesh.cells).loops
    measured = []
    for loop, outer in zip(loops, outer_borders(loops, mesh.points, mesh.cells), strict=True):
        places = mesh.points[loop.vertices]
        length = float(side_lengths(places).sum()) / mesh.scale
        measured.append(Rim(len(places), length, places.mean(axis=0) / mesh.scale + mesh.middle, outer != "no"))
    return sorted(measured, key=lambda rim: -rim.edges)


def outer_borders(rims: list[BoundaryLoop], vertices: Floats, faces: Ints) -> list[Outer]:
    """Returns whether each rim is the outer border of a sheet.

    The total geodesic curvature is the sum, over the vertices of the rim, of pi minus the angle of the surface there: 2 pi for a
    flat disc by Gauss-Bonnet, however ragged its rim is. `SHORT_RIM`, `OUTER_TURN`, `FRAME_TURN` and `OUTER_SHARE` decide, in
    this order.
    """
    if not rims:
        return []
    n = len(vertices)
    proper = faces[proper_faces(faces)]  # vertices of other faces may belong to no component
    components, count = connected_components(proper, n)
    areas = np.bincount(components[proper[:, 0]], np.linalg.norm(cross_products(vertices, proper), axis=1) / 2.0, minlength=count)
    visits = np.bincount(np.concatenate([rim.vertices for rim in rims]), minlength=n)
    near = proper[(visits[proper] > 0).any(axis=1)]
    angles = np.bincount(near.T.ravel(), corner_angles(vertices, near).T.ravel(), n)
    verdicts: list[Outer] = []
    for rim in (each.vertices for each in rims):
        area = areas[components[rim[0]]]
        turn = float((np.pi - angles[rim] / visits[rim]).sum())
        if side_lengths(vertices[rim]).sum() ** 2 < SHORT_RIM * area:
            verdicts.append("no")
        elif turn > OUTER_TURN:
            verdicts.append("surely")
        elif turn > FRAME_TURN and float(np.linalg.norm(area_vector(vertices[rim]))) > OUTER_SHARE * area:
            verdicts.append("probably")
        else:
            verdicts.append("no")
    return verdicts


def sorted_rims(
    rims: list[BoundaryLoop], points: Floats, triangles: Ints, max_edges: int, selected: Bools | None, join: bool
) -> tuple[list[tuple[BoundaryLoop, list[BoundaryLoop]]], list[OpenRim]]:
    """Returns the holes to close, each with the rims of its islands, and the other rims with their reasons."""
    outer = outer_borders(rims, points, triangles)
    holes = [rim for rim, outside in zip(rims, outer, strict=True) if outside == "no"]
    borders = [(rim, outside) for rim, outside in zip(rims, outer, strict=True) if outside != "no"]
    reasons: dict[int, Reason] = {
        id(rim): "seam" if is_seam(rim, points) else "outer" if how == "surely" else "probably_outer" for rim, how in borders
    }
    around = [-1] * len(borders)
    if join and borders and holes:
        around = _holes_around([rim for rim, _ in borders], holes, points, triangles)
    groups: list[tuple[BoundaryLoop, list[BoundaryLoop]]] = [(hole, []) for hole in holes]
    others = []
    for (rim, outside), number in zip(borders, around, strict=True):
        if number >= 0 and (selected is None or selected[holes[number].vertices].any()):
            groups[number][1].append(rim)
        elif outside == "probably" and selected is not None and selected[rim.vertices].any():
            groups.append((rim, []))
        else:
            others.append(left_open_as(rim, reasons[id(rim)]))
    groups.sort(key=lambda group: tuple(group[0].vertices[:2].tolist()))
    closed = []
    for hole, inside in groups:
        edges = len(hole.vertices)
        if selected is not None and not selected[hole.vertices].any():
            others.append(left_open_as(hole, "selection"))
        elif edges > max_edges:
            others.append(left_open_as(hole, "size", f": it has more than {max_edges}; to close it, raise max_edges to {edges}"))
        elif is_seam(hole, points):
            others.append(left_open_as(hole, "seam"))
        elif any(is_seam(rim, points) for rim in inside):
            others.append(left_open_as(hole, "island", ISLAND_IN_IT))
        else:
            closed.append((hole, inside))
            continue
        others += [left_open_as(rim, reasons[id(rim)]) for rim in inside]
    return closed, others


def _holes_around(islands: list[BoundaryLoop], holes: list[BoundaryLoop], vertices: Floats, faces: Ints) -> list[int]:
    """Returns, for each outer rim in `islands`, the index of the smallest hole around it in another component; -1 for no hole.

    An island lies in a hole if all vertices of its rim are near the middle plane of the hole, if their projections on this plane
    are inside the hole's rim, and if the island is oriented like the surface around the hole. Its middle must also lie in the
    smallest ball around the middle of the hole that contains the hole's rim.
    """
    components, _ = connected_components(faces, len(vertices))
    rims = [vertices[hole.vertices] for hole in holes]
    middles = np.array([rim.mean(axis=0) for rim in rims])
    reaches = np.array([np.linalg.norm(rim - middle, axis=1).max() for rim, middle in zip(rims, middles, strict=True)])
    sheets = components[[hole.vertices[0] for hole in holes]]
    numbers = []
    for island in islands:
        points = vertices[island.vertices]
        close = np.linalg.norm(middles - points.mean(axis=0), axis=1) < reaches
        others = np.flatnonzero(close & (sheets != components[island.vertices[0]])).tolist()
        size, number = min(((_size_if_inside(points, rims[h]), h) for h in others), default=(np.inf, -1))
        numbers.append(number if size < np.inf else -1)
    return numbers


def _size_if_inside(island: Floats, hole: Floats) -> float:
    """Returns the projected area of a hole if the island lies in it, see `_holes_around`, else infinity; both are (k, 3) rims."""
    middle, normal = hole.mean(axis=0), area_vector(hole)
    size = float(np.linalg.norm(normal))
    # If the island is oriented like the surface around, its rim runs opposite to the hole's rim.
    if not size > 0.0 or float(normal @ area_vector(island)) >= 0.0:
        return np.inf
    normal = normal / size
    if np.abs((island - middle) @ normal).max() > _HEIGHT * np.sqrt(size):
        return np.inf
    x = np.eye(3)[np.abs(normal).argmin()]
    x = np.cross(normal, x) / np.linalg.norm(np.cross(normal, x))
    plane = np.column_stack([x, np.cross(normal, x)])
    across, up = ((island - middle) @ plane).T
    inside = np.zeros(len(island), dtype=np.bool_)
    corners = (hole - middle) @ plane
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        # A ray along the first axis from a point inside the rim crosses the rim an odd number of times.
        over = np.flatnonzero((a[1] > up) != (b[1] > up))
        inside[over] ^= a[0] + (up[over] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) > across[over]
    return size if inside.all() else np.inf

"""Which rims are closed, with which islands in them, and why the others are not."""

from typing import Literal, NamedTuple

from ..mesh import Bools, Floats, Ints
from ..topology import BoundaryLoop, connected_components, is_seam
from .filling import OpenRim
from .islands import holes_around, outer_borders
from .left_open import ISLAND_IN_IT, left_open_as

#: The largest number of edges of a hole and the islands in it together, or `max_edges` if that is larger: memory grows with its
#: square.
MOST_JOINED = 10_000


class SortedRims(NamedTuple):
    """The rims of a mesh.

    Attributes:
        holes: those to close.
        inside: for each index in `holes` the rims of the islands in that hole.
        left: the others with the reason.
    """

    holes: list[BoundaryLoop]
    inside: dict[int, list[BoundaryLoop]]
    left: list[OpenRim]


def sorted_rims(
    rims: list[BoundaryLoop],
    points: Floats,
    triangles: Ints,
    max_edges: int,
    selected: Bools | None,
    islands: Literal["join", "leave"],
) -> SortedRims:
    """Separates holes from outer borders and islands first, then drops the holes that are too large, seams or not selected."""
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
    inside: dict[int, list[BoundaryLoop]] = {}
    for hole in holes:
        group = in_hole.get(id(hole), [])
        refused = _refused(hole, group, points, max_edges, selected)
        if refused is None:
            inside[len(closed)] = group
            closed.append(hole)
        else:
            left.append(refused)
            left += [left_open_as(rim, "seam" if is_seam(rim, points) else "outer") for rim in group]
    return SortedRims(closed, inside, left)


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

"""Which rims are closed, with which islands in them, and why the others are not."""

from typing import Literal, NamedTuple

from ..mesh import Bools, Floats, Ints
from ..topology import connected_components
from .filling import OpenRim, Reason
from .islands import holes_around, outer_borders
from .rims import Rim, is_seam


class SortedRims(NamedTuple):
    """The rims of a mesh.

    Attributes:
        holes: those to close.
        inside: for the numbers of some of them the rims of the islands in them.
        left: the others with the reason.
    """

    holes: list[Rim]
    inside: dict[int, list[Rim]]
    left: list[OpenRim]


def sorted_rims(
    rims: list[Rim], points: Floats, triangles: Ints, max_edges: int, selected: Bools | None, islands: Literal["join", "leave"]
) -> SortedRims:
    """Which rims to close, with which islands; they are told from holes before anything else is asked of them."""
    outer = outer_borders(rims, points, triangles)
    holes = [rim for rim, outside in zip(rims, outer, strict=True) if outside == "no"]
    borders = [(rim, outside) for rim, outside in zip(rims, outer, strict=True) if outside != "no"]
    around = [-1] * len(borders)
    if islands == "join" and borders and holes:
        components, _ = connected_components(triangles, len(points))
        around = holes_around([rim for rim, _ in borders], holes, points, components)
    in_hole: dict[int, list[Rim]] = {}
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
    closed: list[Rim] = []
    inside: dict[int, list[Rim]] = {}
    for hole in holes:
        group = in_hole.get(id(hole), [])
        why = _not_wanted(hole, group, points, max_edges, selected)
        if why is None:
            inside[len(closed)] = group
            closed.append(hole)
        else:
            left.append(why)
            left += [left_open_as(rim, "seam" if is_seam(rim, points) else "outer") for rim in group]
    return SortedRims(closed, inside, left)


def _not_wanted(hole: Rim, islands: list[Rim], points: Floats, max_edges: int, selected: Bools | None) -> OpenRim | None:
    """Why a hole is not to be closed, if so."""
    if len(hole.vertices) > max_edges:
        return left_open_as(hole, "size", f": it has more than {max_edges}")
    if is_seam(hole, points):
        return left_open_as(hole, "seam")
    if selected is not None and not selected[hole.vertices].any():
        return left_open_as(hole, "selection")
    if any(is_seam(rim, points) for rim in islands):
        return left_open_as(hole, "island", ISLAND_IN_IT)
    return None


ISLAND_IN_IT = (
    ": an island lies in it that cannot be joined to it; to fill it nonetheless, delete the island or leave islands loose"
)
#: A hole and the islands in it may have so many edges together, or as many as a hole alone: memory grows with the square.
MOST_JOINED = 10_000

_WHY: dict[Reason, str] = {
    "selection": ", none of whose vertices is selected",
    "outer": ": it is the outer border of an open sheet",
    "probably_outer": ": it spans so much of the area of its sheet that it seems to be the outer border; if it is a hole, "
    "select a vertex of it and close only the holes at the selection",
    "island": ": it is the border of an island that cannot be joined to the hole around it",
    "seam": ": its two sides are in the same places, so merge close vertices",
    "no_triangulation": ": every triangulation of it would have triangles without area, as where its vertices coincide or lie "
    "on a line, or edges with more than two faces",
}


def left_open_as(rim: Rim, reason: Reason, more: str = "") -> OpenRim:
    """The rim, and the sentence that says why it is left; `more` in place of what is usually said for this reason."""
    edges = len(rim.vertices)
    why = more or _WHY[reason]
    return OpenRim(rim.vertices, reason, f"the rim of {edges} edges through vertex {rim.vertices[0]} was left{why}")

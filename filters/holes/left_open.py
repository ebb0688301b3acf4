"""Rims that are left open, with the sentence that says why and what to do."""

from ..topology import BoundaryLoop, BrokenBorder
from .filling import OpenRim, Reason

ISLAND_IN_IT = (
    ": an island lies in it that cannot be joined to it; to fill it nonetheless, delete the island or leave islands loose"
)

_WHY: dict[Reason, str] = {
    "selection": ", none of whose vertices is selected",
    "outer": ": it is the outer border of an open sheet",
    "probably_outer": ": it spans so much of the area of its sheet that it seems to be the outer border; if it is a hole, "
    "select a vertex of it and close only the holes at the selection",
    "island": ": it is the border of an island that cannot be joined to the hole around it",
    "seam": ": its two sides are in the same places, so merge close vertices",
    "no_triangulation": ": every triangulation of it would have triangles without area, as where its vertices coincide or lie "
    "on a line, or edges with more than two faces",
    "non_manifold": "an edge with more than two faces ends there: delete or separate its faces",
    "orientation": "the faces there are not coherently oriented: orient them first",
}


def left_open_as(rim: BoundaryLoop, reason: Reason, more: str = "") -> OpenRim:
    """The rim with its reason, and in the message `more` in place of what is usually said for this reason."""
    edges = len(rim.vertices)
    why = more or _WHY[reason]
    return OpenRim(rim.vertices, reason, f"the rim of {edges} edges through vertex {rim.vertices[0]} was left{why}")


def broken_left_open(border: BrokenBorder) -> OpenRim:
    """A part of the border that forms no loop."""
    others = len(border.vertices) - 1
    message = f"the border through vertex {border.vertex} (and {others} others) was left: {_WHY[border.reason]}"
    return OpenRim(border.vertices, border.reason, message)

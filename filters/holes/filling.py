"""The result of closing holes: vertices and faces to add, rims left open with their reasons."""

from typing import Literal, NamedTuple, TypeAlias, get_args

from ..mesh import Floats, Ints
from ..topology import BoundaryLoop, BrokenBorder

#: Why a rim was left open. "size": the hole has more edges than `max_edges`. "selection": none of its vertices is selected.
#: "outer": it is the outer border of an open sheet. "probably_outer": it seems to be one, by its area. "island": it is the border
#: of an island that could not be joined to the hole around it, or the rim of that hole. "seam": its two sides coincide.
#: "orientation": faces at it are not coherently oriented. "non_manifold": an edge with more than two faces ends at it.
#: "no_triangulation": any triangulation would have degenerate triangles or edges with more than two faces.
Reason: TypeAlias = Literal[
    "size", "selection", "outer", "probably_outer", "island", "seam", "orientation", "non_manifold", "no_triangulation"
]
#: How the new vertices are placed: by `fair_region` with this energy, or for "none" where refinement put them. From the lowest
#: order to the highest.
HoleEnergy: TypeAlias = Literal["none", "membrane", "thin_plate", "minimum_variation"]
HOLE_ENERGIES: tuple[HoleEnergy, ...] = get_args(HoleEnergy)
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


class OpenRim(NamedTuple):
    """A rim that was left open.

    Attributes:
        vertices: (k,) int32 its vertices, in order along the rim; ascending for the reasons "orientation" and "non_manifold",
            where there is no such order.
        reason: why, one word.
        message: why, one sentence with the numbers.
    """

    vertices: Ints
    reason: Reason
    message: str


class HoleFilling(NamedTuple):
    """Vertices and faces that close the holes of a mesh of n vertices and m faces.

    The closed mesh is ``np.concatenate([vertices, new_vertices])`` and ``np.concatenate([faces, new_faces])``.

    Attributes:
        new_vertices: (a, 3) float64.
        new_faces: (b, 3) int32, indices from 0 to n + a - 1: from n on they mean `new_vertices`. Oriented as the faces around.
        hole_of_face: (b,) int32, ascending, the index in `closed` of the hole that each new face closes.
        hole_of_vertex: (a,) int32, ascending, the same of each new vertex.
        closed: for every closed hole (k,) int32 the vertices of its rim in order along it, in the direction of the new faces.
        islands: for every closed hole (k,) int32 the vertices of the rims of the islands that its new faces join; mostly none.
        left_open: the other rims, and why they were left.
        energies: for every closed hole the energy that placed its new vertices: `energy`, or if its equations are too
            ill-conditioned or throw the filling out, the highest lower one that does not, or "none".
        thrown_out: for every closed hole whether a higher energy would have put new vertices outside of the box of its rim, by
            more than the diagonal of that box.
    """

    new_vertices: Floats
    new_faces: Ints
    hole_of_face: Ints
    hole_of_vertex: Ints
    closed: tuple[Ints, ...]
    islands: tuple[Ints, ...]
    left_open: tuple[OpenRim, ...]
    energies: tuple[HoleEnergy, ...]
    thrown_out: tuple[bool, ...]


def left_open_as(rim: BoundaryLoop, reason: Reason, more: str = "") -> OpenRim:
    """The rim with its reason, and a message; `more` replaces the usual explanation of this reason."""
    edges = len(rim.vertices)
    why = more or _WHY[reason]
    return OpenRim(rim.vertices, reason, f"the rim of {edges} edges through vertex {rim.vertices[0]} was left{why}")


def broken_left_open(border: BrokenBorder) -> OpenRim:
    """A part of the border that forms no loop."""
    others = len(border.vertices) - 1
    message = f"the border through vertex {border.vertex} (and {others} others) was left: {_WHY[border.reason]}"
    return OpenRim(border.vertices, border.reason, message)

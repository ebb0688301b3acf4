"""The rims of a mesh as data: how many edges, where, and whether a hole or the outer border of an open sheet."""

from typing import NamedTuple

from numpy.typing import ArrayLike

from ..geometry import side_lengths
from ..mesh import Floats, check_mesh, normalised_mesh
from ..topology import boundary_loops
from .islands import outer_borders


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

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    loops = boundary_loops(mesh.points, mesh.cells).loops
    outer = outer_borders(loops, mesh.points, mesh.cells)
    found = []
    for loop, kind in zip(loops, outer, strict=True):
        places = mesh.points[loop.vertices]
        length = float(side_lengths(places).sum()) / mesh.scale
        found.append(Rim(len(places), length, places.mean(axis=0) / mesh.scale + mesh.middle, kind != "no"))
    return sorted(found, key=lambda rim: -rim.edges)

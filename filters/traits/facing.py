"""How far a surface is seen from one side, as a range map is."""

from numpy.typing import ArrayLike

from ..geometry import seen_from_one_side
from ..mesh import check_mesh, normalised_mesh


def facing(vertices: ArrayLike, faces: ArrayLike) -> float:
    """|sum A n| / sum A over the faces of area A and normal n.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.

    Returns:
        1 of a plane, 1/2 of half a sphere, 0 of any closed surface; 0 of a mesh without area. A single range map of a scanner
        has 0.4 and more.

    Raises:
        FilterInputError: not a mesh.
    """
    mesh = normalised_mesh(*check_mesh(vertices, faces))
    return seen_from_one_side(mesh.points, mesh.cells)

"""How far from equilateral triangles are."""

from numpy.typing import ArrayLike

from ..mesh import Floats, check_mesh, normalised_mesh
from .face_measures import face_measures


def triangle_shapes(vertices: ArrayLike, faces: ArrayLike) -> Floats:
    """(m,) l / (sqrt(3) R) of every face, l its shortest edge and R its circumradius: 1 if equilateral, towards 0 for slivers.

    A right-angled isosceles triangle has 0.816. 0 where a face has no area.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    return face_measures((points - mesh.middle) * mesh.scale, triangles)[2]

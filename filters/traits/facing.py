"""How far a surface is seen from one side, as a range map is."""

import numpy as np
from numpy.typing import ArrayLike

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
    corners = mesh.points[mesh.cells]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = float(np.linalg.norm(areas, axis=1).sum())
    return float(np.linalg.norm(areas.sum(axis=0))) / total if total > 0.0 else 0.0

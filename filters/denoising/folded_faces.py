"""Faces that strong noise, or too strong a filter, has folded over."""

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import NORMAL, measure_faces
from ..mesh import check_mesh, normalised_mesh
from .normal_filters import mean_normals
from .surroundings import Surroundings


def folded_faces(vertices: ArrayLike, faces: ArrayLike) -> int:
    """How many faces look away from the mean normal of the faces at their vertices, weighted by area.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.

    Raises:
        FilterInputError: not a mesh.
    """
    mesh = normalised_mesh(*check_mesh(vertices, faces))
    known = Surroundings.of(mesh)
    table = measure_faces(mesh.in_order(known.places).points, known.faces)
    normals = np.ascontiguousarray(table[:, NORMAL])
    means = mean_normals(normals, table, known.around("vertex"))
    return int((np.einsum("ij,ij->i", normals, means) < 0.0).sum())

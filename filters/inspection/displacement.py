"""The signed distance of a surface from another one."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice
from ..geometry import vector_lengths
from ..mesh import Floats, check_mesh
from .surface import Surface

#: "vertex": vertex i belongs to vertex i. "surface": every vertex belongs to the nearest place of the reference. "auto": the
#: first if both have as many vertices and the same faces, at least one; else the second.
Correspondence: TypeAlias = Literal["auto", "vertex", "surface"]


@dataclass(frozen=True, eq=False)
class Displacement:
    """The distances of n vertices from their counterparts on a reference.

    Attributes:
        vectors: (n, 3) from the counterpart to the vertex, in mesh units.
        distances: (n,) their lengths.
        signed: (n,) how far to the outer side of the reference: of vertices with the same number the part along the normal of the
            reference there, 0 where they slid within the surface; else the distance, negative on the inner side.
        by_vertex: whether vertices were compared with those of the same number.
    """

    vectors: Floats
    distances: Floats
    signed: Floats
    by_vertex: bool


def displacement(
    vertices: ArrayLike,
    faces: ArrayLike,
    reference_vertices: ArrayLike,
    reference_faces: ArrayLike,
    *,
    correspondence: Correspondence = "auto",
) -> Displacement:
    """Measure how far the vertices of a mesh or a cloud lie from a reference.

    Exact to the digits that the coordinates have, far from the origin, too: differences come before squares.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles, none for a cloud; used for the correspondence alone.
        reference_vertices: (k, 3) coordinates.
        reference_faces: (l, 3) triangles, none for a cloud.
        correspondence: see `Correspondence`.

    Raises:
        FilterInputError: not a mesh, an empty reference, or vertices that cannot correspond as they differ in number.
    """
    check_choice("correspondence", correspondence, Correspondence)
    points, triangles = check_mesh(vertices, faces)
    targets, target_faces = check_mesh(reference_vertices, reference_faces)
    ground = Surface.of(targets, target_faces)
    same = len(points) == len(targets)
    if correspondence == "vertex" and not same:
        raise FilterInputError(
            f"the mesh has {len(points)} vertices and the reference {len(targets)}: vertices of the same number are no "
            "counterparts; take the correspondence 'surface'"
        )
    by_vertex = correspondence == "vertex" or (
        correspondence == "auto" and same and len(triangles) > 0 and np.array_equal(triangles, target_faces)
    )
    if not by_vertex:
        nearest = ground.nearest(points, vectors=True)
        return Displacement(nearest.vectors, nearest.distances, nearest.signed, by_vertex=False)
    vectors = points - targets
    heights = np.einsum("ij,ij->i", vectors, ground.normals_at_vertices())
    return Displacement(vectors, vector_lengths(vectors), heights, by_vertex=True)

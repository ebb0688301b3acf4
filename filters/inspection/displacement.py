"""How far a surface lies from another one, and on which side."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice
from ..mesh import Floats, Ints, Longs, check_mesh, normalised_mesh
from ..topology import proper_faces
from .closest_points import closest_points
from .corner_angles import vertex_normals

#: "vertex": vertex i belongs to vertex i. "surface": every vertex belongs to the nearest place of the reference. "auto": the
#: first if both have as many vertices and the same faces, at least one; else the second.
Correspondence: TypeAlias = Literal["auto", "vertex", "surface"]
CORRESPONDENCES: tuple[Correspondence, ...] = get_args(Correspondence)


@dataclass(frozen=True, eq=False)
class Displacement:
    """What lies between n vertices and their counterparts on a reference.

    Attributes:
        vectors: (n, 3) from the counterpart to the vertex, in mesh units.
        distances: (n,) their lengths.
        signs: (n,) 1 on the side to which the normals of the reference point, and where they tell nothing; -1 on the other.
        by_vertex: whether vertices were compared with those of the same number.
    """

    vectors: Floats
    distances: Floats
    signs: Floats
    by_vertex: bool

    @property
    def signed(self) -> Floats:
        """(n,) the distances, negative on the inner side."""
        return self.signs * self.distances


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
        faces: (m, 3) triangles, none for a cloud; they only tell whether vertices correspond.
        reference_vertices: (k, 3) coordinates.
        reference_faces: (l, 3) triangles, none for a cloud.
        correspondence: see `Correspondence`.

    Raises:
        FilterInputError: not a mesh, an empty reference, or vertices that cannot correspond as they differ in number.
    """
    check_choice("correspondence", correspondence, CORRESPONDENCES)
    points, triangles = check_mesh(vertices, faces)
    targets, target_faces = check_mesh(reference_vertices, reference_faces)
    if len(targets) == 0:
        raise FilterInputError("the reference has no vertices: there is nothing to measure from")
    same = len(points) == len(targets)
    if correspondence == "vertex" and not same:
        raise FilterInputError(
            f"the mesh has {len(points)} vertices and the reference {len(targets)}: vertices of the same number are no "
            "counterparts; take the correspondence 'surface'"
        )
    by_vertex = correspondence == "vertex" or (
        correspondence == "auto" and same and len(triangles) > 0 and np.array_equal(triangles, target_faces)
    )
    ground = normalised_mesh(targets, target_faces[proper_faces(target_faces)])
    normals = vertex_normals(ground.points, ground.cells)
    if by_vertex:
        vectors = points - targets
        distances = np.linalg.norm(vectors * ground.scale, axis=1) / ground.scale
        at_vertices = np.zeros_like(targets)
        at_vertices[ground.used] = normals
        normals = at_vertices
    else:
        queries = (points - ground.middle) * ground.scale
        closest = closest_points(queries, ground.points, ground.cells)
        vectors, distances = (queries - closest.places) / ground.scale, closest.distances / ground.scale
        normals = _normals_at(closest.places, closest.elements, ground.points, ground.cells, normals)
    outwards = np.einsum("ij,ij->i", vectors * ground.scale, normals)
    return Displacement(vectors, distances, np.where(outwards < 0.0, -1.0, 1.0), by_vertex)


def _normals_at(places: Floats, elements: Longs, points: Floats, faces: Ints, normals: Floats) -> Floats:
    """(q, 3) the normals of the vertices, interpolated to places on faces; those of a cloud are 0."""
    if len(faces) == 0:
        return np.zeros_like(places)
    corners = faces[elements]
    a, b, c = (points[corners[:, k]] for k in range(3))
    # Areas of the three triangles that the place makes with the edges, up to a factor that does not matter.
    weights = [np.linalg.norm(np.cross(q - places, r - places), axis=1) for q, r in ((b, c), (c, a), (a, b))]
    mixed = sum(w[:, None] * normals[corners[:, k]] for k, w in enumerate(weights))
    flat = sum(weights) == 0.0
    return np.asarray(np.where(flat[:, None], normals[corners].sum(axis=1), mixed))

"""Measures of a surface: size, topology, roughness and the quality of its triangles.

The time is linear in the size of the mesh, except for sorting the edges at each vertex. Coordinates are taken relative to the
middle of the mesh, so that meshes far from the origin (UTM, ECEF) lose no precision.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..execution import blocks
from ..geometry import edge_lengths, looking_away
from ..mesh import Floats, Ints, check_edges, check_mesh, normalised_mesh
from ..neighbours import nearest_neighbours
from .connectivity import Connectivity, connectivity
from .face_measures import dihedral_angles, face_measures


@dataclass(frozen=True)
class SurfaceMeasures:
    """The measures of one mesh; lengths in mesh units, areas and volumes in their square and cube, angles in degrees.

    A measure is None where it is not defined: the volume of a mesh with a border, the edges of a point cloud. A face that names
    a vertex twice counts in `faces` and `degenerate_faces` and nowhere else. Edges of polylines are measured in meshes without
    faces; in others they only count as references to their vertices.

    Attributes:
        vertices: all of them.
        faces: all of them.
        edges: edges of the faces, or in a mesh without faces of the polylines, each once.
        unreferenced_vertices: vertices that no face and no edge uses.
        degenerate_faces: faces of no area: a vertex named twice, coincident vertices, three vertices on a line. They are left
            out of `roughness` and count as 0 in `triangle_quality`.
        folded_faces: faces whose normals point away from the normals at their vertices, see
            `pymeshfair.filters.inspection.folded_faces`.
        border_edges: edges with exactly one face.
        non_manifold_edges: edges with more than two faces.
        non_manifold_vertices: vertices of a non-manifold edge, and those whose faces form more than one fan, such as the tip
            where two cones touch.
        components: connected components of the faces, or in a mesh without faces of the edges; isolated vertices are not counted.
        closed: there are faces and every edge has two.
        oriented: the two faces of an inner edge traverse it in opposite directions, so that they agree on the outside.
        euler_characteristic: vertices with an edge - edges + faces.
        genus: the number of handles, all components together: components - euler_characteristic / 2. Only for closed, oriented
            meshes without non-manifold vertices.
        diagonal: of the bounding box of all vertices.
        area: of all faces.
        volume: sum of det(a, b, c) / 6 over the faces, positive if they are counter-clockwise seen from outside. Only for closed,
            oriented meshes.
        mean_edge: the mean length of the edges.
        roughness: the mean angle between the normals of two faces that share an edge: 0 for a plane, larger is rougher. The
            orientation of the faces does not matter.
        triangle_quality: the mean of l / (sqrt(3) R) over the faces, l the shortest edge and R the circumradius: 1 if all are
            equilateral, towards 0 for slivers.
        mean_spacing: the mean distance from a point to its nearest neighbour; only for meshes of two points or more
            without faces and edges.
    """

    vertices: int
    faces: int
    edges: int
    unreferenced_vertices: int
    degenerate_faces: int
    folded_faces: int
    border_edges: int
    non_manifold_edges: int
    non_manifold_vertices: int
    components: int
    closed: bool
    oriented: bool
    euler_characteristic: int
    genus: int | None
    diagonal: float
    area: float
    volume: float | None
    mean_edge: float | None
    roughness: float | None
    triangle_quality: float | None
    mean_spacing: float | None


def surface_measures(vertices: ArrayLike, faces: ArrayLike, *, edges: ArrayLike = ()) -> SurfaceMeasures:
    """Measure a triangle mesh, polylines (no faces) or a point cloud (no faces and no edges).

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) indices of vertices.
        edges: (e, 2) indices of vertices, the edges of polylines. An edge from a vertex to itself only makes that vertex
            a referenced one.

    Raises:
        FilterInputError: a coordinate that is not finite, or an index that names no vertex.
    """
    return measures_and_connectivity(vertices, faces, edges=edges)[0]


def measures_and_connectivity(
    vertices: ArrayLike, faces: ArrayLike, *, edges: ArrayLike = (), former: Connectivity | None = None
) -> tuple[SurfaceMeasures, Connectivity]:
    """The measures of `surface_measures`, and the connectivity, which takes half of the time.

    `former` is the connectivity of another mesh, such as this one before its vertices moved: reused if faces and edges are equal.
    """
    points, triangles = check_mesh(vertices, faces)
    n_vertices, n_faces = len(points), len(triangles)
    segments = check_edges(edges, n_vertices)
    mesh = normalised_mesh(points, triangles if n_faces else segments)
    unit, diagonal = 1.0 / mesh.scale, box_diagonal(points)
    points = mesh.points
    if len(mesh) < n_vertices:
        points = np.zeros((n_vertices, 3))
        points[mesh.used] = mesh.points
    topology = former
    if topology is None or not topology.is_of(n_vertices, triangles, segments):
        topology = connectivity(n_vertices, triangles, segments)

    lengths = edge_lengths(points, topology.pairs)
    mean_edge = float(lengths.mean()) * unit if len(lengths) else None
    normals, doubled, quality = face_measures(points, topology.proper)
    area, degenerate, shape = float(doubled.sum()) / 2, n_faces - int((doubled > 0).sum()), float(quality.sum())
    del doubled, quality, lengths  # lowers the peak memory for scans of millions of vertices
    closed, oriented = topology.closed, topology.oriented
    angles = dihedral_angles(normals, topology.neighbours, topology.agree)
    angles = angles[np.isfinite(angles)]
    measures = SurfaceMeasures(
        vertices=n_vertices,
        faces=n_faces,
        edges=len(topology.pairs),
        unreferenced_vertices=topology.unreferenced,
        degenerate_faces=degenerate,
        folded_faces=int(looking_away(normals, topology.proper, n_vertices).sum()),
        border_edges=topology.border,
        non_manifold_edges=topology.crowded,
        non_manifold_vertices=topology.pinched,
        components=topology.components,
        closed=closed,
        oriented=oriented,
        euler_characteristic=topology.euler,
        genus=topology.components - topology.euler // 2 if closed and oriented and not topology.pinched else None,
        diagonal=diagonal,
        area=area * unit * unit,
        volume=_volume(points, topology.proper, normals) * unit * unit * unit if closed and oriented else None,
        mean_edge=mean_edge,
        roughness=math.degrees(float(angles.mean())) if len(angles) else None,
        triangle_quality=shape / n_faces if n_faces else None,
        mean_spacing=float(nearest_neighbours(points, 1)[0].mean()) * unit
        if n_faces == len(segments) == 0 and n_vertices > 1
        else None,
    )
    return measures, topology


def box_diagonal(points: Floats) -> float:
    """The diagonal of the box of all points, without overflow."""
    cloud = normalised_mesh(points, np.empty((0, 3), np.int32))
    return cloud.diagonal / cloud.scale


def _volume(points: Floats, faces: Ints, normals: Floats) -> float:
    """Sum of det(a, b, c) / 6 = a . ((b - a) x (c - a)) / 6."""
    products = np.empty(len(faces))
    for part in blocks(len(faces)):
        np.einsum("ij,ij->i", points[faces[part, 0]], normals[part], out=products[part])
    return float(products.sum()) / 6

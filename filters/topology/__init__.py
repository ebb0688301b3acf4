"""Connectivity from triangle lists: edges, one-rings, stars, faces at vertices and across edges, flips, boundary loops, parts."""

from .boundary import Boundary, BoundaryLoop, BrokenBorder, boundary_loops, is_seam
from .components import connected_components, root_of
from .edge_lists import (
    BORDER_POLICIES,
    BorderPolicy,
    EdgeFaces,
    border_edges,
    border_vertices,
    edge_face_counts,
    edge_faces,
    edges,
    face_adjacency,
    faces_across,
    non_manifold_edges,
    proper_faces,
    referenced_vertices,
)
from .flips import corner_at, diamond, fan_size, flip, relink
from .rings import OneRings, VertexFaces, one_rings, position, ring_ends, sort_slice, vertex_faces
from .submesh import Submesh, submesh_around
from .vertex_stars import CLOSED, IRREGULAR, NO_STAR, OPEN, Stars, stars

__all__ = [
    "BORDER_POLICIES",
    "CLOSED",
    "IRREGULAR",
    "NO_STAR",
    "OPEN",
    "BorderPolicy",
    "Boundary",
    "BoundaryLoop",
    "BrokenBorder",
    "EdgeFaces",
    "OneRings",
    "Stars",
    "Submesh",
    "VertexFaces",
    "border_edges",
    "border_vertices",
    "boundary_loops",
    "connected_components",
    "corner_at",
    "diamond",
    "edge_face_counts",
    "edge_faces",
    "edges",
    "face_adjacency",
    "faces_across",
    "fan_size",
    "flip",
    "is_seam",
    "non_manifold_edges",
    "one_rings",
    "position",
    "proper_faces",
    "referenced_vertices",
    "relink",
    "ring_ends",
    "root_of",
    "sort_slice",
    "stars",
    "submesh_around",
    "vertex_faces",
]

"""Connectivity from triangle lists: edges, one-rings, stars, faces at vertices and across edges, flips, boundary loops, parts."""

from .adjacency import EdgeFaces, edge_faces, face_adjacency, faces_across
from .ascending_slices import position, sort_slice
from .border import BORDER_POLICIES, BorderPolicy, border_edges, border_vertices
from .boundary import Boundary, BoundaryLoop, BrokenBorder, boundary_loops, is_seam
from .components import connected_components
from .edge_lists import edge_face_counts, edges, non_manifold_edges, proper_faces, referenced_vertices
from .flips import corner_at, diamond, fan_size, flip, relink
from .lists_by_vertex import VertexFaces, ring_ends, vertex_faces
from .rings import OneRings, one_rings
from .star_order import CLOSED, IRREGULAR, NO_STAR, OPEN
from .submesh import Submesh, submesh_around
from .vertex_stars import Stars, stars

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
    "sort_slice",
    "stars",
    "submesh_around",
    "vertex_faces",
]

"""Connectivity: edges, one-rings, stars, faces around vertices, borders, components and submeshes."""

from .adjacency import face_adjacency
from .border import BORDER_POLICIES, BorderPolicy, border_edges, border_vertices
from .components import connected_components
from .edge_lists import edge_face_counts, edges, non_manifold_edges, referenced_vertices
from .rings import OneRings, one_rings, position, ring_ends, sort_slice
from .submesh import Submesh, submesh_around
from .vertex_faces import Corners, vertex_corners
from .vertex_stars import CLOSED, IRREGULAR, NO_STAR, OPEN, Stars, stars

__all__ = [
    "BORDER_POLICIES",
    "CLOSED",
    "IRREGULAR",
    "NO_STAR",
    "OPEN",
    "BorderPolicy",
    "Corners",
    "OneRings",
    "Stars",
    "Submesh",
    "border_edges",
    "border_vertices",
    "connected_components",
    "edge_face_counts",
    "edges",
    "face_adjacency",
    "non_manifold_edges",
    "one_rings",
    "position",
    "referenced_vertices",
    "ring_ends",
    "sort_slice",
    "stars",
    "submesh_around",
    "vertex_corners",
]

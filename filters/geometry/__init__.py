"""Lengths, normals and closest points of triangle meshes."""

from .closest_walk import WalkableSurface, nearest_by_walk, some_face
from .edge_lengths import edge_lengths, mean_edge_length
from .face_normals import AREA, CENTRE, NORMAL, face_normals, mean_angle, measure_faces

__all__ = [
    "AREA",
    "CENTRE",
    "NORMAL",
    "WalkableSurface",
    "edge_lengths",
    "face_normals",
    "mean_angle",
    "mean_edge_length",
    "measure_faces",
    "nearest_by_walk",
    "some_face",
]

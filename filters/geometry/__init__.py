"""Measures of triangles and loops, in the unit of the coordinates: lengths, angles, normals, areas, quality, closest points."""

from .angles import angles_between, corner_angles
from .closest_walk import WalkableSurface, nearest_by_walk
from .edge_lengths import edge_lengths, mean_edge_length, vector_lengths
from .face_normals import (
    AREA,
    CENTRE,
    NORMAL,
    cross_products,
    face_normals,
    measure_faces,
    normal_differences,
    seen_from_one_side,
    turned_faces,
)
from .loops import area_vector, side_lengths
from .triangles import angle_at, closest_weights, cross_product, quality_and_normal, squared_length
from .vertex_normals import vertex_normals_by_angle, vertex_normals_by_area

__all__ = [
    "AREA",
    "CENTRE",
    "NORMAL",
    "WalkableSurface",
    "angle_at",
    "angles_between",
    "area_vector",
    "closest_weights",
    "corner_angles",
    "cross_product",
    "cross_products",
    "edge_lengths",
    "face_normals",
    "mean_edge_length",
    "measure_faces",
    "nearest_by_walk",
    "normal_differences",
    "quality_and_normal",
    "seen_from_one_side",
    "side_lengths",
    "squared_length",
    "turned_faces",
    "vector_lengths",
    "vertex_normals_by_angle",
    "vertex_normals_by_area",
]

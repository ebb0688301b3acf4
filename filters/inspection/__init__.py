"""Inspection of surfaces: measures, scalars and colours."""

from .alignment import Alignment, align
from .color_maps import Limits, diverging_colors, robust_limits, sequential_colors, symmetric_limits
from .curvature import (
    CurvatureOperator,
    GaussianMeasure,
    gaussian_curvature,
    mean_curvature,
    mesh_normals,
)
from .displacement import Correspondence, Displacement, displacement
from .face_samples import sample_places
from .folded_faces import folded_faces, side_changes, triangle_shapes
from .reflection_lines import reflection_stripes
from .sharp_edges import SHARP, SharpEdges, share_kept, sharp_edges
from .surface import NearestPlaces, Surface
from .surface_distance import SAMPLES, DistanceStatistics, SurfaceDistance, surface_distance
from .surface_measures import SurfaceMeasures, surface_measures
from .thickness import Thickness, wall_thickness

__all__ = [
    "SAMPLES",
    "SHARP",
    "Alignment",
    "Correspondence",
    "CurvatureOperator",
    "Displacement",
    "DistanceStatistics",
    "GaussianMeasure",
    "Limits",
    "NearestPlaces",
    "SharpEdges",
    "Surface",
    "SurfaceDistance",
    "SurfaceMeasures",
    "Thickness",
    "align",
    "displacement",
    "diverging_colors",
    "folded_faces",
    "gaussian_curvature",
    "mean_curvature",
    "mesh_normals",
    "reflection_stripes",
    "robust_limits",
    "sample_places",
    "sequential_colors",
    "share_kept",
    "sharp_edges",
    "side_changes",
    "surface_distance",
    "surface_measures",
    "symmetric_limits",
    "triangle_shapes",
    "wall_thickness",
]

"""Inspection of surfaces: measures, scalars and colours."""

from .color_maps import Limits, diverging_colors, robust_limits, sequential_colors, symmetric_limits
from .curvature import CurvatureOperator, GaussianMeasure, gaussian_curvature, mean_curvature, mesh_normals, reflection_stripes
from .distances import (
    SAMPLES,
    Alignment,
    Correspondence,
    Displacement,
    DistanceStatistics,
    SurfaceDistance,
    Thickness,
    align,
    displacement,
    sample_places,
    surface_distance,
    wall_thickness,
)
from .face_changes import SHARP, SharpEdges, carried, folded_faces, share_kept, sharp_edges, side_changes, triangle_shapes
from .surface import NearestPlaces, Surface
from .surface_measures import SurfaceMeasures, surface_measures

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
    "carried",
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

"""Looking at a surface: numbers, scalars and colours that say what it is like."""

from .closest_points import ClosestPoints, closest_points
from .color_maps import Limits, diverging_colors, robust_limits, sequential_colors, symmetric_limits
from .corner_angles import angle_deficits, mesh_normals
from .curvature import (
    CURVATURE_OPERATORS,
    GAUSSIAN_MEASURES,
    CurvatureOperator,
    GaussianMeasure,
    gaussian_curvature,
    mean_curvature,
)
from .displacement import CORRESPONDENCES, Correspondence, Displacement, displacement
from .folded_faces import folded_faces
from .reflection_lines import reflection_stripes
from .sharp_edges import SHARP, SharpEdges, share_kept, sharp_edges
from .side_changes import side_changes
from .surface_measures import SurfaceMeasures, surface_measures
from .triangle_shape import triangle_shapes

__all__ = [
    "CORRESPONDENCES",
    "CURVATURE_OPERATORS",
    "GAUSSIAN_MEASURES",
    "SHARP",
    "ClosestPoints",
    "Correspondence",
    "CurvatureOperator",
    "Displacement",
    "GaussianMeasure",
    "Limits",
    "SharpEdges",
    "SurfaceMeasures",
    "angle_deficits",
    "closest_points",
    "displacement",
    "diverging_colors",
    "folded_faces",
    "gaussian_curvature",
    "mean_curvature",
    "mesh_normals",
    "reflection_stripes",
    "robust_limits",
    "sequential_colors",
    "share_kept",
    "sharp_edges",
    "side_changes",
    "surface_measures",
    "symmetric_limits",
    "triangle_shapes",
]

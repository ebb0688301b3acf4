"""Points that do not belong to the surface, found by the distances to their neighbours."""

from .far_from_points import far_from_points
from .local_outlier_probability import local_outlier_probability, outlier_factors
from .stray_points import stray_points

__all__ = [
    "far_from_points",
    "local_outlier_probability",
    "outlier_factors",
    "stray_points",
]

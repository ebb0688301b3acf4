"""Points that do not belong to the surface, found by the distances to their neighbours."""

from .factors import SPREAD_BLOCK, compare, compare_rows, probabilities_of, spread_of, standard_distances
from .far_from_points import far_from_points
from .local_outlier_probability import local_outlier_probability, outlier_factors
from .stray_points import stray_points

__all__ = [
    "SPREAD_BLOCK",
    "compare",
    "compare_rows",
    "far_from_points",
    "local_outlier_probability",
    "outlier_factors",
    "probabilities_of",
    "spread_of",
    "standard_distances",
    "stray_points",
]

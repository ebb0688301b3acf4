"""Points that do not belong to the surface, found by the distances to their neighbours."""

from .local_outlier_probability import local_outlier_probability, outlier_factors

__all__ = [
    "local_outlier_probability",
    "outlier_factors",
]

"""Outliers of point clouds and of reconstructions, found by the distances to neighbours."""

from .local_outlier_probability import (
    REPLACED_SCALARS,
    SPREAD_BLOCK,
    compare_rows,
    local_outlier_probability,
    outlier_factors,
    probabilities_of,
    spread_of,
    standard_distances,
)
from .spacing import cloud_spacings, found_words, gaps, grid_cells, surplus_points
from .stray_points import JOIN_STEPS, NO_LINK, StrayRule, cut_links, linked_parts, linked_to, part_sums, stray_points, thicknesses

__all__ = [
    "JOIN_STEPS",
    "NO_LINK",
    "REPLACED_SCALARS",
    "SPREAD_BLOCK",
    "StrayRule",
    "cloud_spacings",
    "compare_rows",
    "cut_links",
    "found_words",
    "gaps",
    "grid_cells",
    "linked_parts",
    "linked_to",
    "local_outlier_probability",
    "outlier_factors",
    "part_sums",
    "probabilities_of",
    "spread_of",
    "standard_distances",
    "stray_points",
    "surplus_points",
    "thicknesses",
]

"""Fairing: minimises an energy of the surface, on the whole mesh or on a region inside rings of fixed vertices."""

from ..diffusion import harmonic_values
from .bilaplacian import bilaplacian_smoothing, feature_weights, scalar_feature_weights, weight_of_detail_size
from .blend import Blend, blend_parts
from .region import ENERGIES, Energy, FairedRegion, fair_region
from .tangential import tangential_smoothing

__all__ = [
    "ENERGIES",
    "Blend",
    "Energy",
    "FairedRegion",
    "bilaplacian_smoothing",
    "blend_parts",
    "fair_region",
    "feature_weights",
    "harmonic_values",
    "scalar_feature_weights",
    "tangential_smoothing",
    "weight_of_detail_size",
]

"""Spectral filters: by the wavelengths of a surface, with its modes or without them."""

from .detail_enhancement import apply_coord_detail_enhancement
from .filtering import apply_coord_spectral_filter
from .modes import compute_scalar_by_manifold_harmonic_per_vertex, get_surface_spectrum

__all__ = [
    "apply_coord_detail_enhancement",
    "apply_coord_spectral_filter",
    "compute_scalar_by_manifold_harmonic_per_vertex",
    "get_surface_spectrum",
]

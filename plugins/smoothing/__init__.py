"""Smoothing by diffusion: of vertices, explicit, implicit and Taubin's; of scalars and colours that stops at edges."""

from .anisotropic import apply_color_anisotropic_diffusion_per_vertex, apply_scalar_anisotropic_diffusion_per_vertex
from .explicit import apply_coord_explicit_smoothing
from .implicit import apply_coord_implicit_fairing
from .spikes import apply_coord_spike_removal
from .taubin import apply_coord_taubin_fairing

__all__ = [
    "apply_color_anisotropic_diffusion_per_vertex",
    "apply_coord_explicit_smoothing",
    "apply_coord_implicit_fairing",
    "apply_coord_spike_removal",
    "apply_coord_taubin_fairing",
    "apply_scalar_anisotropic_diffusion_per_vertex",
]

"""Fairing: of a whole mesh, tangential, of a selected region, between two rims."""

from .bilaplacian import apply_coord_bilaplacian_smoothing
from .bridging import meshing_bridge_rims_by_fairing
from .region import apply_coord_region_fairing
from .tangential import apply_coord_tangential_smoothing

__all__ = [
    "apply_coord_bilaplacian_smoothing",
    "apply_coord_region_fairing",
    "apply_coord_tangential_smoothing",
    "meshing_bridge_rims_by_fairing",
]

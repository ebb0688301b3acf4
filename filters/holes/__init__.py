"""Holes: the rims that bound them, a triangulation of each, its refinement to the rim's density, its fairing."""

from .close_holes import close_holes
from .filling import HOLE_ENERGIES, HoleEnergy, HoleFilling, OpenRim

__all__ = [
    "HOLE_ENERGIES",
    "HoleEnergy",
    "HoleFilling",
    "OpenRim",
    "close_holes",
]

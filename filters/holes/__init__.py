"""Hole filling: triangulates a rim (a boundary loop), refines the triangles to the rim's density, fairs new vertices."""

from .closing import HOLE_ENERGIES, HoleEnergy, HoleFilling, close_holes, remesh_region
from .rims import OpenRim, Rim, find_rims

__all__ = ["HOLE_ENERGIES", "HoleEnergy", "HoleFilling", "OpenRim", "Rim", "close_holes", "find_rims", "remesh_region"]

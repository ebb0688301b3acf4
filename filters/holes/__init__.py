"""Hole filling: triangulates the rim, a boundary loop, refines the triangles to its density and fairs the new vertices."""

from .closing import HOLE_ENERGIES, HoleEnergy, HoleFilling, close_holes, remesh_region
from .rims import OpenRim, Rim, find_rims

__all__ = ["HOLE_ENERGIES", "HoleEnergy", "HoleFilling", "OpenRim", "Rim", "close_holes", "find_rims", "remesh_region"]

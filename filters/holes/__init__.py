"""Hole filling: triangulates the rim, refines the triangles to its density and fairs the new vertices.

The rim of a hole is its boundary loop.
"""

from .closing import HOLE_ENERGIES, HoleEnergy, HoleFilling, close_holes, remesh_region
from .rims import OpenRim, Rim, find_rims

__all__ = ["HOLE_ENERGIES", "HoleEnergy", "HoleFilling", "OpenRim", "Rim", "close_holes", "find_rims", "remesh_region"]

"""Closing holes: their rims are triangulated, the triangles refined to the density of the rim, the new vertices faired.

The rim of a hole is its boundary loop.
"""

from .closing import close_holes
from .filling import HOLE_ENERGIES, HoleEnergy, HoleFilling, OpenRim
from .region_remeshing import remesh_region
from .rims import Rim, find_rims

__all__ = [
    "HOLE_ENERGIES",
    "HoleEnergy",
    "HoleFilling",
    "OpenRim",
    "Rim",
    "close_holes",
    "find_rims",
    "remesh_region",
]

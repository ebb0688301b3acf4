"""Reads a pymeshlab mesh as a `Layer` and writes an `Edit` back into it; everything else leaves meshes in MeshLab alone."""

from .aftermath import after_failure
from .attributes import without_helpers
from .edits import adds, adds_or_removes, checked_edit
from .mesh_layer import MeshLayer
from .workbench import Workbench
from .writing import write_edit

__all__ = ["MeshLayer", "Workbench", "adds", "adds_or_removes", "after_failure", "checked_edit", "without_helpers", "write_edit"]

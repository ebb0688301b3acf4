"""The rooms next to MeshLab's memory: reads a pymeshlab mesh as a `Layer` and writes an `Edit` back into it."""

from .aftermath import after_failure
from .arrays import MeshLayer
from .edits import adds, adds_or_removes, checked_edit
from .workbench import Workbench
from .writing import write_edit

__all__ = ["MeshLayer", "Workbench", "adds", "adds_or_removes", "after_failure", "checked_edit", "write_edit"]

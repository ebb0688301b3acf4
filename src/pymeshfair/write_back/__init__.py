"""Reads a pymeshlab mesh as a `Layer`, and writes an `Edit` back into it in place."""

from .attributes import custom_attributes, without_helpers
from .workbench import Workbench
from .writing import write_edit

__all__ = ["Workbench", "custom_attributes", "without_helpers", "write_edit"]

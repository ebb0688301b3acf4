"""`MeshData`, the mesh that passes through a run with all its attributes, and functions that apply an `Edit` to it."""

from .apply_edit import adds, apply_edit, as_layer, as_levels, checked_edit, moved
from .mesh_data import MeshData, Source, Texture, View

__all__ = ["MeshData", "Source", "Texture", "View", "adds", "apply_edit", "as_layer", "as_levels", "checked_edit", "moved"]

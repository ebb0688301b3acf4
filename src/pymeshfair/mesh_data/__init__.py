"""The one value that travels through a run: a mesh with all its attributes, and how an edit makes the next one of it."""

from .apply_edit import adds, apply_edit, as_layer, as_levels, checked_edit, moved
from .mesh_data import MeshData, Source, Texture, View

__all__ = [
    "MeshData",
    "Source",
    "Texture",
    "View",
    "adds",
    "apply_edit",
    "as_layer",
    "as_levels",
    "checked_edit",
    "moved",
]

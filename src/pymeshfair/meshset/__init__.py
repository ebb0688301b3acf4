"""`MeshSet`: applies filters of both kinds, MeshLab's and those of plugins, and keeps the script of what was applied."""

from .mesh_set import MeshSet

__all__ = ["MeshSet"]

"""`MeshSet`: applies filters of both kinds, MeshLab's and those of plugins, and keeps the script of what was applied."""

from ..meshlab.loading import load_pymeshlab

load_pymeshlab()

from .mesh_set import MeshSet  # noqa: E402

__all__ = ["MeshSet"]

"""`MeshSet`: applies filters of MeshLab and of plugins, and keeps a script of the applied filters."""

from ..meshlab.loading import load_pymeshlab

load_pymeshlab()

from .mesh_set import MeshSet  # noqa: E402

__all__ = ["MeshSet"]

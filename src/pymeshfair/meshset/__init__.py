"""`MeshSet`: applies MeshLab's filters and those of plugins, and keeps the script of the applied ones."""

from ..meshlab.loading import load_pymeshlab

load_pymeshlab()

from .mesh_set import MeshSet  # noqa: E402

__all__ = ["MeshSet"]

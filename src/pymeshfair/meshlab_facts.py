"""Facts about MeshLab's built-in filters."""

from .declaration import Filter


def meshlab_filters() -> tuple[Filter, ...]:
    """MeshLab's filters."""
    return ()

"""Looking at a surface: numbers, scalars and colours that say what it is like."""

from .surface_measures import SurfaceMeasures, surface_measures

__all__ = [
    "SurfaceMeasures",
    "surface_measures",
]

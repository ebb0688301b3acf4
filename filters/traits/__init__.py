"""What kind of scan a mesh is, in a few numbers that are quickly measured: they say which recipe suits it."""

from .facing import facing
from .measure import TRAITS, Trait, measured_traits
from .sharpness import sharpness
from .surface_noise import surface_noise

__all__ = ["TRAITS", "Trait", "facing", "measured_traits", "sharpness", "surface_noise"]

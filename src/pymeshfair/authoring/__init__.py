"""Recipes in Python: built step by step, checked, run, saved and compared."""

from .one_run import run
from .recipe import Recipe

__all__ = ["Recipe", "run"]

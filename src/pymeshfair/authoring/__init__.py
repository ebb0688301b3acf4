"""Recipes in Python: built step by step, checked, run, saved and compared."""

from .recipe import Recipe, run

__all__ = ["Recipe", "run"]

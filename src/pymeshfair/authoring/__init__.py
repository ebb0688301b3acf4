"""Recipes in Python: built step by step, checked, run, saved and compared."""

from .recipe import Recipe

__all__ = ["Recipe"]

"""Filters clouds and meshes that are larger than memory tile by tile, with the same result as in one piece."""

"""Clouds and meshes larger than memory: cut into tiles, filtered tile by tile with dask, the same result as in one piece."""

"""Runs for clouds and meshes larger than memory: filters them tile by tile, with the same result as in one piece."""

"""Holes: the rims that bound them, a triangulation of each, its refinement to the rim's density, its fairing."""

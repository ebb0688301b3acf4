"""Surfaces as smooth as possible: minimisers of an energy, of all of a mesh or of a region between fixed rings."""

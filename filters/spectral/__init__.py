"""Spectral filters: what a surface looks like with some of its wavelengths removed, kept or made stronger."""

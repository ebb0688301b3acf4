"""Denoising that keeps features: robust statistics of normals and of neighbours, one technique a module."""

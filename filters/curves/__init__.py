"""Smoothing of polylines."""

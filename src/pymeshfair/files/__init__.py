"""Mesh files: what a file declares, reading and writing it whole, and what a format cannot keep."""

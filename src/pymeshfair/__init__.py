"""Reproducible clean-up of 3D scans for MeshLab and Python."""

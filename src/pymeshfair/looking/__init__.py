"""Measures and compares meshes, and draws pictures of them, without the window of MeshLab."""

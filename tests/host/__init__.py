"""Tests of the mesh set and of what lies between it and MeshLab's memory."""

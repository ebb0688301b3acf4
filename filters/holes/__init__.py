"""Closing holes: their rims are triangulated, the triangles refined to the density of the rim, the new vertices faired.

The rim of a hole is its boundary loop.
"""

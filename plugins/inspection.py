"""Looking at a mesh: what it measures."""

from __future__ import annotations

from dataclasses import asdict

from pymeshfair.declaration import Edit, FilterClass, Layer, mesh_filter
from pymeshfair.filters.inspection import surface_measures


@mesh_filter(name="Surface Measures", classes=FilterClass.MEASURE)
def get_surface_measures(layer: Layer) -> Edit:
    """Counts, topology, size, roughness and triangle quality of the mesh.

    Counts vertices, faces, edges, border edges, non-manifold edges and vertices, degenerate faces and components; says
    whether the surface is closed and oriented, its genus and Euler characteristic; measures area, volume (of closed
    surfaces), the mean edge (of polylines, too), roughness (the mean angle in degrees between faces that share an edge) and
    the mean triangle quality (1 for equilateral ones); of a point cloud the mean distance to the nearest point. Changes
    nothing. Exact far from the origin, too.
    """
    return Edit(values=asdict(surface_measures(layer.vertices, layer.faces, edges=layer.edges)))

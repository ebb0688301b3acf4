"""What users see of the filter."""

from __future__ import annotations

from typing import Annotated

from pymeshfair.declaration import Edit, FilterClass, Int, Layer, MeshElement, mesh_filter

from .median import median_filtering


@mesh_filter(
    name="Median of Vertex Scalars",
    classes=FilterClass.SMOOTHING,
    requires=MeshElement.FACENUMBER | MeshElement.VERTQUALITY,
    changes=MeshElement.VERTQUALITY,
)
def apply_scalar_median_per_vertex(
    layer: Layer,
    *,
    iterations: Annotated[int, Int(label="Iterations", minimum=1, maximum=1000, help="More remove larger specks.")] = 1,
) -> Edit:
    """Gives every vertex the median scalar of itself and its neighbours: specks go, edges of regions stay."""
    return Edit(vertex_scalars=median_filtering(layer.faces, layer.vertex_scalars, iterations=iterations))

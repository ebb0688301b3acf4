"""The operator of curves that corresponds to one of surfaces, for example on the borders of a mesh."""

from typing import Literal

from ..mesh import Floats, Ints
from .build import OperatorName
from .inverse_length import inverse_length_laplacian
from .laplacian import Laplacian
from .scale_dependent import scale_dependent_laplacian
from .uniform import uniform_laplacian

#: The operator of curves for each of surfaces. Inverse lengths on a polyline are linear finite elements, as cotangents are on
#: triangles; the scale-dependent operator is the second derivative by arc length, which has the unit of Laplace-Beltrami.
CURVE_OPERATOR: dict[OperatorName, Literal["uniform", "inverse_length", "scale_dependent"]] = {
    "uniform": "uniform",
    "inverse_length": "inverse_length",
    "cotangent": "inverse_length",
    "scale_dependent": "scale_dependent",
    "laplace_beltrami": "scale_dependent",
    "robust": "scale_dependent",
}


def curve_laplacian(vertices: Floats, edges: Ints, operator: OperatorName) -> Laplacian:
    """The operator of `CURVE_OPERATOR` on the polylines that the edges form, for example the borders of a mesh.

    Args:
        vertices: (n, 3) coordinates.
        edges: (e, 2) edges; the rows of vertices that none of them touches are 0.
        operator: the operator of the surface.
    """
    curve = CURVE_OPERATOR[operator]
    if curve == "uniform":
        return uniform_laplacian(edges, len(vertices))
    if curve == "inverse_length":
        return inverse_length_laplacian(vertices, edges)
    return scale_dependent_laplacian(vertices, edges)

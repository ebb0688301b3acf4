"""What an operator of surfaces becomes on curves, such as the borders of a mesh."""

from typing import Literal

from ..mesh import Floats, Ints
from .build import OperatorName
from .inverse_length import inverse_length_laplacian
from .laplacian import Laplacian
from .scale_dependent import scale_dependent_laplacian
from .uniform import uniform_laplacian

#: What an operator of surfaces becomes on a curve. Inverse lengths are to a polyline what cotangents are to triangles: linear
#: finite elements; the scale-dependent operator is their second derivative by arc length, with the unit of Laplace-Beltrami.
CURVE_OPERATOR: dict[OperatorName, Literal["uniform", "inverse_length", "scale_dependent"]] = {
    "uniform": "uniform",
    "inverse_length": "inverse_length",
    "cotangent": "inverse_length",
    "scale_dependent": "scale_dependent",
    "laplace_beltrami": "scale_dependent",
    "robust": "scale_dependent",
}


def curve_laplacian(vertices: Floats, edges: Ints, operator: OperatorName) -> Laplacian:
    """What `operator` becomes on the polylines that the edges form, such as the borders of a mesh under the policy "along".

    Args:
        vertices: (n, 3) coordinates.
        edges: (e, 2) edges; the rows of vertices that none of them touches are 0.
        operator: an operator of surfaces; its curve operator is that of `CURVE_OPERATOR`.
    """
    curve = CURVE_OPERATOR[operator]
    if curve == "uniform":
        return uniform_laplacian(edges, len(vertices))
    if curve == "inverse_length":
        return inverse_length_laplacian(vertices, edges)
    return scale_dependent_laplacian(vertices, edges)

"""Laplace operators, one a module, all of the form L = M^-1 C with the stiffness C negative semidefinite."""

from .build import OPERATOR_NAMES, OperatorName, build_laplacian
from .choice import needs_robust_operator
from .cotangent import cotangent_laplacian, cotangent_stiffness, halved_cotangents, laplace_beltrami
from .curves import CURVE_OPERATOR, curve_laplacian
from .inverse_length import SHORTEST_EDGE, inverse_length_laplacian
from .laplacian import Laplacian
from .mass import barycentric_areas, mixed_share, mixed_voronoi_areas
from .robust import robust_cloud_laplacian, robust_mesh_laplacian
from .scale_dependent import scale_dependent_laplacian
from .uniform import uniform_laplacian

__all__ = [
    "CURVE_OPERATOR",
    "OPERATOR_NAMES",
    "SHORTEST_EDGE",
    "Laplacian",
    "OperatorName",
    "barycentric_areas",
    "build_laplacian",
    "cotangent_laplacian",
    "cotangent_stiffness",
    "curve_laplacian",
    "halved_cotangents",
    "inverse_length_laplacian",
    "laplace_beltrami",
    "mixed_share",
    "mixed_voronoi_areas",
    "needs_robust_operator",
    "robust_cloud_laplacian",
    "robust_mesh_laplacian",
    "scale_dependent_laplacian",
    "uniform_laplacian",
]

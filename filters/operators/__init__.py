"""Laplace operators, one a module, all of the form L = M^-1 C with the stiffness C negative semidefinite."""

from .build import OPERATOR_NAMES, OperatorName, build_laplacian
from .cotangent import cotangent_laplacian, cotangent_stiffness, laplace_beltrami
from .inverse_length import inverse_length_laplacian
from .laplacian import Laplacian
from .mass import barycentric_areas, mixed_voronoi_areas
from .robust import robust_cloud_laplacian, robust_mesh_laplacian
from .scale_dependent import scale_dependent_laplacian
from .uniform import uniform_laplacian

__all__ = [
    "OPERATOR_NAMES",
    "Laplacian",
    "OperatorName",
    "barycentric_areas",
    "build_laplacian",
    "cotangent_laplacian",
    "cotangent_stiffness",
    "inverse_length_laplacian",
    "laplace_beltrami",
    "mixed_voronoi_areas",
    "robust_cloud_laplacian",
    "robust_mesh_laplacian",
    "scale_dependent_laplacian",
    "uniform_laplacian",
]

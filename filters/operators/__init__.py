"""Laplace operators, one a module, all of the form L = M^-1 C with the stiffness C negative semidefinite."""

from .build import OPERATOR_NAMES, OperatorName, build_laplacian
from .choice import SURFACE_OPERATORS, ChosenLaplacian, SurfaceOperatorName, surface_laplacian
from .cotangent import cotangent_laplacian, halved_cotangents, laplace_beltrami
from .curves import CURVE_OPERATOR, curve_laplacian
from .inverse_length import SHORTEST_EDGE
from .laplacian import Laplacian
from .mass import mixed_share, mixed_voronoi_areas
from .uniform import uniform_laplacian

__all__ = [
    "CURVE_OPERATOR",
    "OPERATOR_NAMES",
    "SHORTEST_EDGE",
    "SURFACE_OPERATORS",
    "ChosenLaplacian",
    "Laplacian",
    "OperatorName",
    "SurfaceOperatorName",
    "build_laplacian",
    "cotangent_laplacian",
    "curve_laplacian",
    "halved_cotangents",
    "laplace_beltrami",
    "mixed_share",
    "mixed_voronoi_areas",
    "surface_laplacian",
    "uniform_laplacian",
]

"""Laplace operators, all of the form L = M^-1 C with the stiffness C negative semidefinite."""

from .build import (
    CURVE_OPERATOR,
    OPERATOR_NAMES,
    OperatorName,
    SurfaceOperatorName,
    build_laplacian,
    curve_laplacian,
    surface_laplacian,
)
from .laplacian import (
    SHORTEST_EDGE,
    Laplacian,
    cotangent_laplacian,
    halved_cotangents,
    laplace_beltrami,
    mixed_share,
    mixed_voronoi_areas,
    uniform_laplacian,
)

__all__ = [
    "CURVE_OPERATOR",
    "OPERATOR_NAMES",
    "SHORTEST_EDGE",
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

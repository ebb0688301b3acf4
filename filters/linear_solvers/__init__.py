"""Sparse linear systems: direct and iterative solvers, factors of shifted matrices, residuals in twice the precision."""

from .conjugate_gradients import CompressedRows, conjugate_gradients, preconditioned_norm
from .fronts import Fronts
from .refined_solution import laplacian_power, refined_solution
from .smoothed_aggregation import SmoothedAggregation
from .spd_solver import FINEST_TOLERANCE, Cholesky, ShiftedFactors, SpdSolver

__all__ = [
    "FINEST_TOLERANCE",
    "Cholesky",
    "CompressedRows",
    "Fronts",
    "ShiftedFactors",
    "SmoothedAggregation",
    "SpdSolver",
    "conjugate_gradients",
    "laplacian_power",
    "preconditioned_norm",
    "refined_solution",
]

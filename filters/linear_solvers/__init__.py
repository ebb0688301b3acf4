"""Sparse linear systems: direct and iterative solvers, factors of shifted matrices, residuals in twice the precision."""

from .conjugate_gradients import CompressedRows, SmoothedAggregation, conjugate_gradients, preconditioned_norm
from .fronts import Fronts
from .spd_solver import FINEST_TOLERANCE, Cholesky, RefinedSolution, ShiftedFactors, SpdSolver, laplacian_power, refined_solution

__all__ = [
    "FINEST_TOLERANCE",
    "Cholesky",
    "CompressedRows",
    "Fronts",
    "RefinedSolution",
    "ShiftedFactors",
    "SmoothedAggregation",
    "SpdSolver",
    "conjugate_gradients",
    "laplacian_power",
    "preconditioned_norm",
    "refined_solution",
]

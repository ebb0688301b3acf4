"""Sparse linear systems: direct and iterative solvers, factors of shifted matrices, residuals in twice the precision."""

from .cholesky import Cholesky
from .compensated import laplacian_power
from .conjugate_gradients import conjugate_gradients, preconditioned_norm
from .nested_dissection import nested_dissection
from .shifted_factors import ShiftedFactors
from .smoothed_aggregation import SmoothedAggregation
from .solvers import FINEST, DirectMethod, Factorisation, SpdSolver, refined_solution, solve_spd

__all__ = [
    "FINEST",
    "Cholesky",
    "DirectMethod",
    "Factorisation",
    "ShiftedFactors",
    "SmoothedAggregation",
    "SpdSolver",
    "conjugate_gradients",
    "laplacian_power",
    "nested_dissection",
    "preconditioned_norm",
    "refined_solution",
    "solve_spd",
]

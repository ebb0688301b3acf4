"""Sparse direct solver of symmetric positive definite systems."""

from __future__ import annotations

from functools import partial

import numpy as np

from ..checks import ConvergenceError
from ..execution import Progress, abandonable, ignore_progress
from ..libraries import sparse
from ..mesh import Floats
from .fronts import Fronts

# Rows from which the factors take long enough for a thread of their own.
_QUICK = 20_000


class Cholesky:
    """The factors L D L^T of a symmetric positive definite matrix, rows in the order of nested dissection.

    They take half a second for a mesh of 100,000 vertices, and can be stopped; docs/solvers.md compares them with libraries'.
    """

    def __init__(self, matrix: sparse.csr_matrix, *, progress: Progress = ignore_progress, done: float = 0.0) -> None:
        """Factorises an (n, n) finite symmetric matrix.

        Args:
            matrix: symmetric positive definite.
            progress: called about ten times a second with `done`; may raise to stop.
            done: the share of the work that was done before.

        Raises:
            ConvergenceError: it is not positive definite to rounding.
        """
        csr = sparse.csr_matrix(matrix)
        if not (csr.diagonal() > 0.0).all():
            raise ConvergenceError("the matrix is not positive definite: it has a diagonal entry that is not positive")
        self._fronts = Fronts.of(csr)
        work = partial(self._fronts.factors, csr)
        self._values, pivots = work() if csr.shape[0] < _QUICK else abandonable(work, progress, done)
        if not ((pivots > 0.0) & (pivots < np.inf)).all():
            raise ConvergenceError(f"the matrix of {csr.shape[0]} rows is not positive definite to rounding")

    def solve(self, right_side: Floats) -> Floats:
        """The solution for (n, k) right-hand sides, (n, k)."""
        return self._fronts.solve(self._values, right_side)

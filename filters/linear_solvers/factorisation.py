"""Cholesky's factors with one step of refinement, and a check of what they give."""

from __future__ import annotations

from ..checks import ConvergenceError
from ..libraries import sparse
from ..mesh import Floats
from .cholesky import Cholesky
from .solution import Solution
from .spd_system import SpdSystem

#: A direct solution must reach this backward error, which leaves room for ill-posed systems.
_DIRECT_ROUNDING = 1e-12
#: Beyond this size the factors outgrow their 32-bit indices and the memory of most machines.
_LARGEST_FACTORS = 3_000_000


class Factorisation:
    """Cholesky's factors and one step of refinement, for many right-hand sides or where only exact will do."""

    def __init__(self, matrix: sparse.csr_matrix) -> None:
        """Factorises; see `Cholesky` for how long that takes, which cannot be interrupted.

        Args:
            matrix: (n, n) symmetric positive definite.

        Raises:
            FilterInputError: not square, not finite.
            ConvergenceError: not positive definite to rounding, or too large.
        """
        self._system = SpdSystem.of(matrix)
        if matrix.shape[0] > _LARGEST_FACTORS:
            raise ConvergenceError(f"{matrix.shape[0]} rows are more than the {_LARGEST_FACTORS} that can be factorised")
        self._factors = Cholesky(self._system.matrix)

    def solve(self, right_side: Floats) -> Solution:
        """Solves for (n,) or (n, k) right-hand sides.

        Raises:
            ConvergenceError: the matrix is so near to singular that the factors are worth nothing.
        """
        b = self._system.columns(right_side)
        x = self._factors.solve(b)
        x += self._factors.solve(b - self._system.matrix @ x)
        backward = self._system.backward_error(x, b)
        if not backward <= _DIRECT_ROUNDING:
            raise ConvergenceError(f"Cholesky's factors solve {len(b)} equations with a backward error of {backward:.3g} only")
        return Solution(x.reshape(right_side.shape), 0.0, backward, 2, "cholesky")

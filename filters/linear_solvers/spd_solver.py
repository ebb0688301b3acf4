"""Sparse symmetric positive definite systems by the method that is fastest for them; docs/solvers.md has the measured times.

The diagonal is the preconditioner where the matrix is close to it, multigrid elsewhere: its cost depends neither on the time step
nor, per row, on the size. Cholesky's factors serve repeated solves of moderate size, and as the last resort.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..checks import ConvergenceError
from ..execution import Progress, ignore_progress, part_of
from ..libraries import sparse
from ..mesh import Floats
from .conjugate_gradients import Preconditioner, conjugate_gradients, preconditioned_norm
from .factorisation import Factorisation
from .smoothed_aggregation import SmoothedAggregation
from .solution import Method, Solution
from .spd_system import SpdSystem

#: No solution is asked to be more exact than this, relative to its own energy norm: rounding would not allow it.
FINEST_TOLERANCE = 1e-12
#: A backward error of this size is rounding.
_ROUNDING = 1e-14
#: A matrix whose smoothest vector has a Rayleigh quotient below this has no factors.
_SINGULAR = 1e-13
#: Predicted steps up to which the diagonal is the better preconditioner, and the steps after which multigrid takes over.
_FEW_STEPS, _JACOBI_STEPS = 100, 250
_MULTIGRID_STEPS = 300
#: Cholesky's factors pay from this many solves on, up to the size that they take a second for.
_MANY_SOLVES, _QUICK_FACTORS = 4, 100_000


class SpdSolver:
    """Solves systems with one matrix, keeping what was prepared for the next."""

    def __init__(self, matrix: sparse.csr_matrix, *, solves: int = 1) -> None:
        """Prepares nothing yet.

        Args:
            matrix: A, (n, n) symmetric positive definite; also semidefinite, for right-hand sides in its range. Kept, not
                copied.
            solves: how many solves are to come; decides whether factors pay, from the second on.

        Raises:
            FilterInputError: A is not square, not finite, or has a diagonal entry that is not positive.
        """
        self._system = SpdSystem.of(matrix)
        self._many = solves >= _MANY_SOLVES and matrix.shape[0] <= _QUICK_FACTORS
        self._solved = False
        self._factors: Factorisation | None = None
        self._multigrid: SmoothedAggregation | None = None

    def solve(
        self,
        right_side: Floats,
        *,
        tolerance: float = 1e-10,
        reference: float | None = None,
        start: Floats | None = None,
        progress: Progress = ignore_progress,
    ) -> Solution:
        """Solves A x = b.

        Args:
            right_side: b, (n,) or (n, k). Columns are solved for in groups of three, which share one measure of error.
            tolerance: the estimated energy norm of the error, as a share of the reference. Larger is faster and less exact.
            reference: an energy norm sqrt(x^T A x) that counts as 1; None takes that of the group's own solution. An error
                below `FINEST_TOLERANCE` of the latter is not asked for.
            start: a first guess, of the shape of b.
            progress: called every few steps; may raise to stop.

        Raises:
            FilterInputError: b has another number of rows, or is not finite.
            ConvergenceError: all methods stall; the message gives the backward errors they reached.
        """
        b = self._system.columns(right_side)
        guess = np.zeros_like(b) if start is None else self._system.columns(start)
        groups, columns = [], b.shape[1]
        for first in range(0, columns, 3):
            group = slice(first, first + 3)
            partial = part_of(progress, first / columns, min(1.0, (first + 3) / columns))
            groups.append(self._solve_three(_padded(b[:, group]), _padded(guess[:, group]), tolerance, reference, partial))
        if not groups:
            return Solution(np.zeros(np.shape(right_side)), 0.0, 0.0, 0, "jacobi")
        return Solution(
            np.hstack([solved.values for solved in groups])[:, :columns].reshape(np.shape(right_side)),
            float(np.linalg.norm([solved.error for solved in groups])),
            max(solved.backward_error for solved in groups),
            sum(solved.iterations for solved in groups),
            groups[-1].method,
        )

    def _solve_three(self, b: Floats, x: Floats, tolerance: float, reference: float | None, progress: Progress) -> Solution:
        if self._factors is not None:
            return self._factors.solve(b)
        if self._solved and self._many:
            self._factors = Factorisation(self._system.matrix)
            return self._factors.solve(b)
        before = 0
        # The error of the smoothest vector is larger than its residual by one over the least eigenvalue.
        spread = float(np.sqrt(self._system.smoothness))
        if np.log(2.0 / tolerance) / np.sqrt(2.0) / spread <= _FEW_STEPS:
            attempt = self._descend(b, x, tolerance, reference, None, spread, _JACOBI_STEPS, progress)
            if attempt.converged:
                self._solved = True
                return attempt.solution("jacobi")
            x, before = attempt.values, attempt.iterations
        if self._multigrid is None:
            self._multigrid = SmoothedAggregation(self._system.matrix, progress=lambda _: progress(0.0))
        attempt = self._descend(b, x, tolerance, reference, self._multigrid, 1.0, _MULTIGRID_STEPS, progress)
        if attempt.converged:
            self._solved = True
            return attempt.solution("multigrid", before)
        stalled = (
            f"conjugate gradients stall at a backward error of {attempt.backward_error:.3g} in a system of {len(b)} equations"
        )
        if attempt.indefinite or self._system.smoothness < _SINGULAR:
            raise ConvergenceError(f"{stalled}: the matrix is not positive definite to rounding")
        progress(0.0)
        try:
            self._factors = Factorisation(self._system.matrix)
            return self._factors.solve(b)
        except ConvergenceError as error:
            raise ConvergenceError(f"{stalled}, and {error}") from error

    def _descend(
        self,
        b: Floats,
        x: Floats,
        tolerance: float,
        reference: float | None,
        precondition: Preconditioner | None,
        spread: float,
        steps: int,
        progress: Progress,
    ) -> _Attempt:
        """Conjugate gradients, restarted where the residual of the recurrence has drifted too far from the true one."""
        matrix = self._system.matrix
        own = preconditioned_norm(matrix, b, precondition)
        target = max(tolerance * (own if reference is None else reference * spread), FINEST_TOLERANCE * own)
        taken = 0
        while True:
            descent = conjugate_gradients(
                matrix, b, target=target, max_iterations=steps - taken, start=x, precondition=precondition, progress=progress
            )
            x, taken = descent.values, taken + descent.iterations
            norm = preconditioned_norm(matrix, b - matrix @ x, precondition)
            backward = self._system.backward_error(x, b)
            converged = norm <= 2.0 * target or (descent.norm <= target and backward <= _ROUNDING)
            if converged or descent.norm > target or descent.iterations == 0:
                return _Attempt(x, norm / spread, backward, taken, converged, descent.indefinite)


class _Attempt(NamedTuple):
    values: Floats
    error: float
    backward_error: float
    iterations: int
    converged: bool
    indefinite: bool

    def solution(self, method: Method, iterations_before: int = 0) -> Solution:
        return Solution(self.values, self.error, self.backward_error, iterations_before + self.iterations, method)


def _padded(columns: Floats) -> Floats:
    """(n, 3): up to three columns, then columns of zeros."""
    if columns.shape[1] == 3:
        return np.ascontiguousarray(columns)
    return np.ascontiguousarray(np.pad(columns, ((0, 0), (0, 3 - columns.shape[1]))))

"""Sparse symmetric positive definite systems by Jacobi, multigrid or Cholesky; docs/solvers.md has the times.

The diagonal is the preconditioner where the matrix is close to it. Elsewhere factors solve small systems, and multigrid large
ones: its cost depends neither on the time step nor, per row, on the size. Factors are the last resort, too.
"""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ..checks import ConvergenceError, FilterInputError
from ..execution import Progress, abandonable, ignore_progress, part_of
from ..libraries import sparse
from ..mesh import Floats
from .conjugate_gradients import Preconditioner, conjugate_gradients, preconditioned_norm
from .fronts import Fronts
from .smoothed_aggregation import SmoothedAggregation

#: Shifts that are tried.
_ATTEMPTS = 4
#: Factors with a backward error of at most the first are taken at once; if there are none, the best ones up to the second. The
#: count is right while no eigenvalue is closer to the shift than this share of the largest one, and one step of refinement makes
#: up for what the modes lose.
_GOOD, _ROUGH = 1e-12, 1e-9
# Rows from which the factors take long enough for a thread of their own.
_QUICK = 20_000


class Cholesky:
    """The factors L D L^T of a symmetric positive definite matrix; docs/solvers.md compares them with libraries'."""

    def __init__(self, matrix: sparse.csr_matrix, *, progress: Progress = ignore_progress, done: float = 0.0) -> None:
        """Factorises an (n, n) finite symmetric matrix; calls `progress` with `done` meanwhile, which may raise to stop.

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


class ShiftedFactors:
    """L D L^T of A - shift I for a symmetric A, without row exchanges.

    Without exchanges D is diagonal, and by Sylvester's law of inertia it has as many negative entries as A has eigenvalues below
    the shift. A pivot close to 0 would spoil that; then the shift is moved a little.

    Attributes:
        shift: the shift of the factors, close to the one that was to be taken.
        below: how many eigenvalues of A, counted with multiplicity, lie below the shift.
    """

    def __init__(self, matrix: sparse.csc_matrix, fronts: Fronts, shift: float, progress: Progress, done: float) -> None:
        """Factorises a symmetric (n, n) matrix, `fronts` those of its pattern, the shift above 0 or below.

        Raises:
            ConvergenceError: no shift close by gives factors.
        """
        identity = sparse.eye_array(matrix.shape[0], format="csr")
        probe = np.random.default_rng(0).normal(size=(matrix.shape[0], 1))
        size = float(np.asarray(abs(matrix).sum(axis=0)).max(initial=0.0))
        best, self._fronts = np.inf, fronts
        for attempt in range(_ATTEMPTS):
            tried = shift * (1.0 + 1e-4 * attempt)
            shifted = sparse.csr_matrix(matrix - tried * identity)
            values, pivots = abandonable(partial(fronts.factors, shifted), progress, done)
            x = fronts.solve(values, probe)
            error = float(np.linalg.norm(shifted @ x - probe) / (size * np.linalg.norm(x) + np.linalg.norm(probe)))
            if error < best:
                best, self.shift, self.below = error, tried, int((pivots < 0.0).sum())
                self._values = values
            if best <= _GOOD:
                break
        if not best <= _ROUGH:
            raise ConvergenceError(f"the operator of {matrix.shape[0]} vertices has no stable factors near the shift {shift:.6g}")

    def solve(self, right_side: Floats) -> Floats:
        """(A - shift I)^-1 times (n, b) columns, Fortran-ordered."""
        return self._fronts.solve(self._values, np.asfortranarray(right_side))


#: No solution is asked to be more exact than this, relative to its own energy norm: rounding would not allow it.
FINEST_TOLERANCE = 1e-12
#: A backward error of this size is rounding.
_ROUNDING = 1e-14
#: A matrix whose smoothest vector has a Rayleigh quotient below this has no factors.
_SINGULAR = 1e-13
#: Predicted steps up to which the diagonal is the better preconditioner, and the steps after which multigrid takes over.
_FEW_STEPS, _JACOBI_STEPS = 100, 250
_MULTIGRID_STEPS = 300
#: Where the diagonal is no good preconditioner factors are quicker than multigrid up to so many rows, for one solve and for more.
_FACTORS_FOR_ONE, _FACTORS_FOR_MORE = 50_000, 150_000
#: Elsewhere they pay from this many solves on.
_MANY_SOLVES = 4
Method: TypeAlias = Literal["jacobi", "multigrid", "cholesky"]
#: A direct solution must reach this backward error, which leaves room for ill-posed systems.
_DIRECT_ROUNDING = 1e-12
#: Beyond this size the factors outgrow their 32-bit indices and the memory of most machines.
_LARGEST_FACTORS = 3_000_000


class SpdSolver:
    """Solves systems with one matrix; multigrid and factors are kept for the next right-hand side."""

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
        self._many = solves >= _MANY_SOLVES and matrix.shape[0] <= _FACTORS_FOR_MORE
        self._quick = matrix.shape[0] <= (_FACTORS_FOR_MORE if solves > 1 else _FACTORS_FOR_ONE)
        self._solved = False
        self._factors: Cholesky | None = None
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
                below `FINEST_TOLERANCE` of the latter is no aim.
            start: a first guess, of the shape of b.
            progress: called every few steps; may raise to stop.

        Raises:
            FilterInputError: b has another number of rows, or is not finite.
            ConvergenceError: all methods stall; the message gives the backward errors they reached.
        """
        b = self._system.columns(right_side)
        guess = None if start is None else self._system.columns(start)
        groups, columns = [], b.shape[1]
        for first in range(0, columns, 3):
            group = slice(first, first + 3)
            partial = part_of(progress, first / columns, min(1.0, (first + 3) / columns))
            first_guess = None if guess is None else _padded(guess[:, group])
            groups.append(self._solve_three(_padded(b[:, group]), first_guess, tolerance, reference, partial))
        if not groups:
            return Solution(np.zeros(np.shape(right_side)), 0.0, 0.0, 0, "jacobi")
        return Solution(
            np.hstack([solved.values for solved in groups])[:, :columns].reshape(np.shape(right_side)),
            float(np.linalg.norm([solved.error for solved in groups])),
            max(solved.backward_error for solved in groups),
            sum(solved.iterations for solved in groups),
            groups[-1].method,
        )

    def _solve_three(
        self, b: Floats, x: Floats | None, tolerance: float, reference: float | None, progress: Progress
    ) -> Solution:
        if self._factors is not None or (self._solved and self._many):
            return self.by_factors(b, progress)
        before = 0
        # The error of the smoothest vector is larger than its residual by one over the least eigenvalue.
        spread = float(np.sqrt(self._system.smoothness))
        if np.log(2.0 / tolerance) / np.sqrt(2.0) / spread <= _FEW_STEPS:
            attempt, converged, _ = self._descend(b, x, tolerance, reference, None, spread, _JACOBI_STEPS, progress)
            if converged:
                self._solved = True
                return attempt
            x, before = attempt.values, attempt.iterations
        if self._quick and self._system.smoothness >= _SINGULAR:
            self._quick = False  # if factors fail multigrid is next
            with suppress(ConvergenceError):
                return self.by_factors(b, progress)
        if self._multigrid is None:
            self._multigrid = SmoothedAggregation(self._system.matrix, progress=lambda _: progress(0.0))
        attempt, converged, indefinite = self._descend(
            b, x, tolerance, reference, self._multigrid, 1.0, _MULTIGRID_STEPS, progress
        )
        if converged:
            self._solved = True
            return attempt._replace(iterations=before + attempt.iterations)
        stalled = (
            f"conjugate gradients stall at a backward error of {attempt.backward_error:.3g} in a system of {len(b)} equations"
        )
        if indefinite or self._system.smoothness < _SINGULAR:
            raise ConvergenceError(f"{stalled}: the matrix is not positive definite to rounding")
        progress(0.0)
        try:
            return self.by_factors(b, progress)
        except ConvergenceError as error:
            raise ConvergenceError(f"{stalled}, and {error}") from error

    def by_factors(self, b: Floats, progress: Progress = ignore_progress) -> Solution:
        """The solution for (n, k) right-hand sides by factors and one step of refinement; the factors are kept if they solve it.

        Raises:
            ConvergenceError: not positive definite to rounding, too large, or so near to singular that factors are worth nothing.
        """
        matrix = self._system.matrix
        if len(b) > _LARGEST_FACTORS:
            raise ConvergenceError(f"{len(b)} rows are more than the {_LARGEST_FACTORS} that can be factorised")
        factors = self._factors or Cholesky(matrix, progress=progress)
        x = factors.solve(b)
        x += factors.solve(b - matrix @ x)
        backward = self._system.backward_error(x, b)
        if not backward <= _DIRECT_ROUNDING:
            raise ConvergenceError(f"Cholesky's factors solve {len(b)} equations with a backward error of {backward:.3g} only")
        self._factors = factors
        return Solution(x, 0.0, backward, 2, "cholesky")

    def _descend(
        self,
        b: Floats,
        x: Floats | None,
        tolerance: float,
        reference: float | None,
        precondition: Preconditioner | None,
        spread: float,
        steps: int,
        progress: Progress,
    ) -> tuple[Solution, bool, bool]:
        """Conjugate gradients, restarted where the residual of the recurrence has drifted too far from the true one.

        Returns what they gave, whether they have converged, and whether the matrix turned out to be indefinite.
        """
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
                method: Method = "jacobi" if precondition is None else "multigrid"
                return Solution(x, norm / spread, backward, taken, method), converged, descent.indefinite


def _padded(columns: Floats) -> Floats:
    """(n, 3): up to three columns, then columns of zeros."""
    return np.ascontiguousarray(np.pad(columns, ((0, 0), (0, 3 - columns.shape[1]))) if columns.shape[1] < 3 else columns)


class SpdSystem(NamedTuple):
    """The left-hand side of A x = b."""

    matrix: sparse.csr_matrix  # A, (n, n) with sorted indices, finite, with a positive diagonal
    scale: Floats  # (n,) 1 / sqrt(A_ii); D = diag(scale) makes D A D the matrix of unit diagonal
    norm: float  # the largest row sum of |D A D|, a bound of its largest eigenvalue
    # the Rayleigh quotient 1^T A 1 / 1^T diag(A) 1, an upper bound of the smallest eigenvalue of D A D; near it for a Laplace
    # operator plus a mass, whose smoothest vector is the constant one
    smoothness: float

    @classmethod
    def of(cls, matrix: sparse.csr_matrix) -> SpdSystem:
        """Measures A, which is kept, not copied; its symmetry is not checked.

        Raises:
            FilterInputError: A is not square, not finite, or has a diagonal entry that is not positive.
        """
        csr = sparse.csr_matrix(matrix)
        if csr.shape[0] != csr.shape[1]:
            raise FilterInputError(f"the matrix of a system must be square, got {csr.shape}")
        csr.sort_indices()
        diagonal = csr.diagonal()
        bad = np.flatnonzero(~(diagonal > 0.0))
        if len(bad) or not np.isfinite(csr.data).all():
            what = f"diagonal entry {bad[0]} is {diagonal[bad[0]]}" if len(bad) else "an entry is not finite"
            raise FilterInputError(f"the matrix of a system must be positive definite, but {what}; leave such unknowns out")
        scale = 1.0 / np.sqrt(diagonal)
        sizes = sparse.csr_matrix((np.abs(csr.data), csr.indices, csr.indptr), shape=csr.shape)
        norm = float((scale * (sizes @ scale)).max(initial=0.0))
        total = float(diagonal.sum())
        smoothness = float((csr @ np.ones(len(scale))).sum()) / total if total > 0.0 else 1.0
        return cls(csr, scale, norm, max(smoothness, np.finfo(float).tiny))

    def columns(self, right_side: Floats) -> Floats:
        """The right-hand side as (n, k), C-contiguous.

        Raises:
            FilterInputError: it has another number of rows, or is not finite.
        """
        n = self.matrix.shape[0]
        b = np.asarray(right_side, dtype=np.float64)
        if b.ndim not in (1, 2) or len(b) != n or not np.isfinite(b).all():
            raise FilterInputError(f"a system of {n} equations takes a finite right-hand side of {n} rows, got shape {b.shape}")
        return np.ascontiguousarray(b[:, None] if b.ndim == 1 else b)

    def backward_error(self, x: Floats, b: Floats) -> float:
        """|D r| / (|D A D| |x / D| + |D b|) for r = b - A x, of (n, k) columns together; 0 if x and b are."""
        scale = self.scale[:, None]
        size = self.norm * np.linalg.norm(x / scale) + np.linalg.norm(scale * b)
        return float(np.linalg.norm(scale * (b - self.matrix @ x)) / size) if size > 0.0 else 0.0


class Solution(NamedTuple):
    """The solution of A x = b, its errors and its method."""

    values: Floats  # x, of the shape of b
    error: float  # an estimate of the energy norm sqrt(e^T A e) of the error e, over all columns; not estimated, 0, by "cholesky"
    # |r| / (|A| |x| + |b|) for r = b - A x, after scaling A to unit diagonal so that large rows hide nothing: x solves exactly a
    # system that differs by this share. The largest over the groups of columns solved for together.
    backward_error: float
    iterations: int  # products with the matrix
    method: Method  # what gave x

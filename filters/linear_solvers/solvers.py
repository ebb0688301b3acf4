"""Sparse symmetric positive definite systems with a few right-hand sides: `solve_spd` for one, `SpdSolver` for several in a
row with one matrix, `Factorisation` for many or for exactness, `refined_solution` for powers of Laplace operators, whose
conditioning leaves few digits to any other.

Three methods, and what (M - t C) x = b costs with each: seconds of one thread to set up + to solve for three right-hand sides
to an error of 1e-11 of the diagonal, on a bunny of 100,000 vertices with noise of 0.15 edges, t = (c mean edges)^2.

=== ================= ================ ===========
c   jacobi            multigrid        cholesky
=== ================= ================ ===========
1   0 + 0.23 (112)    0.11 + 0.30 (24) 1.0 + 0.019
2   0 + 0.33 (158)    0.10 + 0.30 (27) 1.0 + 0.019
3   0 + 0.47 (201)    0.11 + 0.34 (29) 1.0 + 0.019
10  0 + 0.99 (542)    0.09 + 0.39 (33) 1.0 + 0.019
1e4 does not end      0.10 + 0.51 (44) 1.0 + 0.019
=== ================= ================ ===========

In brackets the iterations. Hence: the diagonal as preconditioner where the matrix is close to it (c up to 2), else multigrid,
whose cost depends neither on t nor, per row, on size; Cholesky's factors for repeated solves of systems of moderate size, and as
the last resort. At 1,000,000 vertices the factors take 16 s and 0.9 GB.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from scipy import sparse

from ..checks import ConvergenceError
from ..execution import Progress, ignore_progress
from ..mesh import Floats
from .cholesky import Cholesky
from .conjugate_gradients import Preconditioner, conjugate_gradients, preconditioned_norm
from .smoothed_aggregation import SmoothedAggregation
from .spd_system import SpdSystem
from .superlu import SuperLU

Method: TypeAlias = Literal["jacobi", "multigrid", "cholesky"]
DirectMethod: TypeAlias = Literal["superlu", "cholesky"]

#: No solution is asked to be more exact than this, relative to its own energy norm: rounding would not allow it.
FINEST = 1e-12
# A backward error of this size is rounding; a direct solution must reach the second, which leaves room for ill-posed systems.
_ROUNDING, _DIRECT_ROUNDING = 1e-14, 1e-12
# A matrix whose smoothest vector has a Rayleigh quotient below this has no factors.
_SINGULAR = 1e-13
# Predicted steps up to which the diagonal is the better preconditioner, and the steps after which multigrid takes over.
_FEW_STEPS, _JACOBI_STEPS = 100, 250
_MULTIGRID_STEPS = 300
# Cholesky's factors pay from this many solves on, up to the size that they take a second for.
_MANY_SOLVES, _QUICK_FACTORS = 4, 100_000
# Beyond this size the factors outgrow their 32-bit indices and the memory of most machines.
_LARGEST_FACTORS = 3_000_000


@dataclass(frozen=True, eq=False)
class Solution:
    """The solution of A x = b and how good it is.

    Attributes:
        values: x, of the shape of b.
        error: an estimate of the energy norm sqrt(e^T A e) of the error e, over all columns; not estimated, 0, by "cholesky".
        backward_error: |r| / (|A| |x| + |b|) for r = b - A x, after scaling A to unit diagonal so that large rows hide nothing: x
            solves exactly a system that differs by this share. The largest over the groups of columns solved for together.
        iterations: products with the matrix.
        method: what gave x.
    """

    values: Floats
    error: float
    backward_error: float
    iterations: int
    method: Method


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
                below `FINEST` of the latter is not asked for.
            start: a first guess, of the shape of b.
            progress: called every few steps; may raise to stop.

        Raises:
            FilterInputError: b has another number of rows, or is not finite.
            ConvergenceError: all methods stall; the message gives the backward errors they reached.
        """
        b = self._system.columns(right_side)
        guess = np.zeros_like(b) if start is None else self._system.columns(start)
        groups = []
        for first in range(0, b.shape[1], 3):

            def partial(share: float, before: int = first) -> None:
                progress(min(1.0, (before + 3.0 * share) / b.shape[1]))

            group = slice(first, first + 3)
            groups.append(self._solve_three(_padded(b[:, group]), _padded(guess[:, group]), tolerance, reference, partial))
        if not groups:
            return Solution(np.zeros(np.shape(right_side)), 0.0, 0.0, 0, "jacobi")
        return Solution(
            np.hstack([group.values for group in groups])[:, : b.shape[1]].reshape(np.shape(right_side)),
            float(np.linalg.norm([group.error for group in groups])),
            max(group.backward_error for group in groups),
            sum(group.iterations for group in groups),
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
    ) -> "_Attempt":
        """Conjugate gradients, begun again where the residual they carry along has drifted too far from the true one."""
        matrix = self._system.matrix
        own = preconditioned_norm(matrix, b, precondition)
        target = max(tolerance * (own if reference is None else reference * spread), FINEST * own)
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


def solve_spd(
    matrix: sparse.csr_matrix,
    right_side: Floats,
    *,
    tolerance: float = 1e-10,
    reference: float | None = None,
    start: Floats | None = None,
    progress: Progress = ignore_progress,
) -> Solution:
    """Solves one system A x = b for (n,) or (n, k) right-hand sides; see `SpdSolver` for parameters and errors."""
    solver = SpdSolver(matrix)
    return solver.solve(right_side, tolerance=tolerance, reference=reference, start=start, progress=progress)


@dataclass(frozen=True, eq=False)
class RefinedSolution:
    """The solution of an ill-conditioned system.

    Attributes:
        values: x, (n, k).
        backward_error: |r| / (|A| |x| + |b|) after scaling A to unit diagonal.
        last_correction: the largest entry of the last correction, in the unit of x: more than the error that is left.
        refinements: the corrections after the first solution.
    """

    values: Floats
    backward_error: float
    last_correction: float
    refinements: int


# Corrections are made until the next would be below this share of the solution's extent, but no more than so many.
_REFINED, _MOST_REFINEMENTS = 1e-11, 12
# Larger last corrections are no solution.
_UNREFINED = 1e-6


def refined_solution(
    matrix: sparse.csr_matrix,
    residual: Callable[[Floats], Floats],
    start: Floats,
    *,
    extent: float,
    method: DirectMethod | Callable[[Floats], Floats] = "superlu",
    progress: Progress = ignore_progress,
) -> RefinedSolution:
    """Solves A x = b by factors and iterative refinement, b - A x computed by the caller more precisely than A is stored.

    Where A is a product, its rounding alone may cost all digits but a few; with a precise residual each step gains those few, and
    the solution is that of the exact product [higham2002].

    Args:
        matrix: A, (n, n) symmetric positive definite to rounding.
        residual: b - A x of (n, k) values x, with more digits than the condition number of A takes.
        start: (n, k) a first guess.
        extent: the length against which errors in x count.
        method: what factorises; or what solves A x = r to a few digits for (n, k) residuals.
        progress: called meanwhile; may raise to stop.

    Raises:
        FilterInputError: A is not finite or has a diagonal entry that is not positive.
        ConvergenceError: A is singular to rounding, or the corrections do not shrink.
    """
    system = SpdSystem.of(matrix)
    scale = system.scale[:, None]
    solve = method if callable(method) else _scaled_factors(system, method, progress)
    x = np.array(start, dtype=np.float64)
    before, steps = np.inf, 0
    while True:
        correction = solve(residual(x))
        x += correction
        moved = float(np.abs(correction).max(initial=0.0))
        progress(0.9 + 0.1 * steps / (steps + 1))
        if moved == 0.0 or (steps > 0 and moved * (moved / before) <= _REFINED * extent):
            break
        if steps == _MOST_REFINEMENTS or (steps > 1 and not moved < 0.5 * before):
            break
        before, steps = moved, steps + 1
    if not moved <= _UNREFINED * extent:
        raise ConvergenceError(f"refinement of {len(x)} equations stalls at corrections of {moved / extent:.3g} of the extent")
    left_over = residual(x)
    size = system.norm * _length(x / scale) + _length(scale * (left_over + system.matrix @ x))
    backward = _length(scale * left_over) / size if size > 0.0 else 0.0
    return RefinedSolution(x, backward, moved, steps)


def _scaled_factors(system: SpdSystem, method: DirectMethod, progress: Progress) -> Callable[[Floats], Floats]:
    """Solves A x = r by the factors of A scaled to unit diagonal."""
    matrix, scale = system.matrix, system.scale
    data = matrix.data * np.repeat(scale, np.diff(matrix.indptr)) * scale[matrix.indices]
    scaled = sparse.csr_matrix((data, matrix.indices, matrix.indptr), shape=matrix.shape)
    factors = SuperLU(scaled, progress=progress, done=0.1) if method == "superlu" else Cholesky(scaled)
    return lambda right_side: scale[:, None] * factors.solve(scale[:, None] * right_side)


def _length(values: Floats) -> float:
    """The norm, by numpy's own sum: that of the library behind `norm` depends on its threads and waits for them."""
    return math.sqrt(float(np.square(values).sum()))


def _padded(columns: Floats) -> Floats:
    """Up to three columns as three, those that are added 0."""
    if columns.shape[1] == 3:
        return np.ascontiguousarray(columns)
    return np.ascontiguousarray(np.pad(columns, ((0, 0), (0, 3 - columns.shape[1]))))

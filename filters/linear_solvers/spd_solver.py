"""Solvers of sparse symmetric positive definite systems: Jacobi, multigrid, Cholesky, refinement; docs/solvers.md has the times.

If few steps are predicted, the diagonal is the preconditioner of conjugate gradients. Otherwise factors solve small systems,
and multigrid preconditions large ones: its cost per row depends neither on the row count nor on a time step. If multigrid fails,
factors are tried. Ill-conditioned powers of Laplace operators need refinement with residuals in twice the precision.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ..checks import ConvergenceError, FilterInputError
from ..compilation import compiled, prange
from ..execution import Progress, abandonable, ignore_progress, part_of, threads_for
from ..libraries import sparse
from ..mesh import Floats
from .conjugate_gradients import CompressedRows, Preconditioner, SmoothedAggregation, conjugate_gradients, preconditioned_norm
from .fronts import Fronts

#: The most shifts to try.
_ATTEMPTS = 4
#: Factors with a backward error of at most `_GOOD` are taken at once, else those with the least error, if it is at most `_ROUGH`.
#: The count of eigenvalues below a shift is right if all eigenvalues differ from the shift by more than the backward error times
#: the largest eigenvalue. The eigensolver refines the modes, so rough factors suffice for modes.
_GOOD, _ROUGH = 1e-12, 1e-9
# From this many rows on, `Cholesky` factorises on a thread of its own, which can be abandoned.
_QUICK = 20_000
#: Refinement ends when the next correction is predicted to be below `_REFINED` times the extent of the solution, when a
#: correction after the second is not below half of the previous one, or after `_MOST_REFINEMENTS` steps.
_REFINED, _MOST_REFINEMENTS = 1e-11, 12
#: Refinement has failed if its last correction is above this share of the extent.
_UNREFINED = 1e-6
# Veltkamp's constant 2^27 + 1 splits a double into two halves whose products are exact.
_SPLITTER = 134217729.0


class Cholesky:
    """The factors L D L^T of a symmetric positive definite matrix."""

    def __init__(self, matrix: sparse.csr_matrix, *, progress: Progress = ignore_progress, done: float = 0.0) -> None:
        """Factorises the matrix, calls progress(done) meanwhile; raises `ConvergenceError` if it is not positive definite."""
        csr = sparse.csr_matrix(matrix)
        if not (csr.diagonal() > 0.0).all():
            raise ConvergenceError("the matrix is not positive definite: it has a diagonal entry that is not positive")
        self._fronts = Fronts.of(csr)
        work = partial(self._fronts.factors, csr)
        self._values, pivots = work() if csr.shape[0] < _QUICK else abandonable(work, progress, done)
        if not ((pivots > 0.0) & (pivots < np.inf)).all():
            raise ConvergenceError(f"the matrix of {csr.shape[0]} rows is not positive definite to rounding")

    def solve(self, right_side: Floats) -> Floats:
        return self._fronts.solve(self._values, right_side)


class ShiftedFactors:
    """The factors L D L^T of A - shift I for a symmetric A, without row exchanges, so that D is diagonal.

    By Sylvester's law of inertia D has as many negative entries, `below`, as A has eigenvalues below the shift.
    A pivot close to 0 would make the number `below` unreliable; then the `shift` is moved a little.
    """

    def __init__(self, matrix: sparse.csc_matrix, fronts: Fronts, shift: float, progress: Progress, done: float) -> None:
        """Factorises a symmetric (n, n) matrix with the `fronts` of its pattern; fails if no nearby shift has stable factors."""
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
        """Returns (A - shift I)^-1 times (n, b) columns; the result is Fortran-ordered."""
        return self._fronts.solve(self._values, np.asfortranarray(right_side))


#: The smallest tolerance, relative to the energy norm of the solution: rounding prevents smaller errors.
FINEST_TOLERANCE = 1e-12
#: A backward error of at most this size is due to rounding.
_ROUNDING = 1e-14
#: A matrix with a `SpdSystem.smoothness` below this is singular to rounding: `solve` does not factorise it.
_SINGULAR = 1e-13
#: If at most `_FEW_STEPS` steps are predicted, the diagonal is tried as preconditioner, for at most `_JACOBI_STEPS` steps.
_FEW_STEPS, _JACOBI_STEPS = 100, 250
_MULTIGRID_STEPS = 300
#: If the diagonal is a poor preconditioner, factors beat multigrid up to this many rows: for one solve, and for several.
_FACTORS_FOR_ONE, _FACTORS_FOR_MORE = 50_000, 150_000
#: If the diagonal is a good preconditioner, factors pay from this many solves on.
_MANY_SOLVES = 4
Method: TypeAlias = Literal["jacobi", "multigrid", "cholesky"]
#: A direct solution must reach this backward error, which leaves room for ill-conditioned systems.
_DIRECT_ROUNDING = 1e-12
#: Beyond this number of rows the factors outgrow the memory of most machines.
_LARGEST_FACTORS = 3_000_000


class SpdSolver:
    """Solves systems with one matrix; multigrid and factors are kept for the next right-hand side."""

    def __init__(self, matrix: sparse.csr_matrix, *, solves: int = 1) -> None:
        """Takes a symmetric positive definite A, or a semidefinite A for right-hand sides in its range; A is not copied.

        `solves` is the number of solves to come. It decides whether factors pay.
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
            reference: the energy norm sqrt(x^T A x) of which the tolerance is a share; None for the norm of each group's
                solution. An error of `FINEST_TOLERANCE` of the solution always suffices.
            start: a first guess, of the shape of b.
            progress: called every few steps; may raise to stop.

        Raises:
            FilterInputError: `right_side` or `start` has another number of rows, or is not finite.
            ConvergenceError: neither conjugate gradients nor factors solve it, or A is not positive definite to rounding.
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
        if self._factors is not None or (self._solved and self._many and self._system.smoothness >= _SINGULAR):
            return self.by_factors(b, progress)
        earlier_steps = 0
        # The error that falls slowest is the lowest eigenvector of D A D: its energy norm is the norm of its residual / spread.
        spread = float(np.sqrt(self._system.smoothness))
        if np.log(2.0 / tolerance) / np.sqrt(2.0) / spread <= _FEW_STEPS:
            attempt, converged, _ = self._descend(b, x, tolerance, reference, None, spread, _JACOBI_STEPS, progress)
            if converged:
                self._solved = True
                return attempt
            x, earlier_steps = attempt.values, attempt.iterations
        if self._quick and self._system.smoothness >= _SINGULAR:
            self._quick = False
            with suppress(ConvergenceError):
                return self.by_factors(b, progress)
        if self._multigrid is None:
            self._multigrid = SmoothedAggregation(self._system.matrix, progress=lambda _: progress(0.0))
        attempt, converged, indefinite = self._descend(
            b, x, tolerance, reference, self._multigrid, 1.0, _MULTIGRID_STEPS, progress
        )
        if converged:
            self._solved = True
            return attempt._replace(iterations=earlier_steps + attempt.iterations)
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
        """Solves for (n, k) right-hand sides by factors and one step of refinement; keeps factors that are exact enough."""
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
        """Runs conjugate gradients, restarted if the residual drifts: (result, whether it converged, whether A is indefinite)."""
        matrix = self._system.matrix
        size = preconditioned_norm(matrix, b, precondition)
        target = max(tolerance * (size if reference is None else reference * spread), FINEST_TOLERANCE * size)
        iterations = 0
        while True:
            descent = conjugate_gradients(
                matrix, b, target=target, max_iterations=steps - iterations, start=x, precondition=precondition, progress=progress
            )
            x, iterations = descent.values, iterations + descent.iterations
            norm = preconditioned_norm(matrix, b - matrix @ x, precondition)
            backward = self._system.backward_error(x, b)
            converged = norm <= 2.0 * target or (descent.norm <= target and backward <= _ROUNDING)
            if converged or descent.norm > target or descent.iterations == 0:
                method: Method = "jacobi" if precondition is None else "multigrid"
                return Solution(x, norm / spread, backward, iterations, method), converged, descent.indefinite


def _padded(columns: Floats) -> Floats:
    return np.ascontiguousarray(np.pad(columns, ((0, 0), (0, 3 - columns.shape[1]))) if columns.shape[1] < 3 else columns)


class SpdSystem(NamedTuple):
    """The left-hand side of A x = b."""

    matrix: sparse.csr_matrix  # A, (n, n) with sorted indices, finite, with a positive diagonal
    scale: Floats  # (n,) 1 / sqrt(A_ii); D = diag(scale) makes D A D the matrix of unit diagonal
    norm: float  # the largest row sum of |D A D|, an upper bound of the largest eigenvalue of D A D
    # the Rayleigh quotient 1^T A 1 / 1^T diag(A) 1, an upper bound of the smallest eigenvalue of D A D; a close bound for a
    # Laplace operator plus a mass: the first eigenvector of the operator is constant
    smoothness: float

    @classmethod
    def of(cls, matrix: sparse.csr_matrix) -> SpdSystem:
        """Measures A, without a copy; refuses a matrix that is not square, not finite, or without a positive diagonal."""
        csr = sparse.csr_matrix(matrix)
        if csr.shape[0] != csr.shape[1]:
            raise FilterInputError(f"the matrix of a system must be square, got {csr.shape}")
        csr.sort_indices()
        diagonal = csr.diagonal()
        bad = np.flatnonzero(~(diagonal > 0.0))
        if len(bad) or not np.isfinite(csr.data).all():
            problem = f"diagonal entry {bad[0]} is {diagonal[bad[0]]}" if len(bad) else "an entry is not finite"
            raise FilterInputError(f"the matrix of a system must be positive definite, but {problem}; leave such unknowns out")
        scale = 1.0 / np.sqrt(diagonal)
        sizes = sparse.csr_matrix((np.abs(csr.data), csr.indices, csr.indptr), shape=csr.shape)
        norm = float((scale * (sizes @ scale)).max(initial=0.0))
        total = float(diagonal.sum())
        smoothness = float((csr @ np.ones(len(scale))).sum()) / total if total > 0.0 else 1.0
        return cls(csr, scale, norm, max(smoothness, np.finfo(float).tiny))

    def columns(self, right_side: Floats) -> Floats:
        """Returns the right-hand side as (n, k), C-contiguous; refuses another number of rows, and values that are not finite."""
        n = self.matrix.shape[0]
        b = np.asarray(right_side, dtype=np.float64)
        if b.ndim not in (1, 2) or len(b) != n or not np.isfinite(b).all():
            raise FilterInputError(f"a system of {n} equations takes a finite right-hand side of {n} rows, got shape {b.shape}")
        return np.ascontiguousarray(b[:, None] if b.ndim == 1 else b)

    def backward_error(self, x: Floats, b: Floats) -> float:
        """Returns |D r| / (|D A D| |x / D| + |D b|), r = b - A x, over all (n, k) columns together; 0 if x and b are 0.

        D keeps large rows from hiding errors in small rows.
        """
        scale = self.scale[:, None]
        size = self.norm * np.linalg.norm(x / scale) + np.linalg.norm(scale * b)
        return float(np.linalg.norm(scale * (b - self.matrix @ x)) / size) if size > 0.0 else 0.0


class Solution(NamedTuple):
    """The solution of A x = b."""

    values: Floats  # x, of the shape of b
    error: float  # an estimate of the energy norm sqrt(e^T A e) of the error e, over all columns; "cholesky" has no estimate: 0
    # the largest `SpdSystem.backward_error` of the groups of columns: x exactly solves a system that differs by this share
    backward_error: float
    iterations: int  # number of steps of conjugate gradients in all groups of columns; "cholesky": 2 for each group
    method: Method


class RefinedSolution(NamedTuple):
    """The result of `refined_solution`."""

    values: Floats  # x, (n, k)
    backward_error: float  # see `SpdSystem.backward_error`
    last_correction: float  # the largest entry of the last correction, in the unit of x; usually larger than the error left
    refinements: int  # the number of corrections after the first solution


def refined_solution(
    matrix: sparse.csr_matrix,
    residual: Callable[[Floats], Floats],
    start: Floats,
    *,
    extent: float,
    first: Floats | None = None,
    solve: Callable[[Floats], Floats] | None = None,
    progress: Progress = ignore_progress,
) -> RefinedSolution:
    """Solves A x = b by factors and iterative refinement; the caller computes b - A x more precisely than A is stored.

    If A is a product, rounding of its entries may leave only a few correct digits of x. With a precise residual each step adds
    this number of digits, and the result solves the system of the exact product [higham2002].

    Args:
        matrix: A, (n, n) symmetric positive definite to rounding.
        residual: computes b - A x of (n, k) values x, with more digits than the condition number of A costs.
        start: (n, k) a first guess.
        extent: the length that errors in x are compared with.
        first: (n, k) b - A x of the first guess, if ordinary precision is enough; None: `residual` computes it.
        solve: solves A x = r to a few digits for (n, k) residuals; None to solve by factors.
        progress: called between the steps; may raise to stop.

    Raises:
        FilterInputError: A is not finite or has a diagonal entry that is not positive.
        ConvergenceError: A is singular to rounding, or the corrections do not shrink.
    """
    system = SpdSystem.of(matrix)
    solve = solve or Cholesky(system.matrix, progress=progress, done=0.1).solve
    x = np.asarray(start, dtype=np.float64)
    del start  # else the first guess would stay in memory until the end
    before, steps = np.inf, 0
    while True:
        r = first if steps == 0 and first is not None else residual(x)
        correction = solve(r)
        previous, x = x, x + correction
        moved = float(np.abs(correction).max(initial=0.0))
        progress(0.9 + 0.1 * steps / (steps + 1))
        if moved == 0.0 or (steps > 0 and moved * (moved / before) <= _REFINED * extent):
            break
        if steps == _MOST_REFINEMENTS or (steps > 1 and not moved < 0.5 * before):
            break
        before, steps = moved, steps + 1
    if not moved <= _UNREFINED * extent:
        raise ConvergenceError(f"refinement of {len(x)} equations stalls at corrections of {moved / extent:.3g} of the extent")
    # The last step is so short that rounding in its product with A is negligible.
    last_residual = r - system.matrix @ (x - previous)
    scale = np.repeat(system.scale, x.shape[1]).reshape(x.shape)
    size = system.norm * _length(x / scale) + _length(scale * (last_residual + system.matrix @ x))
    return RefinedSolution(x, _length(scale * last_residual) / size if size > 0.0 else 0.0, moved, steps)


def _length(values: Floats) -> float:
    """The Euclidean norm by NumPy's sum: NumPy's `norm` uses a BLAS whose result and time depend on the number of threads."""
    return math.sqrt(float(np.square(values).sum()))


def laplacian_power(
    matrix: sparse.csr_matrix, inverse_mass: Floats, order: int, values: Floats, more: Floats | None = None
) -> Floats:
    """Computes (S M^-1)^(order - 1) S x with about 32 digits and rounds the result once.

    Every row of S is taken to sum to 0 exactly; its diagonal is not read. Each application of S loses digits in the differences
    between neighbours: at order 3 and 100,000 vertices nearly all of the 16 digits of ordinary precision.
    Sums and products keep their rounding errors as a second double [dekker1971].

    Args:
        matrix: S, (n, n) symmetric; S or -S is semidefinite.
        inverse_mass: (n,) the diagonal of M^-1.
        order: the power, at least 1.
        values: x, (n, 3).
        more: (n, 3) added to x without rounding; None for 0.
    """
    high, low = np.ascontiguousarray(values), np.zeros(values.shape) if more is None else np.ascontiguousarray(more)
    rows = CompressedRows(matrix.indptr.astype(np.int64), matrix.indices.astype(np.int32), matrix.data)
    with threads_for(len(values)):
        for step in range(order):
            high_product, low_product = np.empty(values.shape), np.empty(values.shape)
            factors = inverse_mass if step < order - 1 else np.ones(len(values))
            _apply(rows, factors, high, low, high_product, low_product)
            high, low = high_product, low_product
    return high


@compiled
def _two_sum(a: float, b: float) -> tuple[float, float]:
    s = a + b
    t = s - a
    return s, (a - (s - t)) + (b - t)


@compiled
def _two_product(a: float, b: float) -> tuple[float, float]:
    p = a * b
    t = _SPLITTER * a
    a_high = t - (t - a)
    a_low = a - a_high
    t = _SPLITTER * b
    b_high = t - (t - b)
    b_low = b - b_high
    return p, ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low


@compiled
def _added(
    total: float, rest: float, factor: float, high: float, low: float, from_high: float, from_low: float
) -> tuple[float, float]:
    """Adds factor (high + low - from_high - from_low) to the sum total + rest; returns the new total and rest."""
    difference, error = _two_sum(high, -from_high)
    more, rest_of_more = _two_sum(low, -from_low)
    difference, lost = _two_sum(difference, more)
    difference, error = _two_sum(difference, error + lost + rest_of_more)
    product, lost = _two_product(factor, difference)
    lost += factor * error
    total, carried = _two_sum(total, product)
    return total, rest + (carried + lost)


@compiled
def _scaled(total: float, rest: float, factor: float) -> tuple[float, float]:
    total, rest = _two_sum(total, rest)
    product, lost = _two_product(factor, total)
    return _two_sum(product, lost + factor * rest)


@compiled(parallel=True)
def _apply(matrix: CompressedRows, factors: Floats, high: Floats, low: Floats, out_high: Floats, out_low: Floats) -> None:
    """Computes out_i = factors_i sum_j S_ij (x_j - x_i); x and out are sums of a high and a low double."""
    indptr, indices, data = matrix
    for i in prange(indptr.shape[0] - 1):
        x, y, z, p, q, r = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if j != i:
                x, p = _added(x, p, data[k], high[j, 0], low[j, 0], high[i, 0], low[i, 0])
                y, q = _added(y, q, data[k], high[j, 1], low[j, 1], high[i, 1], low[i, 1])
                z, r = _added(z, r, data[k], high[j, 2], low[j, 2], high[i, 2], low[i, 2])
        out_high[i, 0], out_low[i, 0] = _scaled(x, p, factors[i])
        out_high[i, 1], out_low[i, 1] = _scaled(y, q, factors[i])
        out_high[i, 2], out_low[i, 2] = _scaled(z, r, factors[i])

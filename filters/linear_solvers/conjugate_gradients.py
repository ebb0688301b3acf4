"""Conjugate gradients for three right-hand sides at once, and a multigrid preconditioner.

Algebraic multigrid by smoothed aggregation suits elliptic matrices of any size: every level groups strongly connected unknowns
into aggregates of about eight, and each aggregate is one unknown of the next level [vanek1996]. SciPy's and PyAMG's solvers are
not used because they take one right-hand side on one thread; docs/solvers.md compares the times.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from ..compilation import compiled, prange
from ..execution import Progress, ignore_progress, threads_for
from ..libraries import sparse
from ..mesh import Floats, Index, Ints

#: Maps a residual (n, 3) to an approximate solution (n, 3): a symmetric positive definite approximation of the inverse.
Preconditioner: TypeAlias = Callable[[Floats], Floats]
#: Steps between two reports of the progress.
_STEPS = 5
#: Rows in a block. Smaller blocks are shared more evenly among threads, larger ones cost less.
_BLOCK = 4096
#: The least -a_ij / sqrt(a_ii a_jj) of strongly connected unknowns i and j on the finest level; halved from level to level.
STRENGTH = 0.08
#: A level of at most this many unknowns is factorised, which takes a few milliseconds.
COARSEST = 1000
#: Coarsening stops if a level would keep more than this share of the unknowns of the finer level.
_MOST_KEPT = 0.8
#: Two terms are added to the coarsest diagonal d: `_SHIFT` d, far below all eigenvalues but that of the constant vector; and
#: `_NOISE` times the finest diagonal, restricted to the coarsest level, above the rounding errors of cancelling sums.
_SHIFT, _NOISE = 1e-8, 2.0**-46
#: The largest number of runs in a level, and the smallest number of rows in a run, a range of rows that one thread sweeps alone.
_RUNS, _SHORTEST_RUN = 64, 2048


class CompressedRows(NamedTuple):
    """A sparse matrix for kernels: row i has the entries data[k] in the columns indices[k], indptr[i] <= k < indptr[i + 1]."""

    indptr: Ints
    indices: Ints
    data: Floats

    @classmethod
    def of(cls, matrix: sparse.csr_matrix) -> CompressedRows:
        return cls(matrix.indptr, matrix.indices, matrix.data)


class Descent(NamedTuple):
    """The result of conjugate gradients."""

    values: Floats  # (n, 3) the approximate solution
    norm: float  # estimated error in the energy norm: sqrt(sum of r^T B r over the columns), r the residual, B the preconditioner
    iterations: int  # the number of completed iterations, each with one product with the matrix
    indefinite: bool  # whether a direction p with p^T A p < 0 ended the iterations: A is not positive semidefinite


def conjugate_gradients(
    matrix: sparse.csr_matrix,
    right_side: Floats,
    *,
    target: float,
    max_iterations: int,
    start: Floats | None = None,
    precondition: Preconditioner | None = None,
    progress: Progress = ignore_progress,
) -> Descent:
    """Solves A x = b for symmetric positive definite A by preconditioned conjugate gradients [hestenes1952].

    A may be positive semidefinite if b lies in its range. The iterations also end if A turns out not to be semidefinite.

    Args:
        matrix: A, (n, n), with a positive diagonal.
        right_side: b, (n, 3). Without `start`, a column of zeros adds no iterations; its solution is 0.
        target: the norm of `Descent` at which the iterations end. A larger target ends them sooner.
        max_iterations: the largest number of iterations.
        start: (n, 3) a first guess; 0 if None.
        precondition: B; None divides by the diagonal (Jacobi).
        progress: called at every iteration, without a preconditioner at every fifth; may raise to stop.
    """
    rows = CompressedRows.of(matrix)
    residual = np.array(right_side, order="C")
    x = np.zeros_like(residual) if start is None else np.array(start, order="C")
    product = np.empty_like(residual)
    scale = 1.0 / matrix.diagonal() if precondition is None else np.ones(len(x))
    with threads_for(len(x)):
        if start is not None:
            _multiply(rows, x, product)
            residual -= product
        if precondition is None:
            direction = residual * scale[:, None]
            energy = _descend(np.zeros(3), residual, residual, x, residual, scale).sum(axis=0)
        else:
            direction = precondition(residual).copy()  # because a preconditioner may return the same array again
            energy = _inner_products(residual, direction).sum(axis=0)
        first = norm = _root(energy)
        iterations, indefinite = 0, False
        while norm > target and iterations < max_iterations and not indefinite:
            is_within = 0.0 < target < norm <= first < np.inf
            progress(float(np.log(first / norm) / np.log(first / target)) if is_within else 0.0)
            if precondition is None:
                most = min(_STEPS, max_iterations - iterations)
                steps, indefinite = _jacobi_steps(rows, direction, product, x, residual, scale, energy, target, most)
                iterations += steps
            else:
                before = energy.copy()
                indefinite = not _step(rows, direction, product, x, residual, scale, energy)
                if not indefinite:
                    z = precondition(residual)
                    energy = _inner_products(residual, z).sum(axis=0)
                    _next_direction(_quotients(energy, before), z, scale, direction)
                    del z  # frees (n, 3) numbers before the next z is made
                    iterations += 1
            norm = _root(energy)
    return Descent(x, norm, iterations, indefinite)


def preconditioned_norm(matrix: sparse.csr_matrix, residual: Floats, precondition: Preconditioner | None = None) -> float:
    """The norm of `Descent` for an (n, 3) residual r: sqrt(sum of r^T B r over the columns), B as in `conjugate_gradients`."""
    with threads_for(len(residual)):
        z = residual / matrix.diagonal()[:, None] if precondition is None else precondition(residual)
        return _root(_inner_products(residual, z).sum(axis=0))


@compiled
def _jacobi_steps(
    matrix: CompressedRows, p: Floats, q: Floats, x: Floats, r: Floats, scale: Floats, energy: Floats, target: float, most: int
) -> tuple[int, bool]:
    """Takes up to `most` steps with the preconditioner diag(scale); returns their number, and whether A is not semidefinite."""
    for step in range(most):
        before = energy.copy()
        if not _step(matrix, p, q, x, r, scale, energy):
            return step, True
        _next_direction(_quotients(energy, before), r, scale, p)
        if not _root(energy) > target:
            return step + 1, False
    return most, False


@compiled
def _step(matrix: CompressedRows, p: Floats, q: Floats, x: Floats, r: Floats, scale: Floats, energy: Floats) -> bool:
    """Moves x along p to the least error, sets `energy` to r^T diag(scale) r of each column; returns False if p^T A p < 0."""
    curvature = _total(_multiply(matrix, p, q))
    if not (curvature >= 0.0).all():
        return False
    energy[:] = _total(_descend(_quotients(energy, curvature), p, q, x, r, scale))
    return True


@compiled
def _total(sums: Floats) -> Floats:
    total = np.zeros(3)
    for row in sums:
        total += row
    return total


@compiled
def _root(energy: Floats) -> float:
    """The norm of `Descent` from r^T B r of each column; infinite if one is negative, as B is then not positive definite."""
    return math.sqrt(energy[0] + energy[1] + energy[2]) if (energy >= 0.0).all() else math.inf


@compiled
def _quotients(a: Floats, b: Floats) -> Floats:
    quotients = np.zeros(3)
    for column in range(3):
        if b[column] > 0.0:
            quotients[column] = a[column] / b[column]
    return quotients


@compiled(parallel=True)
def _multiply(matrix: CompressedRows, p: Floats, q: Floats) -> Floats:
    """Computes q = A p in place; returns p^T q of the three columns for each block."""
    n = p.shape[0]
    sums = np.zeros(((n + _BLOCK - 1) // _BLOCK, 3))
    for b in prange(sums.shape[0]):
        s0, s1, s2 = 0.0, 0.0, 0.0
        for i in range(Index(b * _BLOCK), Index(min(n, (b + 1) * _BLOCK))):
            a0, a1, a2 = row_product(matrix, i, p)
            q[i, 0], q[i, 1], q[i, 2] = a0, a1, a2
            s0 += a0 * p[i, 0]
            s1 += a1 * p[i, 1]
            s2 += a2 * p[i, 2]
        sums[b, 0], sums[b, 1], sums[b, 2] = s0, s1, s2
    return sums


@compiled(parallel=True)
def _descend(steps: Floats, p: Floats, q: Floats, x: Floats, r: Floats, scale: Floats) -> Floats:
    """Computes x += steps p and r -= steps q in place; returns r^T diag(scale) r of the three columns for each block."""
    n = p.shape[0]
    t0, t1, t2 = steps[0], steps[1], steps[2]
    sums = np.zeros(((n + _BLOCK - 1) // _BLOCK, 3))
    for b in prange(sums.shape[0]):
        s0, s1, s2 = 0.0, 0.0, 0.0
        for i in range(Index(b * _BLOCK), Index(min(n, (b + 1) * _BLOCK))):
            x[i, 0] += t0 * p[i, 0]
            x[i, 1] += t1 * p[i, 1]
            x[i, 2] += t2 * p[i, 2]
            r0 = r[i, 0] - t0 * q[i, 0]
            r1 = r[i, 1] - t1 * q[i, 1]
            r2 = r[i, 2] - t2 * q[i, 2]
            r[i, 0], r[i, 1], r[i, 2] = r0, r1, r2
            s0 += r0 * r0 * scale[i]
            s1 += r1 * r1 * scale[i]
            s2 += r2 * r2 * scale[i]
        sums[b, 0], sums[b, 1], sums[b, 2] = s0, s1, s2
    return sums


@compiled(parallel=True)
def _next_direction(shares: Floats, z: Floats, scale: Floats, p: Floats) -> None:
    t0, t1, t2 = shares[0], shares[1], shares[2]
    for row in prange(p.shape[0]):
        i = Index(row)
        p[i, 0] = scale[i] * z[i, 0] + t0 * p[i, 0]
        p[i, 1] = scale[i] * z[i, 1] + t1 * p[i, 1]
        p[i, 2] = scale[i] * z[i, 2] + t2 * p[i, 2]


@compiled(parallel=True)
def _inner_products(r: Floats, z: Floats) -> Floats:
    n = r.shape[0]
    sums = np.zeros(((n + _BLOCK - 1) // _BLOCK, 3))
    for b in prange(sums.shape[0]):
        s0, s1, s2 = 0.0, 0.0, 0.0
        for i in range(Index(b * _BLOCK), Index(min(n, (b + 1) * _BLOCK))):
            s0 += r[i, 0] * z[i, 0]
            s1 += r[i, 1] * z[i, 1]
            s2 += r[i, 2] * z[i, 2]
        sums[b, 0], sums[b, 1], sums[b, 2] = s0, s1, s2
    return sums


@compiled
def row_product(matrix: CompressedRows, i: int, x: Floats) -> tuple[float, float, float]:
    """(A x)_i for x of shape (n, 3), the terms added in their order in the row; i is unsigned."""
    indptr, indices, data = matrix
    a0, a1, a2 = 0.0, 0.0, 0.0
    for k in range(Index(indptr[i]), Index(indptr[i + Index(1)])):
        j, w = Index(indices[k]), data[k]
        a0 += w * x[j, 0]
        a1 += w * x[j, 1]
        a2 += w * x[j, 2]
    return a0, a1, a2


class _Level(NamedTuple):
    matrix: sparse.csr_matrix
    prolongation: sparse.csr_matrix
    restriction: sparse.csr_matrix
    inverse_diagonal: Floats
    run: int
    solution: Floats
    residual: Floats
    correction: Floats
    coarse_residual: Floats


class SmoothedAggregation:
    """A preconditioner for a symmetric positive (semi)definite matrix: a call with a residual (n, 3) runs one symmetric V-cycle.

    The returned array belongs to the object and is overwritten by the next call. The near-null space is taken to be the constant
    vectors, which is right for a Laplace operator plus a mass matrix, and good enough for powers of the operator.
    """

    def __init__(self, matrix: sparse.csr_matrix, *, progress: Progress = ignore_progress) -> None:
        """Builds the levels of an (n, n) matrix with a positive diagonal, in linear time; `progress` may raise to stop."""
        self._levels: list[_Level] = []
        self._coarsest: sparse.linalg.SuperLU | None = None
        strength, noise = STRENGTH, _NOISE * matrix.diagonal()
        while matrix.shape[0] > COARSEST:
            prolongation = prolongation_matrix(matrix, strength)
            progress(0.0)
            if not 0 < prolongation.shape[1] <= _MOST_KEPT * matrix.shape[0]:
                break
            level = _level(matrix, prolongation)
            self._levels.append(level)
            progress(0.0)
            half = matrix @ prolongation
            progress(0.0)
            matrix = with_sorted_indices(level.restriction @ half)
            strength *= 0.5
            noise = prolongation.power(2).T @ noise
        if matrix.shape[0] <= COARSEST:
            # If the matrix is singular, so is the coarsest matrix: its factors would amplify rounding errors in the constant part
            # of the residual. On coarse levels, the large entries at slivers cancel, and only rounding errors are left. A larger
            # diagonal repairs both.
            raised = _SHIFT * matrix.diagonal() + noise
            self._coarsest = _factorised(sparse.csc_matrix(matrix + sparse.diags_array(raised)))
        if self._coarsest is None:
            # The last level is nearly diagonal and cannot be coarsened, or it has no factors: two sweeps replace its solution.
            self._levels.append(_level(matrix, sparse.csr_matrix((matrix.shape[0], 0))))

    def __call__(self, residual: Floats) -> Floats:
        return self._cycle(0, residual)

    def iterated(self, right_side: Floats, cycles: int) -> Floats:
        """Approximates A^-1 right_side, (n, 3), by `cycles` V-cycles; each solves for the residual that remains."""
        x = self(right_side).copy()
        if not self._levels:
            return x  # solved by factors alone
        matrix, residual = self._levels[0].matrix, np.empty_like(x)
        for _ in range(cycles - 1):
            _add_product(-1.0, CompressedRows.of(matrix), x, right_side, residual)
            x += self(residual)
        return x

    def _cycle(self, depth: int, right_side: Floats) -> Floats:
        if depth == len(self._levels):
            return right_side if self._coarsest is None else self._coarsest.solve(right_side)
        level = self._levels[depth]
        matrix, x, residual = CompressedRows.of(level.matrix), level.solution, level.residual
        sweep_down(matrix, level.inverse_diagonal, level.run, right_side, x)
        _add_product(-1.0, matrix, x, right_side, residual)
        down, up = CompressedRows.of(level.restriction), CompressedRows.of(level.prolongation)
        level.coarse_residual[:] = 0.0
        _add_product(1.0, down, residual, level.coarse_residual, level.coarse_residual)
        coarse = self._cycle(depth + 1, level.coarse_residual)
        _add_product(1.0, up, coarse, x, x)
        _add_product(-1.0, matrix, x, right_side, residual)
        sweep_up(matrix, level.inverse_diagonal, level.run, residual, level.correction, x)
        return x


def _factorised(matrix: sparse.csc_matrix) -> sparse.linalg.SuperLU | None:
    try:
        factors = sparse.linalg.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return None
    return factors if (factors.U.diagonal() > 0.0).all() else None


def _level(matrix: sparse.csr_matrix, prolongation: sparse.csr_matrix) -> _Level:
    n, coarse = prolongation.shape
    run = max(_SHORTEST_RUN, -(-n // _RUNS))
    inverse_diagonal = np.empty(n)
    damped_diagonal(CompressedRows.of(matrix), run, inverse_diagonal)
    restriction = with_sorted_indices(prolongation.T)
    work = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((coarse, 3))
    return _Level(matrix, prolongation, restriction, inverse_diagonal, run, *work)


@compiled(parallel=True)
def _add_product(factor: float, matrix: CompressedRows, x: Floats, b: Floats, y: Floats) -> None:
    """Computes y = b + factor A x in place; y may be b."""
    for row in prange(y.shape[0]):
        i = Index(row)
        a0, a1, a2 = row_product(matrix, i, x)
        y[i, 0], y[i, 1], y[i, 2] = b[i, 0] + factor * a0, b[i, 1] + factor * a1, b[i, 2] + factor * a2


def prolongation_matrix(matrix: sparse.csr_matrix, strength: float) -> sparse.csr_matrix:
    """Returns P = (I - 4/3 diag(1 / sum_j |a_ij|) A) T, with T the 0-1 matrix of the aggregates.

    Unknowns i and j of (n, n) symmetric A are strongly connected if -a_ij >= strength sqrt(a_ii a_jj). A larger `strength` makes
    smaller aggregates.
    """
    diagonal = matrix.diagonal()
    aggregates, count = _aggregate(CompressedRows.of(matrix), diagonal, strength)
    members = np.flatnonzero(aggregates >= 0)
    entries = np.ones(len(members)), (members, aggregates[members])
    tentative = sparse.csr_matrix(entries, shape=(len(aggregates), count))
    smoothing = sparse.csr_matrix(matrix @ tentative)
    damping = (-4.0 / 3.0) / np.asarray(abs(matrix).sum(axis=1)).ravel()
    smoothing.data *= np.repeat(damping, np.diff(smoothing.indptr))
    return with_sorted_indices(tentative + smoothing)


def with_sorted_indices(matrix: sparse.spmatrix) -> sparse.csr_matrix:
    """The matrix as CSR with sorted indices, of 32 bits where they suffice."""
    csr = sparse.csr_matrix(matrix)
    csr.sort_indices()
    if csr.indices.dtype != np.int32 and csr.nnz < np.iinfo(np.int32).max:
        csr.indices, csr.indptr = csr.indices.astype(np.int32), csr.indptr.astype(np.int32)
    return csr


@compiled
def _is_strong(entry: float, i: int, j: int, diagonal: Floats, strength: float) -> bool:
    return i != j and entry < 0.0 and entry * entry >= strength * strength * diagonal[i] * diagonal[j]


@compiled
def _aggregate(matrix: CompressedRows, diagonal: Floats, strength: float) -> tuple[Ints, int]:
    """Returns each unknown's aggregate, -1 for none, and the number of aggregates: algorithm 5.1 of [vanek1996]."""
    indptr, indices, data = matrix
    n = indptr.shape[0] - 1
    aggregate = np.full(n, -1, dtype=np.int32)
    count = 0
    for i in range(n):
        # 1. An unknown and all its strong neighbours form an aggregate if none of them is in an aggregate yet.
        alone = True
        taken = aggregate[i] >= 0
        for k in range(indptr[i], indptr[i + 1]):
            if _is_strong(data[k], i, indices[k], diagonal, strength):
                alone = False
                taken = taken or aggregate[indices[k]] >= 0
        if not alone and not taken:
            for k in range(indptr[i], indptr[i + 1]):
                if _is_strong(data[k], i, indices[k], diagonal, strength):
                    aggregate[indices[k]] = count
            aggregate[i] = count
            count += 1
    # 2. Each unknown that is left joins the aggregate of its strongest neighbour with an aggregate.
    joined = aggregate.copy()
    for i in range(n):
        strongest = 0.0
        if aggregate[i] < 0:
            for k in range(indptr[i], indptr[i + 1]):
                j = indices[k]
                if aggregate[j] >= 0 and _is_strong(data[k], i, j, diagonal, strength):
                    share = data[k] * data[k] / diagonal[j]
                    if share > strongest:
                        strongest = share
                        joined[i] = aggregate[j]
    # 3. An unknown that is left forms an aggregate with its strong neighbours that are left, if there are any.
    for i in range(n):
        if joined[i] < 0:
            used = False
            for k in range(indptr[i], indptr[i + 1]):
                j = indices[k]
                if joined[j] < 0 and _is_strong(data[k], i, j, diagonal, strength):
                    joined[j] = count
                    used = True
            if used:
                joined[i] = count
                count += 1
    return joined, count


@compiled(parallel=True)
def damped_diagonal(matrix: CompressedRows, run: int, inverse: Floats) -> None:
    """Computes 1 / (A_ii + half the sum of |A_ij| over columns j of other runs) in place."""
    indptr, indices, data = matrix
    for i in prange(inverse.shape[0]):
        first = (i // run) * run
        total = 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if j == i:
                total += data[k]
            elif j < first or j >= first + run:
                total += 0.5 * abs(data[k])
        inverse[i] = 1.0 / total


@compiled(parallel=True)
def sweep_down(matrix: CompressedRows, inverse: Floats, run: int, r: Floats, x: Floats) -> None:
    """One forward Gauss-Seidel sweep for A x = r from x = 0, within every run."""
    indptr, indices, data = matrix
    n = x.shape[0]
    for b in prange((n + run - 1) // run):
        first = Index(b * run)
        for i in range(first, Index(min(n, (b + 1) * run))):
            a0, a1, a2 = r[i, 0], r[i, 1], r[i, 2]
            for k in range(Index(indptr[i]), Index(indptr[i + Index(1)])):
                j, w = Index(indices[k]), data[k]
                if j >= i:
                    break
                if j >= first:
                    a0 -= w * x[j, 0]
                    a1 -= w * x[j, 1]
                    a2 -= w * x[j, 2]
            x[i, 0], x[i, 1], x[i, 2] = a0 * inverse[i], a1 * inverse[i], a2 * inverse[i]


@compiled(parallel=True)
def sweep_up(matrix: CompressedRows, inverse: Floats, run: int, r: Floats, e: Floats, x: Floats) -> None:
    """One backward Gauss-Seidel sweep for A e = r from e = 0, within every run; then x += e."""
    indptr, indices, data = matrix
    n = x.shape[0]
    for b in prange((n + run - 1) // run):
        end = Index(min(n, (b + 1) * run))
        i = end
        while i > Index(b * run):
            i -= Index(1)
            a0, a1, a2 = r[i, 0], r[i, 1], r[i, 2]
            k = Index(indptr[i + Index(1)])
            while k > Index(indptr[i]):
                k -= Index(1)
                j, w = Index(indices[k]), data[k]
                if j <= i:
                    break
                if j < end:
                    a0 -= w * e[j, 0]
                    a1 -= w * e[j, 1]
                    a2 -= w * e[j, 2]
            e[i, 0], e[i, 1], e[i, 2] = a0 * inverse[i], a1 * inverse[i], a2 * inverse[i]
            x[i, 0] += e[i, 0]
            x[i, 1] += e[i, 1]
            x[i, 2] += e[i, 2]

"""Algebraic multigrid by smoothed aggregation: a preconditioner for elliptic matrices of any size.

Every level gathers strongly connected unknowns into aggregates of about ten, each one unknown of the next level [vanek1996].
Written here because PyAMG's cycle takes one right-hand side on one thread; docs/solvers.md compares their times.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..compilation import compiled, prange
from ..execution import Progress, ignore_progress
from ..libraries import sparse
from ..mesh import Floats, Ints
from .conjugate_gradients import CompressedRows, Index, row_product

#: Unknowns i and j are strongly connected if -a_ij >= this * sqrt(a_ii a_jj); halved from level to level.
STRENGTH = 0.08
#: A level of at most this many unknowns is factorised, which takes a few milliseconds.
COARSEST = 1000
#: A level that keeps more than this share of the unknowns of the finer one is not worth having.
_LEAST_GAIN = 0.8
#: The diagonal of the coarsest matrix is raised by two shares: one of itself, far below all eigenvalues but that of constants,
#: and one of the largest summand of an entry, for the rounding of sums that cancel.
_SHIFT, _NOISE = 1e-8, 2.0**-46
#: Runs of rows a level, and the least rows a run.
_RUNS, _SHORTEST_RUN = 64, 2048


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
    """One symmetric V-cycle for a symmetric positive (semi)definite matrix: call it with a residual of shape (n, 3).

    The returned array belongs to the object and is overwritten by the next call. The near-kernel is taken to be the constant
    vector, which is right for a Laplace operator plus a mass and usable for its powers.

    Attributes:
        sizes: the number of unknowns of each level, finest first.
    """

    def __init__(self, matrix: sparse.csr_matrix, *, progress: Progress = ignore_progress) -> None:
        """Builds the levels, in time linear in the matrix.

        Args:
            matrix: (n, n) with a positive diagonal.
            progress: called a few times a level; may raise to stop.
        """
        self._levels: list[_Level] = []
        self._coarsest: sparse.linalg.SuperLU | None = None
        strength, noise = STRENGTH, _NOISE * matrix.diagonal()
        while matrix.shape[0] > COARSEST:
            prolongation = prolongation_matrix(matrix, strength)
            progress(0.0)
            if not 0 < prolongation.shape[1] <= _LEAST_GAIN * matrix.shape[0]:
                break
            level = _level(matrix, prolongation)
            self._levels.append(level)
            progress(0.0)
            half = matrix @ prolongation
            progress(0.0)
            matrix = with_sorted_indices(level.restriction @ half)
            strength *= 0.5
            noise = prolongation.power(2).T @ noise
        self.sizes = [len(level.solution) for level in self._levels] + [matrix.shape[0]]
        if matrix.shape[0] <= COARSEST:
            # If the matrix is singular so is the coarsest one, whose factors would amplify the constant part of the rounding of
            # the residual. The entries of slivers cancel on the way down and leave rounding too. Both need a larger diagonal.
            raised = _SHIFT * matrix.diagonal() + noise
            self._coarsest = _factorised(sparse.csc_matrix(matrix + sparse.diags_array(raised)))
        if self._coarsest is None:
            # Nearly diagonal matrix: nothing to coarsen, and two sweeps are enough.
            self._levels.append(_level(matrix, sparse.csr_matrix((matrix.shape[0], 0))))

    def __call__(self, residual: Floats) -> Floats:
        """About A^-1 residual, (n, 3)."""
        return self._cycle(0, residual)

    def iterated(self, right_side: Floats, cycles: int) -> Floats:
        """A^-1 right_side after so many cycles, (n, 3), each on the residual that the one before has left."""
        x = self(right_side).copy()
        if not self._levels:
            return x  # by the factors of the matrix itself
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
    """The factors of the matrix; None if it is not positive definite."""
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
    """P = (I - 4/3 diag(1 / sum_j |a_ij|) A) T, with T the 0-1 matrix of the aggregates.

    Unknowns i and j of (n, n) symmetric A are strongly connected if -a_ij >= strength sqrt(a_ii a_jj). Larger makes smaller
    aggregates.
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
    """The aggregate of every unknown, -1 without strong connections, and their number, by algorithm 5.1 of [vanek1996]."""
    indptr, indices, data = matrix
    n = indptr.shape[0] - 1
    aggregate = np.full(n, -1, dtype=np.int32)
    count = 0
    for i in range(n):
        # 1. An unknown with all its strong neighbours, where none of them is taken.
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
    # 2. The others join the aggregate of their strongest neighbour.
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
    # 3. What is left has no neighbour in an aggregate: it makes its own.
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
    """Computes 1 / (A_ii + half the sum of |A_ij| over the j of other runs) in place."""
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
    """A forward sweep for A x = r, started from x = 0 within every run."""
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
    """A backward sweep for A e = r, started from e = 0 within every run; then x += e."""
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

"""Algebraic multigrid by smoothed aggregation: a preconditioner for elliptic matrices whose quality hardly depends on their size.

Every level gathers strongly connected unknowns into aggregates of about ten, one unknown of the next level each
[vanek1996]. The smoother is a Gauss-Seidel sweep within fixed runs of rows; what couples different runs is added to the
diagonal instead, which keeps the sweep convergent [baker2011] and lets threads share the runs out without changing a bit.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit, prange
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

from ..execution import Progress, ignore_progress
from ..mesh import Floats, Ints

# Indices are taken as unsigned numbers: for signed ones the compiler adds the test whether they count from the end.
_U: Any = np.uint64

#: Unknowns i and j are strongly connected if -a_ij >= this * sqrt(a_ii a_jj); halved from level to level.
STRENGTH = 0.08
#: A level of at most this many unknowns is factorised, in a few milliseconds.
COARSEST = 1000
#: A level that keeps more than this share of the unknowns of the finer one is not worth having.
_LEAST_GAIN = 0.8
# What the diagonal of the coarsest matrix is raised by: a share of itself, far below all its eigenvalues but that of constants,
# and what rounding may have done to an entry that is a sum, as a share of the largest summand.
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

    The returned array belongs to the object and is overwritten by the next call. Constants are taken for the smoothest vectors:
    right for Laplace operators plus a mass, usable for their powers.

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
        self._coarsest: SuperLU | None = None
        strength, noise = STRENGTH, _NOISE * matrix.diagonal()
        while matrix.shape[0] > COARSEST:
            prolongation = _prolongation(matrix, strength)
            progress(0.0)
            if not 0 < prolongation.shape[1] <= _LEAST_GAIN * matrix.shape[0]:
                break
            level = _level(matrix, prolongation)
            self._levels.append(level)
            progress(0.0)
            half = matrix @ prolongation
            progress(0.0)
            matrix = _canonical(level.restriction @ half)
            strength *= 0.5
            noise = prolongation.power(2).T @ noise
        self.sizes = [len(level.solution) for level in self._levels] + [matrix.shape[0]]
        if matrix.shape[0] <= COARSEST:
            # Where the matrix is singular so is the coarsest, and would blow up the rounding errors of the residual in constants.
            # The entries of slivers cancel on the way down and leave rounding errors of their own. Both need a larger diagonal.
            raised = _SHIFT * matrix.diagonal() + noise
            self._coarsest = _factorised(sparse.csc_matrix(matrix + sparse.diags_array(raised)))
        if self._coarsest is None:
            # Unknowns that hardly know each other, as of a matrix near a diagonal one: two sweeps are all they need.
            self._levels.append(_level(matrix, sparse.csr_matrix((matrix.shape[0], 0))))

    def __call__(self, residual: Floats) -> Floats:
        """About A^-1 residual, (n, 3)."""
        return self._cycle(0, residual)

    def _cycle(self, depth: int, right_side: Floats) -> Floats:
        if depth == len(self._levels):
            return right_side if self._coarsest is None else self._coarsest.solve(right_side)
        level = self._levels[depth]
        matrix = level.matrix.indptr, level.matrix.indices, level.matrix.data
        x, residual = level.solution, level.residual
        _sweep_down(*matrix, level.inverse_diagonal, level.run, right_side, x)
        _add_product(-1.0, *matrix, x, right_side, residual)
        down, up = level.restriction, level.prolongation
        level.coarse_residual[:] = 0.0
        _add_product(1.0, down.indptr, down.indices, down.data, residual, level.coarse_residual, level.coarse_residual)
        coarse = self._cycle(depth + 1, level.coarse_residual)
        _add_product(1.0, up.indptr, up.indices, up.data, coarse, x, x)
        _add_product(-1.0, *matrix, x, right_side, residual)
        _sweep_up(*matrix, level.inverse_diagonal, level.run, residual, level.correction, x)
        return x


def _factorised(matrix: sparse.csc_matrix) -> SuperLU | None:
    """The factors of the matrix, None if it is not positive definite."""
    try:
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return None
    return factors if (factors.U.diagonal() > 0.0).all() else None


def _level(matrix: sparse.csr_matrix, prolongation: sparse.csr_matrix) -> _Level:
    n, coarse = prolongation.shape
    run = max(_SHORTEST_RUN, -(-n // _RUNS))
    inverse_diagonal = np.empty(n)
    _damped_diagonal(matrix.indptr, matrix.indices, matrix.data, run, inverse_diagonal)
    restriction = _canonical(prolongation.T)
    work = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((coarse, 3))
    return _Level(matrix, prolongation, restriction, inverse_diagonal, run, *work)


def _prolongation(matrix: sparse.csr_matrix, strength: float) -> sparse.csr_matrix:
    """P = (I - 4/3 diag(1 / sum_j |a_ij|) A) T, T the 0-1 matrix of the aggregates."""
    diagonal = matrix.diagonal()
    aggregates, count = _aggregate(matrix.indptr, matrix.indices, matrix.data, diagonal, strength)
    members = np.flatnonzero(aggregates >= 0)
    entries = np.ones(len(members)), (members, aggregates[members])
    tentative = sparse.csr_matrix(entries, shape=(len(aggregates), count))
    smoothing = sparse.csr_matrix(matrix @ tentative)
    damping = (-4.0 / 3.0) / np.asarray(abs(matrix).sum(axis=1)).ravel()
    smoothing.data *= np.repeat(damping, np.diff(smoothing.indptr))
    return _canonical(tentative + smoothing)


def _canonical(matrix: sparse.spmatrix) -> sparse.csr_matrix:
    csr = sparse.csr_matrix(matrix)
    csr.sort_indices()
    if csr.indices.dtype != np.int32 and csr.nnz < np.iinfo(np.int32).max:
        csr.indices, csr.indptr = csr.indices.astype(np.int32), csr.indptr.astype(np.int32)
    return csr


@njit(cache=True)
def _is_strong(entry: float, i: int, j: int, diagonal: Floats, strength: float) -> bool:
    return i != j and entry < 0.0 and entry * entry >= strength * strength * diagonal[i] * diagonal[j]


@njit(cache=True)
def _aggregate(indptr: Ints, indices: Ints, data: Floats, diagonal: Floats, strength: float) -> tuple[Ints, int]:
    """The aggregate of every unknown, or -1 for one without strong connections; and their number. [vanek1996], algorithm 5.1."""
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


@njit(cache=True, parallel=True)
def _damped_diagonal(indptr: Ints, indices: Ints, data: Floats, run: int, inverse: Floats) -> None:
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


@njit(cache=True, parallel=True)
def _sweep_down(indptr: Ints, indices: Ints, data: Floats, inverse: Floats, run: int, r: Floats, x: Floats) -> None:
    """Forward Gauss-Seidel from 0 within every run."""
    n = x.shape[0]
    for b in prange((n + run - 1) // run):
        first = _U(b * run)
        for i in range(first, _U(min(n, (b + 1) * run))):
            a0, a1, a2 = r[i, 0], r[i, 1], r[i, 2]
            for k in range(_U(indptr[i]), _U(indptr[i + _U(1)])):
                j, w = _U(indices[k]), data[k]
                if j >= i:
                    break
                if j >= first:
                    a0 -= w * x[j, 0]
                    a1 -= w * x[j, 1]
                    a2 -= w * x[j, 2]
            x[i, 0], x[i, 1], x[i, 2] = a0 * inverse[i], a1 * inverse[i], a2 * inverse[i]


@njit(cache=True, parallel=True)
def _sweep_up(indptr: Ints, indices: Ints, data: Floats, inverse: Floats, run: int, r: Floats, e: Floats, x: Floats) -> None:
    """The backward Gauss-Seidel sweep e from 0 within every run; x += e."""
    n = x.shape[0]
    for b in prange((n + run - 1) // run):
        end = _U(min(n, (b + 1) * run))
        i = end
        while i > _U(b * run):
            i -= _U(1)
            a0, a1, a2 = r[i, 0], r[i, 1], r[i, 2]
            k = _U(indptr[i + _U(1)])
            while k > _U(indptr[i]):
                k -= _U(1)
                j, w = _U(indices[k]), data[k]
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


@njit(cache=True, parallel=True)
def _add_product(factor: float, indptr: Ints, indices: Ints, data: Floats, x: Floats, b: Floats, y: Floats) -> None:
    """The sum b + factor A x into y, which may be b."""
    for row in prange(y.shape[0]):
        i = _U(row)
        a0, a1, a2 = 0.0, 0.0, 0.0
        for k in range(_U(indptr[i]), _U(indptr[i + _U(1)])):
            j, w = _U(indices[k]), data[k]
            a0 += w * x[j, 0]
            a1 += w * x[j, 1]
            a2 += w * x[j, 2]
        y[i, 0], y[i, 1], y[i, 2] = b[i, 0] + factor * a0, b[i, 1] + factor * a1, b[i, 2] + factor * a2

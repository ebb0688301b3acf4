"""Algebraic multigrid by smoothed aggregation: a preconditioner for elliptic matrices whose quality hardly depends on their size.

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
from .aggregation import prolongation_matrix, with_sorted_indices
from .gauss_seidel import damped_diagonal, sweep_down, sweep_up
from .row_product import Index, row_product

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
            _add_product(-1.0, matrix.indptr, matrix.indices, matrix.data, x, right_side, residual)
            x += self(residual)
        return x

    def _cycle(self, depth: int, right_side: Floats) -> Floats:
        if depth == len(self._levels):
            return right_side if self._coarsest is None else self._coarsest.solve(right_side)
        level = self._levels[depth]
        matrix = level.matrix.indptr, level.matrix.indices, level.matrix.data
        x, residual = level.solution, level.residual
        sweep_down(*matrix, level.inverse_diagonal, level.run, right_side, x)
        _add_product(-1.0, *matrix, x, right_side, residual)
        down, up = level.restriction, level.prolongation
        level.coarse_residual[:] = 0.0
        _add_product(1.0, down.indptr, down.indices, down.data, residual, level.coarse_residual, level.coarse_residual)
        coarse = self._cycle(depth + 1, level.coarse_residual)
        _add_product(1.0, up.indptr, up.indices, up.data, coarse, x, x)
        _add_product(-1.0, *matrix, x, right_side, residual)
        sweep_up(*matrix, level.inverse_diagonal, level.run, residual, level.correction, x)
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
    damped_diagonal(matrix.indptr, matrix.indices, matrix.data, run, inverse_diagonal)
    restriction = with_sorted_indices(prolongation.T)
    work = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((coarse, 3))
    return _Level(matrix, prolongation, restriction, inverse_diagonal, run, *work)


@compiled(parallel=True)
def _add_product(factor: float, indptr: Ints, indices: Ints, data: Floats, x: Floats, b: Floats, y: Floats) -> None:
    """Computes y = b + factor A x in place; y may be b."""
    for row in prange(y.shape[0]):
        i = Index(row)
        a0, a1, a2 = row_product(indptr, indices, data, i, x)
        y[i, 0], y[i, 1], y[i, 2] = b[i, 0] + factor * a0, b[i, 1] + factor * a1, b[i, 2] + factor * a2

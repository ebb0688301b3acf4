"""Sparse direct solvers: CHOLMOD, fast and uninterruptible; SuperLU, which can be stopped."""

from __future__ import annotations

from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np

from ..checks import ConvergenceError
from ..execution import Progress, abandonable, ignore_progress
from ..libraries import cholespy, sparse
from ..mesh import Floats

# Rows from which the factors take long enough for a thread of their own.
_QUICK = 5000


class Cholesky:
    """The factors of a symmetric positive definite matrix, by CHOLMOD with nested dissection.

    Making them cannot be interrupted, and takes about a second for a mesh of 100,000 vertices; see docs/solvers.md.
    On systems for which cholespy has no wheel, such as Linux on aarch64, `SuperLU` does the work.
    """

    def __init__(self, matrix: sparse.csr_matrix) -> None:
        """Factorises an (n, n) finite matrix of which only one triangle is used.

        Raises:
            ConvergenceError: it is not positive definite to rounding.
        """
        csr = sparse.csr_matrix(matrix)
        csr.sum_duplicates()
        if not (csr.diagonal() > 0.0).all():
            raise ConvergenceError("the matrix is not positive definite: it has a diagonal entry that is not positive")
        # The CSC type of cholespy reallocates the caller's arrays, which numpy owns; its CSR type makes a copy. For a symmetric
        # matrix both are the same.
        self._factors: Any = None
        if csr.shape[0] == 0:
            return
        if find_spec("cholespy") is None:
            self._factors = SuperLU(csr)
            return
        starts, columns = csr.indptr.astype(np.int32), csr.indices.astype(np.int32)
        try:
            self._factors = cholespy.CholeskySolverD(csr.shape[0], starts, columns, csr.data.copy(), cholespy.MatrixType.CSR)
        except ValueError as error:
            raise ConvergenceError(f"the matrix of {csr.shape[0]} rows is not positive definite to rounding") from error

    def solve(self, right_side: Floats) -> Floats:
        """The solution for (n, k) right-hand sides, (n, k)."""
        if isinstance(self._factors, SuperLU):
            return self._factors.solve(right_side)
        # A copy, since cholespy does not take arrays that may not be written to.
        b = np.array(right_side, order="C")
        x = np.empty(b.shape)
        if self._factors is not None and b.size:
            self._factors.solve(b, x)
        return x


class SuperLU:
    """The factors L U of a symmetric positive definite matrix, minimum degree order, no row exchanges.

    On squares and cubes of Laplace operators as fast as `Cholesky` or faster (docs/solvers.md), and it can be stopped.
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
        csc = sparse.csc_matrix(matrix)
        self._factors: Any = None
        if csc.shape[0] == 0:
            return
        work = partial(
            sparse.linalg.splu, csc, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        try:
            factors = work() if csc.shape[0] < _QUICK else abandonable(work, progress, done)
        except RuntimeError as error:
            raise ConvergenceError(f"the matrix of {csc.shape[0]} rows is singular to rounding") from error
        if not np.array_equal(factors.perm_r, factors.perm_c):
            raise ConvergenceError(f"the matrix of {csc.shape[0]} rows is not positive definite to rounding")
        self._factors = factors

    def solve(self, right_side: Floats) -> Floats:
        """The solution for (n, k) right-hand sides, (n, k)."""
        if self._factors is None or right_side.size == 0:
            return np.empty(right_side.shape)
        return np.ascontiguousarray(self._factors.solve(np.asfortranarray(right_side)))

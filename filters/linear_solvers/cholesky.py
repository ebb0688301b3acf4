"""Sparse Cholesky factors: slow to make, fast to solve with."""

from __future__ import annotations

import numpy as np

from ..checks import ConvergenceError
from ..libraries import cholespy, sparse
from ..mesh import Floats


class Cholesky:
    """The factors of a symmetric positive definite matrix, by CHOLMOD with nested dissection.

    Making them cannot be interrupted, and takes about a second for a mesh of 100,000 vertices; see docs/solvers.md.
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
        self._factors = None
        if csr.shape[0] == 0:
            return
        starts, columns = csr.indptr.astype(np.int32), csr.indices.astype(np.int32)
        try:
            self._factors = cholespy.CholeskySolverD(csr.shape[0], starts, columns, csr.data.copy(), cholespy.MatrixType.CSR)
        except ValueError as error:
            raise ConvergenceError(f"the matrix of {csr.shape[0]} rows is not positive definite to rounding") from error

    def solve(self, right_side: Floats) -> Floats:
        """The solution for (n, k) right-hand sides, (n, k)."""
        # A copy, since cholespy does not take arrays that may not be written to.
        b = np.array(right_side, order="C")
        x = np.empty(b.shape)
        if self._factors is not None and b.size:
            self._factors.solve(b, x)
        return x

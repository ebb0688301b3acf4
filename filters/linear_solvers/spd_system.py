"""The checked matrix of a symmetric positive definite system, its scale, and the backward error of a solution."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..checks import FilterInputError
from ..libraries import sparse
from ..mesh import Floats


class SpdSystem(NamedTuple):
    """The left-hand side of A x = b.

    Attributes:
        matrix: A, (n, n) CSR with sorted indices, finite, with a positive diagonal.
        scale: (n,) 1 / sqrt(A_ii); D = diag(scale) makes D A D the matrix of unit diagonal.
        norm: the largest row sum of |D A D|, a bound of its largest eigenvalue.
        smoothness: the Rayleigh quotient 1^T A 1 / 1^T diag(A) 1, an upper bound of the smallest eigenvalue of D A D; near it for
            a Laplace operator plus a mass, whose smoothest vector is the constant one.
    """

    matrix: sparse.csr_matrix
    scale: Floats
    norm: float
    smoothness: float

    @classmethod
    def of(cls, matrix: sparse.csr_matrix) -> SpdSystem:
        """Measures A, which is kept, not copied; its symmetry is taken on trust.

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

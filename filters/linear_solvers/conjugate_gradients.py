"""Conjugate gradients for three right-hand sides at once, with the same bits for any number of threads.

Written here because SciPy's take one right-hand side and are slower; docs/solvers.md has the times.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..compilation import compiled, prange
from ..execution import Progress, ignore_progress, threads_for
from ..libraries import sparse
from ..mesh import Floats, Ints

#: Maps a residual (n, 3) to an approximate solution (n, 3): a symmetric positive definite approximation of the inverse.
Preconditioner: TypeAlias = Callable[[Floats], Floats]
#: Rows in a block. Smaller blocks are shared more evenly among threads, larger ones cost less.
_BLOCK = 4096
#: Indices in kernels are unsigned: for signed ones the compiler adds a test whether they count from the end.
Index: Any = np.uint64


class CompressedRows(NamedTuple):
    """A sparse matrix for kernels: the entries of row i are data[indptr[i]:indptr[i + 1]], in the columns `indices` there."""

    indptr: Ints
    indices: Ints
    data: Floats

    @classmethod
    def of(cls, matrix: sparse.csr_matrix) -> CompressedRows:
        """The arrays of a matrix, not copied."""
        return cls(matrix.indptr, matrix.indices, matrix.data)


class Descent(NamedTuple):
    """The result of conjugate gradients.

    Attributes:
        values: (n, 3) the approximate solution.
        norm: sqrt(sum r^T B r) over the columns, r the residual, B the preconditioner: about the error in the energy norm.
        iterations: how many products with the matrix it took.
        indefinite: whether it ended at a direction p with p^T A p < 0, which shows that A is not semidefinite.
    """

    values: Floats
    norm: float
    iterations: int
    indefinite: bool


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

    A semidefinite A is solved too if b lies in its range. Ends when the norm of `Descent` is at most ``target``, after
    ``max_iterations``, or when A turns out not to be semidefinite; the fields of `Descent` say which.

    Args:
        matrix: A, (n, n), with a positive diagonal.
        right_side: b, (n, 3). A column of zeros costs nothing and gives zeros.
        target: of the norm. Larger ends sooner.
        max_iterations: the most products with the matrix.
        start: (n, 3) a first guess; 0 if None.
        precondition: None divides by the diagonal (Jacobi).
        progress: called at every iteration; may raise to stop.
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
            direction = precondition(residual).copy()  # a preconditioner may give the same array again
            energy = _inner_products(residual, direction).sum(axis=0)
        first = norm = _root(energy)
        taken = 0
        while norm > target and taken < max_iterations:
            is_within = 0.0 < target < norm <= first < np.inf
            progress(float(np.log(first / norm) / np.log(first / target)) if is_within else 0.0)
            curvature = _multiply(rows, direction, product).sum(axis=0)
            if not (curvature >= 0.0).all():
                return Descent(x, norm, taken, True)
            before, energy = energy, _descend(_quotients(energy, curvature), direction, product, x, residual, scale).sum(axis=0)
            z = residual
            if precondition is not None:
                z = precondition(residual)
                energy = _inner_products(residual, z).sum(axis=0)
            _next_direction(_quotients(energy, before), z, scale, direction)
            del z  # (n, 3): the next one is made beside it otherwise
            norm = _root(energy)
            taken += 1
    return Descent(x, norm, taken, False)


def preconditioned_norm(matrix: sparse.csr_matrix, residual: Floats, precondition: Preconditioner | None = None) -> float:
    """sqrt(sum r^T B r) over the columns of an (n, 3) residual, B as in `conjugate_gradients`."""
    with threads_for(len(residual)):
        z = residual / matrix.diagonal()[:, None] if precondition is None else precondition(residual)
        return _root(_inner_products(residual, z).sum(axis=0))


def _root(energy: Floats) -> float:
    return float(np.sqrt(energy.sum())) if (energy >= 0.0).all() else np.inf


def _quotients(a: Floats, b: Floats) -> Floats:
    """The three a / b; 0 where b is not above 0."""
    return np.divide(a, b, out=np.zeros(3), where=b > 0.0)


@compiled(parallel=True)
def _multiply(matrix: CompressedRows, p: Floats, q: Floats) -> Floats:
    """Computes q = A p in place; returns the three p^T q of each block."""
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
    """Computes x += steps p and r -= steps q in place; returns the three r^T diag(scale) r of each block."""
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
    """Computes p = diag(scale) z + shares p in place."""
    t0, t1, t2 = shares[0], shares[1], shares[2]
    for row in prange(p.shape[0]):
        i = Index(row)
        p[i, 0] = scale[i] * z[i, 0] + t0 * p[i, 0]
        p[i, 1] = scale[i] * z[i, 1] + t1 * p[i, 1]
        p[i, 2] = scale[i] * z[i, 2] + t2 * p[i, 2]


@compiled(parallel=True)
def _inner_products(r: Floats, z: Floats) -> Floats:
    """The three r^T z of each block."""
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

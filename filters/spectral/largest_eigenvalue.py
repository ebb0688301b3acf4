"""The operator in symmetric form, D = M^-1/2 S M^-1/2, and bounds of its largest eigenvalue."""

from __future__ import annotations

import math

import numpy as np

from ..compilation import compiled, prange
from ..execution import threads_for
from ..libraries import sparse
from ..mesh import Floats, Ints

#: Steps of Lanczos's method, and the factor on its result.
_LANCZOS_STEPS, _MARGIN = 24, 1.02


def symmetric_form(dirichlet: sparse.csr_matrix, mass: Floats) -> sparse.csr_matrix:
    """D = M^-1/2 S M^-1/2, (n, n), the eigenvalues of which are those of M^-1 S."""
    inverse_root = 1.0 / np.sqrt(mass)
    data = np.empty(dirichlet.nnz)
    with threads_for(len(mass)):
        _scale_rows(dirichlet.indptr, dirichlet.indices, dirichlet.data, inverse_root, data)
    return sparse.csr_matrix((data, dirichlet.indices, dirichlet.indptr), shape=dirichlet.shape)


def gershgorin_bound(symmetric: sparse.csr_matrix, mass: Floats) -> float:
    """A proven bound of the largest eigenvalue, by the circles of M^-1 S; on regular triangles it is 4/3 of it."""
    sums = np.empty(len(mass))
    with threads_for(len(mass)):
        _sum_circles(symmetric.indptr, symmetric.indices, symmetric.data, np.sqrt(mass), sums)
    return float(sums.max(initial=0.0))


def lanczos_bound(symmetric: sparse.csr_matrix) -> float:
    """An estimate from above of the largest eigenvalue: the largest Ritz value plus its residual, times 1.02.

    The Ritz value of 24 steps from a random start is about a percent too low where eigenvalues are crowded, and exact where one
    stands out. `polynomial_filter` notices if the estimate was too low. Infinite for small matrices and where the method ends
    early, since the start may then lack some modes.
    """
    n = symmetric.shape[0]
    if n < 4 * _LANCZOS_STEPS:
        return math.inf
    steps = _LANCZOS_STEPS
    q = np.random.default_rng(0).uniform(-1.0, 1.0, n)
    q /= math.sqrt(float((q * q).sum()))
    before = np.zeros(n)
    diagonal, off = np.zeros(steps), np.zeros(steps)
    beta = 0.0
    with threads_for(n):
        for k in range(steps):
            w = np.empty(n)
            _multiply(symmetric.indptr, symmetric.indices, symmetric.data, q, w)
            w -= beta * before
            # numpy's sums have a fixed order; BLAS would divide a product among its threads.
            diagonal[k] = alpha = float((w * q).sum())
            w -= alpha * q
            off[k] = beta = math.sqrt(float((w * w).sum()))
            if beta <= 1e-12 * abs(diagonal[: k + 1]).max():
                return math.inf
            before, q = q, w / beta
    largest, last = _tridiagonal(diagonal, off[:-1])
    return _MARGIN * (largest + abs(beta * last))


def _tridiagonal(diagonal: Floats, off: Floats) -> tuple[float, float]:
    """The largest eigenvalue of a symmetric tridiagonal matrix and the last entry of its vector."""
    eigenvalues, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(off, 1) + np.diag(off, -1))
    return float(eigenvalues[-1]), float(vectors[-1, -1])


@compiled(parallel=True)
def _multiply(indptr: Ints, indices: Ints, data: Floats, x: Floats, product: Floats) -> None:
    for i in prange(x.shape[0]):
        total = 0.0
        for k in range(indptr[i], indptr[i + 1]):
            total += data[k] * x[indices[k]]
        product[i] = total


@compiled(parallel=True)
def _scale_rows(indptr: Ints, indices: Ints, data: Floats, factors: Floats, scaled: Floats) -> None:
    for i in prange(factors.shape[0]):
        for k in range(indptr[i], indptr[i + 1]):
            scaled[k] = data[k] * (factors[i] * factors[indices[k]])


@compiled(parallel=True)
def _sum_circles(indptr: Ints, indices: Ints, data: Floats, root: Floats, sums: Floats) -> None:
    for i in prange(root.shape[0]):
        total = 0.0
        for k in range(indptr[i], indptr[i + 1]):
            total += abs(data[k]) * root[indices[k]]
        sums[i] = total / root[i]

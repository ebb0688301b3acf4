"""Products with tall Fortran-ordered matrices, a few columns at a time, so that long ones can be interrupted."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..compilation import compiled, prange
from ..execution import Progress
from ..libraries import blas, sparse
from ..mesh import Floats, Ints

#: Columns in a group.
_TOGETHER = 16


def groups(count: int, progress: Progress, done: float = 1.0) -> Iterator[slice]:
    """The columns from 0 to `count` in groups; calls `progress` with `done` before each."""
    for first in range(0, count, _TOGETHER):
        progress(done)
        yield slice(first, min(first + _TOGETHER, count))


def sparse_product(operator: sparse.csc_matrix, columns: Floats) -> Floats:
    """A X, (n, k), for a symmetric A, on all threads with the same bits for any number of them."""
    made = np.empty(columns.shape, order="F")
    kernel: Any = _product
    kernel(operator.indptr, operator.indices, operator.data, columns, made)
    return made


def combined(columns: Floats, weights: Floats, progress: Progress) -> Floats:
    """X W, (n, k)."""
    made = np.empty((len(columns), weights.shape[1]), order="F")
    for group in groups(weights.shape[1], progress):
        made[:, group] = blas.dgemm(1.0, columns, np.asfortranarray(weights[:, group]))
    return made


def inner_products(left: Floats, right: Floats, progress: Progress) -> Floats:
    """X^T Y, (k, l)."""
    made = np.empty((left.shape[1], right.shape[1]), order="F")
    for group in groups(right.shape[1], progress):
        made[:, group] = blas.dgemm(1.0, left, right[:, group], trans_a=True)
    return made


def remove(directions: Floats, block: Floats) -> Floats:
    """Makes the block orthogonal to orthonormal directions, in place; returns its components along them."""
    share = blas.dgemm(1.0, directions, block, trans_a=True)
    blas.dgemm(-1.0, directions, share, 1.0, block, overwrite_c=True)
    return np.asarray(share)


@compiled(parallel=True)
def _product(starts: Ints, rows: Ints, values: Floats, columns: Floats, made: Floats) -> None:
    for c in prange(columns.shape[1]):
        for i in range(columns.shape[0]):
            total = 0.0
            for p in range(starts[i], starts[i + 1]):
                total += values[p] * columns[rows[p], c]
            made[i, c] = total

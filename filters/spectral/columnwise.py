"""A sparse symmetric operator times the columns of a Fortran-ordered matrix, each column by itself."""

from typing import Any

import numpy as np
from numba import njit, prange
from scipy import sparse

from ..mesh import Floats, Ints


def product(operator: sparse.csc_matrix, columns: Floats) -> Floats:
    """A X, (n, k) Fortran-ordered, for a symmetric A; the same to the bit for any number of threads."""
    made = np.empty(columns.shape, order="F")
    kernel: Any = _product
    kernel(operator.indptr, operator.indices, operator.data, np.asfortranarray(columns), made)
    return made


@njit(cache=True, parallel=True)
def _product(starts: Ints, rows: Ints, values: Floats, columns: Floats, made: Floats) -> None:
    for c in prange(columns.shape[1]):
        for i in range(columns.shape[0]):
            total = 0.0
            for p in range(starts[i], starts[i + 1]):
                total += values[p] * columns[rows[p], c]
            made[i, c] = total

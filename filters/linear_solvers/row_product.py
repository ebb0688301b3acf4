"""A row of a sparse matrix times three columns."""

from typing import Any

import numpy as np

from ..compilation import compiled
from ..mesh import Floats, Ints

#: Indices in kernels are unsigned: for signed ones the compiler adds a test whether they count from the end.
Index: Any = np.uint64


@compiled
def row_product(indptr: Ints, indices: Ints, data: Floats, i: int, x: Floats) -> tuple[float, float, float]:
    """(A x)_i for x of shape (n, 3), the terms added in their order in the row; i is unsigned."""
    a0, a1, a2 = 0.0, 0.0, 0.0
    for k in range(Index(indptr[i]), Index(indptr[i + Index(1)])):
        j, w = Index(indices[k]), data[k]
        a0 += w * x[j, 0]
        a1 += w * x[j, 1]
        a2 += w * x[j, 2]
    return a0, a1, a2

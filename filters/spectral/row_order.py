"""An order of the rows of a matrix in which its products read nearby memory."""

from __future__ import annotations

import numpy as np

from ..libraries import sparse
from ..mesh import Floats, Ints

#: Of fewer rows a product finds most in the processor's caches, in any order.
FITS_IN_CACHE = 200_000
#: A large matrix is reordered if more than this share of its entries lies far from the diagonal ...
_SCATTERED = 0.2
#: ... farther than this many columns, ...
_NEAR = 8192
#: ... and if this many products with one column are to come: finding the order takes about as long as they lose without it.
_PRODUCTS_AN_ORDER_COSTS = 300


def nearby_order(matrix: sparse.csr_matrix, products: int) -> Ints | None:
    """(n,) the rows in Cuthill and McKee's order, which keeps entries near the diagonal; None if finding it would not pay.

    Args:
        matrix: (n, n) with a symmetric pattern.
        products: how many are to come, with one column each.
    """
    n = matrix.shape[0]
    if n < FITS_IN_CACHE or products < _PRODUCTS_AN_ORDER_COSTS:
        return None
    rows = np.repeat(np.arange(n, dtype=matrix.indices.dtype), np.diff(matrix.indptr))
    if (np.abs(rows - matrix.indices) > _NEAR).mean() < _SCATTERED:
        return None
    return np.asarray(sparse.csgraph.reverse_cuthill_mckee(matrix, symmetric_mode=True), dtype=np.int32)


def put_back(rows: Floats, order: Ints) -> Floats:
    """The rows in the places that they had before `nearby_order`."""
    result = np.empty_like(rows)
    result[order] = rows
    return result

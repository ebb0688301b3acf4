"""The vector operations of conjugate gradients for three columns, in one pass over memory each.

Sums are taken over blocks of rows of a fixed size and the blocks added up in their order, so no result depends on how threads
share the blocks.
"""

import numpy as np

from ..compilation import compiled, prange
from ..mesh import Floats, Ints
from .row_product import Index, row_product

#: Rows in a block. Smaller blocks are shared more evenly among threads, larger ones cost less.
_BLOCK = 4096


@compiled
def _add_up(parts: Floats) -> Floats:
    total = np.zeros(3)
    for b in range(parts.shape[0]):
        for c in range(3):
            total[c] += parts[b, c]
    return total


@compiled(parallel=True)
def multiply(indptr: Ints, indices: Ints, data: Floats, p: Floats, q: Floats) -> Floats:
    """Computes q = A p in place; returns the three p^T q."""
    n = p.shape[0]
    parts = np.zeros(((n + _BLOCK - 1) // _BLOCK, 3))
    for b in prange(parts.shape[0]):
        s0, s1, s2 = 0.0, 0.0, 0.0
        for i in range(Index(b * _BLOCK), Index(min(n, (b + 1) * _BLOCK))):
            a0, a1, a2 = row_product(indptr, indices, data, i, p)
            q[i, 0], q[i, 1], q[i, 2] = a0, a1, a2
            s0 += a0 * p[i, 0]
            s1 += a1 * p[i, 1]
            s2 += a2 * p[i, 2]
        parts[b, 0], parts[b, 1], parts[b, 2] = s0, s1, s2
    return _add_up(parts)


@compiled(parallel=True)
def descend(steps: Floats, p: Floats, q: Floats, x: Floats, r: Floats, scale: Floats) -> Floats:
    """Computes x += steps p and r -= steps q in place; returns the three r^T diag(scale) r."""
    n = p.shape[0]
    t0, t1, t2 = steps[0], steps[1], steps[2]
    parts = np.zeros(((n + _BLOCK - 1) // _BLOCK, 3))
    for b in prange(parts.shape[0]):
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
        parts[b, 0], parts[b, 1], parts[b, 2] = s0, s1, s2
    return _add_up(parts)


@compiled(parallel=True)
def next_direction(shares: Floats, z: Floats, scale: Floats, p: Floats) -> None:
    """Computes p = diag(scale) z + shares p in place."""
    n = p.shape[0]
    t0, t1, t2 = shares[0], shares[1], shares[2]
    for b in prange((n + _BLOCK - 1) // _BLOCK):
        for i in range(Index(b * _BLOCK), Index(min(n, (b + 1) * _BLOCK))):
            p[i, 0] = scale[i] * z[i, 0] + t0 * p[i, 0]
            p[i, 1] = scale[i] * z[i, 1] + t1 * p[i, 1]
            p[i, 2] = scale[i] * z[i, 2] + t2 * p[i, 2]


@compiled(parallel=True)
def inner_products(r: Floats, z: Floats) -> Floats:
    """The three r^T z."""
    n = r.shape[0]
    parts = np.zeros(((n + _BLOCK - 1) // _BLOCK, 3))
    for b in prange(parts.shape[0]):
        s0, s1, s2 = 0.0, 0.0, 0.0
        for i in range(Index(b * _BLOCK), Index(min(n, (b + 1) * _BLOCK))):
            s0 += r[i, 0] * z[i, 0]
            s1 += r[i, 1] * z[i, 1]
            s2 += r[i, 2] * z[i, 2]
        parts[b, 0], parts[b, 1], parts[b, 2] = s0, s1, s2
    return _add_up(parts)

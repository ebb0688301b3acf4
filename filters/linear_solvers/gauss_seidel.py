"""Gauss-Seidel sweeps within fixed runs of rows, three columns at a time, with the same bits for any number of threads.

What couples different runs is added to the diagonal instead of being swept, which keeps the sweeps convergent [baker2011].
"""

from ..compilation import compiled, prange
from ..mesh import Floats, Ints
from .row_product import Index


@compiled(parallel=True)
def damped_diagonal(indptr: Ints, indices: Ints, data: Floats, run: int, inverse: Floats) -> None:
    """Computes 1 / (A_ii + half the sum of |A_ij| over the j of other runs) in place."""
    for i in prange(inverse.shape[0]):
        first = (i // run) * run
        total = 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            if j == i:
                total += data[k]
            elif j < first or j >= first + run:
                total += 0.5 * abs(data[k])
        inverse[i] = 1.0 / total


@compiled(parallel=True)
def sweep_down(indptr: Ints, indices: Ints, data: Floats, inverse: Floats, run: int, r: Floats, x: Floats) -> None:
    """A forward sweep for A x = r, started from x = 0 within every run."""
    n = x.shape[0]
    for b in prange((n + run - 1) // run):
        first = Index(b * run)
        for i in range(first, Index(min(n, (b + 1) * run))):
            a0, a1, a2 = r[i, 0], r[i, 1], r[i, 2]
            for k in range(Index(indptr[i]), Index(indptr[i + Index(1)])):
                j, w = Index(indices[k]), data[k]
                if j >= i:
                    break
                if j >= first:
                    a0 -= w * x[j, 0]
                    a1 -= w * x[j, 1]
                    a2 -= w * x[j, 2]
            x[i, 0], x[i, 1], x[i, 2] = a0 * inverse[i], a1 * inverse[i], a2 * inverse[i]


@compiled(parallel=True)
def sweep_up(indptr: Ints, indices: Ints, data: Floats, inverse: Floats, run: int, r: Floats, e: Floats, x: Floats) -> None:
    """A backward sweep for A e = r, started from e = 0 within every run; then x += e."""
    n = x.shape[0]
    for b in prange((n + run - 1) // run):
        end = Index(min(n, (b + 1) * run))
        i = end
        while i > Index(b * run):
            i -= Index(1)
            a0, a1, a2 = r[i, 0], r[i, 1], r[i, 2]
            k = Index(indptr[i + Index(1)])
            while k > Index(indptr[i]):
                k -= Index(1)
                j, w = Index(indices[k]), data[k]
                if j <= i:
                    break
                if j < end:
                    a0 -= w * e[j, 0]
                    a1 -= w * e[j, 1]
                    a2 -= w * e[j, 2]
            e[i, 0], e[i, 1], e[i, 2] = a0 * inverse[i], a1 * inverse[i], a2 * inverse[i]
            x[i, 0] += e[i, 0]
            x[i, 1] += e[i, 1]
            x[i, 2] += e[i, 2]

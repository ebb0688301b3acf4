"""Gauss's quadrature of an energy against frequency, by Lanczos's process and the QL iteration [golub1969]."""

from __future__ import annotations

import math

import numpy as np

from ..checks import ConvergenceError
from ..compilation import compiled, prange
from ..execution import Progress, ignore_progress, threads_for
from ..linear_solvers import CompressedRows
from ..mesh import Floats
from .polynomial import symmetric_form
from .problem import SpectralProblem

#: Rows whose products are summed up one after the other, whatever the number of threads.
_BLOCK = 4096
#: On meshes so many times as large as others a pass takes so little that several threads would wait for each other.
_SHORT_PASSES = 10
#: Iterations for an eigenvalue, of which two are usual.
_MOST_ITERATIONS = 60


def energy_quadrature(
    problem: SpectralProblem, values: Floats, steps: int, *, progress: Progress = ignore_progress
) -> tuple[Floats, Floats]:
    """Nodes kappa and weights w such that sum w f(kappa) = sum over columns of <v, f(M^-1 S) v>_M.

    The process of D = M^-1/2 S M^-1/2 that starts with M^1/2 v gives a tridiagonal matrix whose eigenvalues are the nodes. It is
    exact for polynomials f of degree 2 steps - 1. Its vectors are not orthogonalised again: rounding then repeats nodes and
    divides their weight among them, which does not change the energy of a band.

    Args:
        problem: of n rows.
        values: v, (n, 3); columns have nodes of their own.
        steps: how many; more resolve frequencies more finely.
        progress: called with the share that is done after each step; may raise to stop.

    Returns:
        (k,) nodes and (k,) weights of all columns; none if all values are 0.
    """
    symmetric = symmetric_form(problem.dirichlet, problem.mass)
    matrix = CompressedRows(symmetric.indptr, symmetric.indices.view(f"u{symmetric.indices.itemsize}"), symmetric.data)
    now = np.sqrt(problem.mass)[:, None] * values
    norms = np.sqrt(np.einsum("ij,ij->j", now, now))
    if not norms.any():
        return np.empty(0), np.empty(0)
    now /= np.where(norms > 0.0, norms, 1.0)
    steps = min(steps, len(now))
    diagonal, beside = np.zeros((steps, 3)), np.zeros((steps, 3))
    before, length = np.zeros_like(now), np.zeros(3)
    sums = np.empty((-(-len(now) // _BLOCK), 3))
    with threads_for(len(now) // _SHORT_PASSES):
        for step in range(steps):
            _apply(matrix, now, length, before, sums)
            diagonal[step] = sums.sum(axis=0)
            _subtract(now, diagonal[step], before, sums)
            beside[step] = length = np.sqrt(sums.sum(axis=0))
            before /= np.where(length > 0.0, length, 1.0)
            before, now = now, before
            progress((step + 1) / steps)
    nodes, weights = [], []
    for column in np.flatnonzero(norms):
        # An exhausted Krylov space ends with an entry that is pure rounding.
        ends = np.flatnonzero(beside[:, column] <= 1e-14 * np.abs(diagonal[:, column]).max())
        size = int(ends[0]) + 1 if len(ends) else steps
        kappa, first = diagonal[:size, column].copy(), np.zeros(size)
        first[0] = 1.0
        if not _iterated(kappa, np.append(beside[: size - 1, column], 0.0), first):
            raise ConvergenceError(f"the nodes of a quadrature of {size} steps do not converge")
        nodes.append(np.maximum(kappa, 0.0))
        weights.append((norms[column] * first) ** 2)
    return np.concatenate(nodes), np.concatenate(weights)


# See `_advance` in polynomial.py for the unsigned indices.
@compiled(parallel=True, fastmath={"contract"})
def _apply(matrix: CompressedRows, now: Floats, length: Floats, before: Floats, sums: Floats) -> None:
    """Computes before = D now - length before in place, and of each block the sums of before now."""
    indptr, indices, data = matrix
    a, b, c = length
    for block in prange(sums.shape[0]):
        p = q = r = 0.0
        for row in range(block * _BLOCK, min((block + 1) * _BLOCK, now.shape[0])):
            i = np.uint64(row)
            x = y = z = 0.0
            for entry in range(indptr[i], indptr[i + np.uint64(1)]):
                k = np.uint64(entry)
                j, value = np.uint64(indices[k]), data[k]
                x += value * now[j, 0]
                y += value * now[j, 1]
                z += value * now[j, 2]
            x -= a * before[i, 0]
            y -= b * before[i, 1]
            z -= c * before[i, 2]
            before[i, 0], before[i, 1], before[i, 2] = x, y, z
            p += x * now[i, 0]
            q += y * now[i, 1]
            r += z * now[i, 2]
        sums[block, 0], sums[block, 1], sums[block, 2] = p, q, r


@compiled(parallel=True, fastmath={"contract"})
def _subtract(now: Floats, factors: Floats, after: Floats, sums: Floats) -> None:
    """Computes after -= factors now in place, and of each block the sums of its squares."""
    a, b, c = factors
    for block in prange(sums.shape[0]):
        p = q = r = 0.0
        for row in range(block * _BLOCK, min((block + 1) * _BLOCK, now.shape[0])):
            i = np.uint64(row)
            x, y, z = after[i, 0] - a * now[i, 0], after[i, 1] - b * now[i, 1], after[i, 2] - c * now[i, 2]
            after[i, 0], after[i, 1], after[i, 2] = x, y, z
            p += x * x
            q += y * y
            r += z * z
        sums[block, 0], sums[block, 1], sums[block, 2] = p, q, r


@compiled(nogil=True)
def _iterated(diagonal: Floats, beside: Floats, first: Floats) -> bool:
    """The eigenvalues of a symmetric tridiagonal matrix in the place of its diagonal; whether all are found.

    `beside` ends with a 0; of the vectors only the first entries are found: `first` becomes (1, 0, ...) times the vectors.
    """
    n, eps = diagonal.shape[0], 2.2e-16
    for low in range(n):
        for iteration in range(_MOST_ITERATIONS + 1):
            high = low
            while high < n - 1 and abs(beside[high]) > eps * (abs(diagonal[high]) + abs(diagonal[high + 1])):
                high += 1
            if high == low:
                break
            if iteration == _MOST_ITERATIONS:
                return False
            g = (diagonal[low + 1] - diagonal[low]) / (2.0 * beside[low])
            g = diagonal[high] - diagonal[low] + beside[low] / (g + math.copysign(math.hypot(g, 1.0), g))
            sine = cosine = 1.0
            shift = 0.0
            split = False
            for i in range(high - 1, low - 1, -1):
                f, b = sine * beside[i], cosine * beside[i]
                r = math.hypot(f, g)
                beside[i + 1] = r
                if r == 0.0:
                    diagonal[i + 1] -= shift
                    split = True
                    break
                sine, cosine = f / r, g / r
                g = diagonal[i + 1] - shift
                r = (diagonal[i] - g) * sine + 2.0 * cosine * b
                shift = sine * r
                diagonal[i + 1] = g + shift
                g = cosine * r - b
                f = first[i + 1]
                first[i + 1] = sine * first[i] + cosine * f
                first[i] = cosine * first[i] - sine * f
            if not split:
                diagonal[low] -= shift
                beside[low] = g
            beside[high] = 0.0
    return True

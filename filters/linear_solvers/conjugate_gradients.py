"""Conjugate gradients for three right-hand sides at once, the same to the bit whatever the number of threads.

Sums are taken over blocks of rows of a fixed size and the blocks added up in their order, so no result depends on how the
blocks are shared out.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numba import njit, prange
from scipy import sparse

from ..execution import Progress, ignore_progress, threads_for
from ..mesh import Floats, Ints

#: Maps a residual (n, 3) to an approximate solution (n, 3): a symmetric positive definite approximation of the inverse.
Preconditioner: TypeAlias = Callable[[Floats], Floats]

# Indices are taken as unsigned numbers: for signed ones the compiler adds the test whether they count from the end.
_U: Any = np.uint64

#: Rows a block. Smaller shares out better, larger costs less.
_BLOCK = 4096


class Descent(NamedTuple):
    """Where conjugate gradients ended.

    Attributes:
        values: (n, 3) the approximate solution.
        norm: sqrt(sum r^T B r) over the columns, r the residual, B the preconditioner: about the error in the energy norm.
        iterations: how many products with the matrix it took.
        indefinite: whether a direction p with p^T A p < 0 turned up, where it ended.
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
    ``max_iterations``, or when A shows that it is not semidefinite; the caller judges which by the norm.

    Args:
        matrix: A, (n, n), with a positive diagonal.
        right_side: b, (n, 3). A column of zeros costs nothing and gives zeros.
        target: larger ends sooner.
        max_iterations: products with the matrix.
        start: (n, 3) a first guess; 0 if None.
        precondition: None divides by the diagonal (Jacobi).
        progress: called at every iteration; may raise to stop.
    """
    arrays = matrix.indptr, matrix.indices, matrix.data
    scale = 1.0 / matrix.diagonal() if precondition is None else np.ones(matrix.shape[0])
    residual = np.array(right_side, order="C")
    x = np.zeros_like(residual) if start is None else np.array(start, order="C")
    product = np.empty_like(residual)
    with threads_for(len(x)):
        if start is not None:
            residual -= _times(arrays, x, product)

        def next_direction(plain: Floats) -> tuple[Floats, Floats]:
            if precondition is None:
                return residual, plain
            z = precondition(residual)
            return z, _inner(residual, z)

        z, energy = next_direction(_descend(np.zeros(3), residual, residual, x, residual, scale))
        direction = z * scale[:, None]
        first = norm = _root(energy)
        indefinite = False
        for iteration in range(max_iterations + 1):
            if norm <= target or iteration == max_iterations:
                break
            progress(_share_done(first, norm, target))
            curvature = _multiply(*arrays, direction, product)
            indefinite = not (curvature >= 0.0).all()
            if indefinite:
                break
            steps = np.divide(energy, curvature, out=np.zeros(3), where=curvature > 0.0)
            z, new_energy = next_direction(_descend(steps, direction, product, x, residual, scale))
            _turn(np.divide(new_energy, energy, out=np.zeros(3), where=energy > 0.0), z, scale, direction)
            energy = new_energy
            norm = _root(energy)
    return Descent(x, norm, iteration, indefinite)


def preconditioned_norm(matrix: sparse.csr_matrix, residual: Floats, precondition: Preconditioner | None = None) -> float:
    """sqrt(sum r^T B r) over the columns of an (n, 3) residual, B as in `conjugate_gradients`."""
    with threads_for(len(residual)):
        if precondition is None:
            return _root(_inner(residual, residual / matrix.diagonal()[:, None]))
        return _root(_inner(residual, precondition(residual)))


def _times(arrays: tuple[Any, Any, Any], x: Floats, product: Floats) -> Floats:
    _multiply(*arrays, x, product)
    return product


def _root(energy: Floats) -> float:
    return float(np.sqrt(energy.sum())) if (energy >= 0.0).all() else np.inf


def _share_done(first: float, norm: float, target: float) -> float:
    if not 0.0 < target < norm <= first < np.inf:
        return 0.0
    return float(np.log(first / norm) / np.log(first / target))


@njit(cache=True)
def _add_up(parts: Floats) -> Floats:
    total = np.zeros(3)
    for b in range(parts.shape[0]):
        for c in range(3):
            total[c] += parts[b, c]
    return total


@njit(cache=True, parallel=True)
def _multiply(indptr: Ints, indices: Ints, data: Floats, p: Floats, q: Floats) -> Floats:
    """Q = A p; the three p^T q."""
    n = p.shape[0]
    parts = np.zeros(((n + _BLOCK - 1) // _BLOCK, 3))
    for b in prange(parts.shape[0]):
        s0, s1, s2 = 0.0, 0.0, 0.0
        for i in range(_U(b * _BLOCK), _U(min(n, (b + 1) * _BLOCK))):
            a0, a1, a2 = 0.0, 0.0, 0.0
            for k in range(_U(indptr[i]), _U(indptr[i + _U(1)])):
                j, w = _U(indices[k]), data[k]
                a0 += w * p[j, 0]
                a1 += w * p[j, 1]
                a2 += w * p[j, 2]
            q[i, 0], q[i, 1], q[i, 2] = a0, a1, a2
            s0 += a0 * p[i, 0]
            s1 += a1 * p[i, 1]
            s2 += a2 * p[i, 2]
        parts[b, 0], parts[b, 1], parts[b, 2] = s0, s1, s2
    return _add_up(parts)


@njit(cache=True, parallel=True)
def _descend(steps: Floats, p: Floats, q: Floats, x: Floats, r: Floats, scale: Floats) -> Floats:
    """X += steps p, r -= steps q; the three r^T diag(scale) r."""
    n = p.shape[0]
    t0, t1, t2 = steps[0], steps[1], steps[2]
    parts = np.zeros(((n + _BLOCK - 1) // _BLOCK, 3))
    for b in prange(parts.shape[0]):
        s0, s1, s2 = 0.0, 0.0, 0.0
        for i in range(_U(b * _BLOCK), _U(min(n, (b + 1) * _BLOCK))):
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


@njit(cache=True, parallel=True)
def _turn(turns: Floats, z: Floats, scale: Floats, p: Floats) -> None:
    """P = diag(scale) z + turns p."""
    n = p.shape[0]
    t0, t1, t2 = turns[0], turns[1], turns[2]
    for b in prange((n + _BLOCK - 1) // _BLOCK):
        for i in range(_U(b * _BLOCK), _U(min(n, (b + 1) * _BLOCK))):
            p[i, 0] = scale[i] * z[i, 0] + t0 * p[i, 0]
            p[i, 1] = scale[i] * z[i, 1] + t1 * p[i, 1]
            p[i, 2] = scale[i] * z[i, 2] + t2 * p[i, 2]


@njit(cache=True, parallel=True)
def _inner(r: Floats, z: Floats) -> Floats:
    """The three r^T z."""
    n = r.shape[0]
    parts = np.zeros(((n + _BLOCK - 1) // _BLOCK, 3))
    for b in prange(parts.shape[0]):
        s0, s1, s2 = 0.0, 0.0, 0.0
        for i in range(_U(b * _BLOCK), _U(min(n, (b + 1) * _BLOCK))):
            s0 += r[i, 0] * z[i, 0]
            s1 += r[i, 1] * z[i, 1]
            s2 += r[i, 2] * z[i, 2]
        parts[b, 0], parts[b, 1], parts[b, 2] = s0, s1, s2
    return _add_up(parts)

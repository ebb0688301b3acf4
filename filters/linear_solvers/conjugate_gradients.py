"""Conjugate gradients for three right-hand sides at once, with the same bits for any number of threads.

Written here because SciPy's take one right-hand side and are slower; docs/solvers.md has the times.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from ..execution import Progress, ignore_progress, threads_for
from ..libraries import sparse
from ..mesh import Floats
from .conjugate_gradient_steps import descend, inner_products, multiply, next_direction

#: Maps a residual (n, 3) to an approximate solution (n, 3): a symmetric positive definite approximation of the inverse.
Preconditioner: TypeAlias = Callable[[Floats], Floats]


class Descent(NamedTuple):
    """Where conjugate gradients ended.

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
    arrays = matrix.indptr, matrix.indices, matrix.data
    scale = 1.0 / matrix.diagonal() if precondition is None else np.ones(matrix.shape[0])
    residual = np.array(right_side, order="C")
    x = np.zeros_like(residual) if start is None else np.array(start, order="C")
    product = np.empty_like(residual)
    with threads_for(len(x)):
        if start is not None:
            multiply(*arrays, x, product)
            residual -= product

        def preconditioned(squares: Floats) -> tuple[Floats, Floats]:
            """The residual after the preconditioner, z = B r, and the three r^T z, given r^T diag(scale) r."""
            if precondition is None:
                return residual, squares
            z = precondition(residual)
            return z, inner_products(residual, z)

        z, energy = preconditioned(descend(np.zeros(3), residual, residual, x, residual, scale))
        direction = z * scale[:, None]
        first = norm = _root(energy)
        indefinite = False
        for iteration in range(max_iterations + 1):
            if norm <= target or iteration == max_iterations:
                break
            progress(_share_done(first, norm, target))
            curvature = multiply(*arrays, direction, product)
            indefinite = not (curvature >= 0.0).all()
            if indefinite:
                break
            steps = np.divide(energy, curvature, out=np.zeros(3), where=curvature > 0.0)
            z, new_energy = preconditioned(descend(steps, direction, product, x, residual, scale))
            next_direction(np.divide(new_energy, energy, out=np.zeros(3), where=energy > 0.0), z, scale, direction)
            energy = new_energy
            norm = _root(energy)
    return Descent(x, norm, iteration, indefinite)


def preconditioned_norm(matrix: sparse.csr_matrix, residual: Floats, precondition: Preconditioner | None = None) -> float:
    """sqrt(sum r^T B r) over the columns of an (n, 3) residual, B as in `conjugate_gradients`."""
    with threads_for(len(residual)):
        if precondition is None:
            return _root(inner_products(residual, residual / matrix.diagonal()[:, None]))
        return _root(inner_products(residual, precondition(residual)))


def _root(energy: Floats) -> float:
    return float(np.sqrt(energy.sum())) if (energy >= 0.0).all() else np.inf


def _share_done(first: float, norm: float, target: float) -> float:
    if not 0.0 < target < norm <= first < np.inf:
        return 0.0
    return float(np.log(first / norm) / np.log(first / target))

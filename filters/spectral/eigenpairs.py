"""The lowest eigenvalues and eigenvectors of a spectral problem, without gaps."""

from __future__ import annotations

import numpy as np

from ..checks import check_whole_number
from ..execution import Progress, ignore_progress, part_of, threads_for
from ..libraries import one_blas_thread, sparse
from ..mesh import Floats
from .component_modes import component_modes
from .problem import SpectralProblem


def lowest_eigenpairs(
    problem: SpectralProblem,
    count: int,
    *,
    constants: bool = True,
    tolerance: float = 1e-9,
    progress: Progress = ignore_progress,
) -> tuple[Floats, Floats]:
    """The `count` lowest modes: S v = kappa M v with V^T M V = I.

    Each connected component is solved by itself, by spectrum slicing (`lowest_modes`) or, if small, as a dense matrix. Both count
    eigenvalues, so that none is missed. The first mode of a component is constant and positive, with kappa 0; the sign of every
    other mode makes its product with one fixed random function positive.

    Args:
        problem: of n vertices.
        count: how many modes, from 0; if there are fewer, all.
        constants: False leaves out the constant mode of every component; `count` then counts the others.
        tolerance: the largest residual |S v - kappa M v| in the norm of M^-1, as a share of kappa. Where triangles differ so
            much in size that rounding alone is more, it is 1e-6 in that norm or in that of (S + kappa_1 M)^-1, times sqrt(kappa).
        progress: called several times a second with the share that is done; may raise to stop. On a mesh of 100,000 vertices
            the longest time between two calls is half a second, and it grows with size.

    Returns:
        kappa, (k,) ascending, in one over squared mesh units, and V, (n, k), Fortran-ordered, whose columns are the modes. The
        same to the bit in every run, for any number of threads.

    Raises:
        FilterInputError: the count is not a whole number of at least 0.
        ConvergenceError: the residual is not reached, as for most of the modes of a mesh whose triangles differ in size by ten
            orders of magnitude.
    """
    n = len(problem.mass)
    count = min(check_whole_number("count", count), n if constants else n - problem.n_components)
    if count == 0:
        return np.zeros(0), np.zeros((n, 0), order="F")
    # Sums in another order would change bits, and BLAS orders them by its number of threads.
    with one_blas_thread():
        return _united(problem, count, 0 if constants else 1, tolerance, progress)


def _united(problem: SpectralProblem, count: int, skipped: int, tolerance: float, progress: Progress) -> tuple[Floats, Floats]:
    """The lowest modes of all components together, less the first `skipped` of each.

    Each component first gives as many as its share of the area predicts, then more until none can be missing.
    """
    n, parts = len(problem.mass), problem.n_components
    sizes = np.bincount(problem.components, minlength=parts)
    ends = np.cumsum(sizes)
    together = np.argsort(problem.components, kind="stable")
    rows = np.split(together, ends[:-1])
    dirichlet = problem.dirichlet if parts == 1 else sparse.csr_matrix(problem.dirichlet[together][:, together])
    area = np.bincount(problem.components, problem.mass)
    asked = np.minimum(sizes, np.ceil(count * area / area.sum()).astype(np.int64) + (2 if parts > 1 else skipped))
    solved: list[tuple[Floats, Floats] | None] = [None] * parts
    while True:
        weight = asked * sizes
        shares = np.concatenate([[0.0], np.cumsum(weight)]) / weight.sum()
        for c in range(parts):
            found = solved[c]
            if found is None or len(found[0]) < asked[c]:
                partial = part_of(progress, float(shares[c]), float(shares[c + 1]))
                block = _block(dirichlet, int(ends[c] - sizes[c]), int(ends[c]))
                with threads_for(10 * int(sizes[c])):
                    solved[c] = component_modes(block, problem.mass[rows[c]], int(asked[c]), tolerance, partial)
        done = [pair for pair in solved if pair is not None]
        kappa = np.concatenate([pair[0][skipped:] for pair in done])
        owner = np.repeat(np.arange(parts), [len(pair[0]) - skipped for pair in done])
        order = np.argsort(kappa, kind="stable")[:count]
        last = kappa[order[-1]] if len(order) else np.inf
        # A component whose highest mode is among the chosen may have more modes that belong to them.
        most = np.minimum(sizes, count + skipped)
        short = np.array([len(pair[0]) < enough and pair[0][-1] <= last for pair, enough in zip(done, most, strict=True)])
        if len(order) == count and (parts == 1 or not short.any()):
            break
        asked = np.where(short, np.minimum(most, 2 * asked + 4), asked)
        if not short.any():
            break
    modes = np.zeros((n, len(order)), order="F")
    first = np.concatenate([[0], np.cumsum([len(pair[0]) - skipped for pair in done])])
    for column, place in enumerate(order):
        c = owner[place]
        modes[rows[c], column] = done[c][1][:, skipped + place - first[c]]
    progress(1.0)
    return kappa[order], modes


def _block(matrix: sparse.csr_matrix, start: int, end: int) -> sparse.csr_matrix:
    """The rows and columns from `start` to `end`, whose entries all lie within."""
    if end - start == matrix.shape[0]:
        return matrix
    entries = slice(matrix.indptr[start], matrix.indptr[end])
    pointers = matrix.indptr[start : end + 1] - matrix.indptr[start]
    return sparse.csr_matrix((matrix.data[entries], matrix.indices[entries] - start, pointers), shape=(end - start, end - start))

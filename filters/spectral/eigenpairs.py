"""The lowest eigenvalues and eigenvectors of a spectral problem, all of them: none is left out."""

import numpy as np
from scipy import sparse
from threadpoolctl import threadpool_limits

from ..checks import FilterInputError
from ..execution import Progress, ignore_progress, threads_for
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

    Each connected component is solved for by itself, by spectrum slicing (`lowest_modes`) or, if small, as a dense matrix. Both
    count eigenvalues instead of trusting that none was missed. The first mode of a component is constant and positive, with kappa
    0; the sign of every other makes its product with one random function, the same for all, positive.

    Args:
        problem: of n vertices.
        count: how many modes, from 0; more than there are give all.
        constants: False leaves out the mode of every component that is constant there: `count` is that of the others.
        tolerance: the largest residual |S v - kappa M v| in the norm of M^-1, as a share of kappa. Where triangles differ so
            much in size that rounding alone is more, it is 1e-6 in that norm or in that of (S + kappa_1 M)^-1, times sqrt(kappa).
        progress: called several times a second with the share that is done; may raise to stop. On a mesh of 100,000 vertices
            the longest silence is half a second, and it grows with size.

    Returns:
        kappa, (k,) ascending, in one over squared mesh units, and V, (n, k), Fortran-ordered, whose columns are the modes. The
        same to the bit in every run, for any number of threads.

    Raises:
        FilterInputError: a negative count.
        ConvergenceError: the residual is not reached, as for most of the modes of a mesh whose triangles differ in size by ten
            orders of magnitude.
    """
    if count != int(count) or count < 0:
        raise FilterInputError(f"count is {count}: it is a whole number of at least 0")
    n = len(problem.mass)
    count = min(int(count), n if constants else n - problem.n_components)
    if count == 0:
        return np.zeros(0), np.zeros((n, 0), order="F")
    # Sums in another order would change bits, and BLAS orders them by its number of threads.
    with threadpool_limits(limits=1, user_api="blas"):
        return _united(problem, count, 0 if constants else 1, tolerance, progress)


def _united(problem: SpectralProblem, count: int, skipped: int, tolerance: float, progress: Progress) -> tuple[Floats, Floats]:
    """The lowest of all components, less the first `skipped` of each.

    From each as many are computed as its share of the area promises, and more until none can be missing.
    """
    n, parts = len(problem.mass), problem.n_components
    sizes = np.bincount(problem.components, minlength=parts)
    ends = np.cumsum(sizes)
    together = np.argsort(problem.components, kind="stable")
    rows = np.split(together, ends[:-1])
    stiffness = problem.stiffness if parts == 1 else sparse.csr_matrix(problem.stiffness[together][:, together])
    area = np.bincount(problem.components, problem.mass)
    asked = np.minimum(sizes, np.ceil(count * area / area.sum()).astype(np.int64) + (2 if parts > 1 else skipped))
    solved: list[tuple[Floats, Floats] | None] = [None] * parts
    while True:
        weight = asked * sizes
        before, total = 0.0, float(weight.sum())
        for c in range(parts):
            found = solved[c]
            if found is None or len(found[0]) < asked[c]:

                def partial(share: float, done: float = before, part: float = float(weight[c]), whole: float = total) -> None:
                    progress(min(1.0, (done + part * share) / whole))

                block = _block(stiffness, int(ends[c] - sizes[c]), int(ends[c]))
                with threads_for(10 * int(sizes[c])):
                    solved[c] = component_modes(block, problem.mass[rows[c]], int(asked[c]), tolerance, partial)
            before += float(weight[c])
        done = [pair for pair in solved if pair is not None]
        kappa = np.concatenate([pair[0][skipped:] for pair in done])
        owner = np.repeat(np.arange(parts), [len(pair[0]) - skipped for pair in done])
        order = np.argsort(kappa, kind="stable")[:count]
        last = kappa[order[-1]] if len(order) else np.inf
        # A component whose highest mode is still among the chosen may have more that belong there.
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
    """Rows and columns from `start` to `end`, which have no entries outside."""
    if end - start == matrix.shape[0]:
        return matrix
    entries = slice(matrix.indptr[start], matrix.indptr[end])
    pointers = matrix.indptr[start : end + 1] - matrix.indptr[start]
    return sparse.csr_matrix((matrix.data[entries], matrix.indices[entries] - start, pointers), shape=(end - start, end - start))

"""The lowest eigenvalues and eigenvectors of a spectral problem, all of them: none is left out."""

import numpy as np
from scipy import sparse
from threadpoolctl import threadpool_limits

from ..errors import ConvergenceError, FilterInputError
from ..mesh import Floats
from ..parallel import threads_for
from ..progress import Progress, ignore_progress
from .abandonable import abandonable
from .columnwise import groups, sparse_product
from .nested_dissection import nested_dissection
from .problem import SpectralProblem
from .spectrum_slicing import lowest_modes

#: Up to this many vertices, or while more than one in `_DENSE_SHARE` modes are asked for up to the second, the matrix is dense.
_DENSE, _DENSE_SHARE, _DENSE_LIMIT = 600, 8, 4000


def lowest_eigenpairs(
    problem: SpectralProblem, count: int, *, tolerance: float = 1e-9, progress: Progress = ignore_progress
) -> tuple[Floats, Floats]:
    """The `count` lowest modes: S v = kappa M v with V^T M V = I.

    Each connected component is solved for by itself, by spectrum slicing (`lowest_modes`) or, if small, as a dense matrix. Both
    count eigenvalues instead of trusting that none was missed. The first mode of a component is constant and positive, with kappa
    0; the sign of every other makes its product with one random function, the same for all, positive.

    Args:
        problem: of n vertices.
        count: how many modes, from 0; more than n give n.
        tolerance: the largest residual |S v - kappa M v| in the norm of M^-1, as a share of kappa.
        progress: called several times a second with the share that is done; may raise to stop. On a mesh of 100,000 vertices
            the longest silence is half a second, and it grows with size.

    Returns:
        kappa, (k,) ascending, in one over squared mesh units, and V, (n, k), Fortran-ordered, whose columns are the modes. The
        same to the bit in every run, for any number of threads.

    Raises:
        FilterInputError: a negative count.
        ConvergenceError: the residual is not reached.
    """
    if count != int(count) or count < 0:
        raise FilterInputError(f"count is {count}: it is a whole number of at least 0")
    n = len(problem.mass)
    count = min(int(count), n)
    if count == 0:
        return np.zeros(0), np.zeros((n, 0), order="F")
    # Sums in another order would change bits, and BLAS orders them by its number of threads.
    with threadpool_limits(limits=1, user_api="blas"), threads_for(10 * n):
        return _united(problem, count, tolerance, progress)


def _united(problem: SpectralProblem, count: int, tolerance: float, progress: Progress) -> tuple[Floats, Floats]:
    """The lowest of all components: from each as many as its share of the area promises, and more until none can be missing."""
    n, parts = len(problem.mass), problem.n_components
    rows = [np.flatnonzero(problem.components == c) for c in range(parts)] if parts > 1 else [np.arange(n)]
    area = np.array([problem.mass[row].sum() for row in rows])
    sizes = np.array([len(row) for row in rows])
    asked = np.minimum(sizes, np.ceil(count * area / area.sum()).astype(np.int64) + (2 if parts > 1 else 0))
    solved: list[tuple[Floats, Floats] | None] = [None] * parts
    while True:
        weight = asked * sizes
        before, total = 0.0, float(weight.sum())
        for c in range(parts):
            found = solved[c]
            if found is None or len(found[0]) < asked[c]:

                def partial(share: float, done: float = before, part: float = float(weight[c]), whole: float = total) -> None:
                    progress(min(1.0, (done + part * share) / whole))

                solved[c] = _connected(problem, rows[c], int(asked[c]), tolerance, partial)
            before += float(weight[c])
        done = [pair for pair in solved if pair is not None]
        kappa = np.concatenate([pair[0] for pair in done])
        owner = np.repeat(np.arange(parts), [len(pair[0]) for pair in done])
        order = np.argsort(kappa, kind="stable")[:count]
        last = kappa[order[-1]]
        # A component whose highest mode is still among the chosen may have more that belong there.
        short = np.array([len(pair[0]) < size and pair[0][-1] <= last for pair, size in zip(done, sizes, strict=True)])
        if len(order) == count and (parts == 1 or not short.any()):
            break
        asked = np.where(short, np.minimum(sizes, np.minimum(count, 2 * asked + 4)), asked)
        if parts > 1 and (asked == [len(pair[0]) for pair in done]).all():
            break
    modes = np.zeros((n, count), order="F")
    first = np.concatenate([[0], np.cumsum([len(pair[0]) for pair in done])])
    for column, place in enumerate(order):
        c = owner[place]
        modes[rows[c], column] = done[c][1][:, place - first[c]]
    progress(1.0)
    return kappa[order], modes


def _connected(
    problem: SpectralProblem, rows: np.ndarray, count: int, tolerance: float, progress: Progress
) -> tuple[Floats, Floats]:
    """The lowest modes of one component, with the residuals checked, in a unit of area in which the component has 4 pi."""
    part = problem.stiffness if len(rows) == len(problem.mass) else sparse.csr_matrix(problem.stiffness[rows][:, rows])
    unit = problem.mass[rows].sum() / (4.0 * np.pi)
    mass = problem.mass[rows] / unit
    root = np.sqrt(mass)
    scaling = sparse.diags_array(1.0 / root)
    operator = sparse.csc_matrix(scaling @ part @ scaling)
    n = len(rows)
    if n <= _DENSE or (n <= _DENSE_LIMIT and count * _DENSE_SHARE > n):
        # Numpy's, since it lets other threads run.
        vectors = abandonable(lambda: np.linalg.eigh(operator.toarray())[1], progress, 0.5)[:, :count]
    else:
        places = nested_dissection(operator)
        dissected = sparse.csc_matrix(operator[places][:, places])
        kernel = root[places] / np.linalg.norm(root)
        _, found = lowest_modes(dissected, kernel, count, tolerance=tolerance, progress=progress)
        vectors = np.empty_like(found)
        vectors[places] = found
    vectors = np.asfortranarray(vectors)
    vectors[:, 0] = root / np.linalg.norm(root)
    kappa, rest = np.empty(count), np.empty(count)
    for group in groups(count, progress, 0.99):
        part_of = vectors[:, group]
        applied = sparse_product(operator, part_of)
        kappa[group] = np.einsum("ij,ij->j", part_of, applied) / np.einsum("ij,ij->j", part_of, part_of)
        rest[group] = np.linalg.norm(applied - part_of * kappa[group], axis=0)
    kappa[0] = 0.0
    if count > 1:
        residual = rest / np.maximum(kappa, max(kappa[1], np.finfo(float).tiny))
        # Rounding of the product alone.
        floor = 4e-15 * float(np.abs(operator).sum(axis=0).max()) / kappa[1]
        if not residual.max() <= max(tolerance, floor):
            raise ConvergenceError(
                f"mode {int(residual.argmax())} of a component of {n} vertices has a residual of {residual.max():.3g} of its "
                f"eigenvalue, {tolerance:.3g} was asked for"
            )
    order = np.argsort(kappa, kind="stable")
    kappa, vectors = kappa[order], vectors[:, order]
    random = np.random.default_rng(0).normal(size=n)
    random[:] = np.where(random @ vectors[:, 0] < 0.0, -random, random)
    signs = np.where(random @ vectors < 0.0, -1.0, 1.0)
    vectors *= signs
    vectors /= root[:, None]
    vectors /= np.sqrt(unit)
    return kappa / unit, vectors

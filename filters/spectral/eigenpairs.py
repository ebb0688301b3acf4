"""Manifold harmonics: the lowest eigenpairs of a spectral problem, none missing, and single modes as values at the vertices.

Large sparse operators are solved by spectrum slicing: band by band, and the eigenvalues of each band are counted. SciPy's ARPACK
searches near one shift and does not count, so it may miss eigenvalues.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..checks import ConvergenceError, FilterInputError, check_whole_number
from ..compilation import compiled, prange
from ..execution import Progress, abandonable, ignore_progress, part_of, threads_for
from ..libraries import blas, linalg, one_blas_thread, sparse
from ..linear_solvers import CompressedRows, Fronts, ShiftedFactors
from ..mesh import Floats
from ..operators import SurfaceOperatorName
from .problem import SpectralProblem, spectral_problem

#: Dense solvers take matrices of up to `_DENSE` rows, or `_DENSE_LIMIT` if more than one in `_DENSE_SHARE` modes is wanted.
_DENSE, _DENSE_SHARE, _DENSE_LIMIT = 600, 8, 4000
#: Dense matrices of at most this many rows are solved in the calling thread.
_AT_ONCE = 200
#: A dense solver's error is the rounding of the highest eigenvalue, which may hide the lowest eigenvalues. Then spectrum slicing,
#: whose rounding is relative to each row, takes over if 20 + `_SLICED_SHARE` x the wanted modes are at most the number of rows.
_SLICED_SHARE = 2
#: The largest residual that is accepted as rounding, and the largest accepted deviation of modes from orthonormality.
_LARGEST_FLOOR = 1e-6
#: Modes per band, below `_LARGE` rows and from there on. Wide bands need more orthogonalisation, narrow ones more factorisations.
_BAND, _BAND_OF_LARGE, _LARGE = 100, 160, 50_000
#: Modes that are computed beyond the last requested one. The last shift goes into the widest gap between them.
_GUARD = 6
_ROUNDS = 10_000  # the most bands
_POLISHES = 3  # the most refinements of the modes of a band
#: Columns of a Lanczos block, which are solved together. An eigenvalue whose multiplicity exceeds this takes a second search.
BLOCK = 8
#: Sizes of the Lanczos basis as multiples of the number of modes: at the first test of convergence and at the limit. Between
#: tests the basis grows by the factor `_GROWTH`.
_FIRST_TEST, _GROWTH, _LIMIT = 1.6, 1.1, 8.0
#: Vectors added to the size at the first test, and ten times as many to the limit.
_SMALL = 40
#: After this many blocks a block is made orthogonal to the locked (known) modes again: rounding slowly brings them back.
_RENEWAL = 2
#: Columns that are processed between two calls of `progress`.
_TOGETHER = 16


def lowest_eigenpairs(
    problem: SpectralProblem, count: int, *, constants: bool = True, tolerance: float = 1e-9, progress: Progress = ignore_progress
) -> tuple[Floats, Floats]:
    """Computes the `count` lowest modes: S v = kappa M v with V^T M V = I.

    Each connected component is solved by itself, by spectrum slicing (`lowest_modes`) or, if small, as a dense matrix. The first
    mode of a component is a positive constant with kappa 0. Every other mode has the sign that makes its inner product with one
    fixed random vector positive.

    Args:
        problem: S, M and the components, n rows.
        count: the number of modes, from 0; all modes if there are fewer.
        constants: False leaves out the constant mode of every component; `count` then counts the other modes.
        tolerance: the largest residual |S v - kappa M v| in the norm of M^-1, as a share of kappa. Rounding errors of
            up to 1e-6 kappa, or 1e-6 sqrt(kappa) in the norm of (S + kappa_1 M)^-1 with the least kappa_1 > 0, are accepted.
        progress: called with the share that is done; may raise to stop. The longest time between two calls is half a second at
            100,000 vertices, and grows with the mesh.

    Returns:
        kappa, (k,) ascending, in one over squared mesh units; and V, (n, k) Fortran-ordered, a mode per column. Both are the same
        to the bit in every run, for any number of threads.

    Raises:
        FilterInputError: the count is not a whole number of at least 0.
        ConvergenceError: residuals stay too large. This happens to most modes if triangles differ in size by ten orders of
            magnitude.
    """
    n = len(problem.mass)
    count = min(check_whole_number("count", count), n if constants else problem.n_waves)
    if count == 0:
        return np.zeros(0), np.zeros((n, 0), order="F")
    # The number of BLAS threads changes the order of sums, and so their last bits.
    with one_blas_thread():
        return _merge(problem, count, 0 if constants else 1, tolerance, progress)


def _merge(problem: SpectralProblem, count: int, skipped: int, tolerance: float, progress: Progress) -> tuple[Floats, Floats]:
    """Merges the lowest modes of all components, without the first `skipped` of each; areas predict the number per component."""
    parts = problem.n_components
    sizes = np.bincount(problem.components, minlength=parts)
    ends = np.cumsum(sizes)
    sorted_rows = np.argsort(problem.components, kind="stable")
    rows = np.split(sorted_rows, ends[:-1])
    dirichlet = sparse.csr_matrix(problem.dirichlet[sorted_rows][:, sorted_rows])
    area = np.bincount(problem.components, problem.mass)
    counts = np.minimum(sizes, np.ceil(count * area / area.sum()).astype(np.int64) + (2 if parts > 1 else skipped))
    solved = [(np.zeros(0), np.zeros((size, 0))) for size in sizes]
    while True:
        weight = counts * sizes
        shares = np.concatenate([[0.0], np.cumsum(weight)]) / weight.sum()
        for c in range(parts):
            if len(solved[c][0]) < counts[c]:
                partial = part_of(progress, float(shares[c]), float(shares[c + 1]))
                span = slice(int(ends[c] - sizes[c]), int(ends[c]))
                block = sparse.csr_matrix(dirichlet[span, span])
                with threads_for(10 * int(sizes[c])):
                    solved[c] = component_modes(block, problem.mass[rows[c]], int(counts[c]), tolerance, partial)
        kappa = np.concatenate([pair[0][skipped:] for pair in solved])
        component_of = np.repeat(np.arange(parts), [len(pair[0]) - skipped for pair in solved])
        order = np.argsort(kappa, kind="stable")[:count]
        last = kappa[order[-1]] if len(order) else np.inf
        # If the highest computed mode of a component is among the chosen ones, the component's next mode may belong to them too.
        most = np.minimum(sizes, count + skipped)
        incomplete = np.array([len(pair[0]) < enough and pair[0][-1] <= last for pair, enough in zip(solved, most, strict=True)])
        if not incomplete.any():
            break
        counts = np.where(incomplete, np.minimum(most, 2 * counts + 4), counts)
    modes = np.zeros((len(sorted_rows), len(order)), order="F")
    first = np.concatenate([[0], np.cumsum([len(pair[0]) - skipped for pair in solved])])
    for column, place in enumerate(order):
        c = component_of[place]
        modes[rows[c], column] = solved[c][1][:, skipped + place - first[c]]
    progress(1.0)
    return kappa[order], modes


def component_modes(
    part: sparse.csr_matrix, area: Floats, count: int, tolerance: float, progress: Progress
) -> tuple[Floats, Floats]:
    """Computes the lowest modes of one component, from its block of S and its diagonal of M; checks the residuals."""
    unit = area.sum() / (4.0 * np.pi)
    root = np.sqrt(area / unit)
    n = len(root)
    if count == 1:
        return np.zeros(1), np.full((n, 1), 1.0 / np.sqrt(area.sum()), order="F")
    # The matrix is symmetric, so its rows serve as columns.
    data = part.data / (np.repeat(root, np.diff(part.indptr)) * root[part.indices])
    operator = sparse.csc_matrix((data, part.indices, part.indptr), shape=part.shape)
    kernel = root / np.linalg.norm(root)
    # The largest sum of the absolute values in a column bounds the highest eigenvalue.
    highest = float(np.bincount(part.indices, np.abs(data), n).max())
    dense = n <= _DENSE or (n <= _DENSE_LIMIT and count * _DENSE_SHARE > n)
    sliceable = count * _SLICED_SHARE + 20 <= n
    modes = _by_dense_matrix(operator, kernel, count, progress) if dense else None
    if modes is None or (sliceable and not modes.good(tolerance, 0.0)):
        modes = _by_slicing(operator, kernel, count, tolerance, highest, progress)
    if not modes.good(tolerance, highest):
        raise ConvergenceError(
            f"the {count} lowest modes of a component of {n} vertices are lost in rounding: mode "
            f"{int(modes.residuals.argmax())} has a residual of {modes.residuals.max():.3g} times its eigenvalue (the tolerance "
            f"is {tolerance:.3g}), and the highest eigenvalue is up to {highest / modes.least:.3g} times the lowest above 0: "
            "triangles differ too much in size or shape; take fewer modes, filter without eigenvectors, or remesh"
        )
    order = np.argsort(modes.kappa, kind="stable")
    kappa, vectors = modes.kappa[order], modes.vectors[:, order]
    random = np.random.default_rng(0).normal(size=n)
    random[:] = np.where(random @ vectors[:, 0] < 0.0, -random, random)
    vectors *= np.where(random @ vectors < 0.0, -1.0, 1.0)
    vectors /= root[:, None]
    vectors /= np.sqrt(unit)
    return kappa / unit, vectors


class _CheckedModes:
    """Orthonormal vectors, the first in the kernel, with Rayleigh quotients kappa and residuals |A x - kappa x| / kappa."""

    def __init__(self, operator: sparse.csc_matrix, kernel: Floats, vectors: Floats, progress: Progress) -> None:
        """May overwrite the vectors; sets the first to the kernel."""
        count = vectors.shape[1]
        self.vectors = np.asfortranarray(vectors)
        self.vectors[:, 0] = kernel
        self.kappa, norms = np.empty(count), np.empty(count)
        for group in groups(count, progress, 0.99):
            columns = self.vectors[:, group]
            applied = sparse_product(operator, columns)
            self.kappa[group] = np.einsum("ij,ij->j", columns, applied) / np.einsum("ij,ij->j", columns, columns)
            norms[group] = np.linalg.norm(applied - columns * self.kappa[group], axis=0)
        self.kappa[0] = 0.0
        self.least = max(float(self.kappa[1]), float(np.finfo(float).tiny))
        self.residuals = norms / np.maximum(self.kappa, self.least)
        # V^T V w = w for a random w if V^T V = I.
        weights = np.random.default_rng(1).normal(size=count) / np.sqrt(count)
        again = blas.dgemv(1.0, self.vectors, blas.dgemv(1.0, self.vectors, weights), trans=1)
        self._deviation = float(np.abs(again - weights).max())

    def good(self, tolerance: float, highest: float) -> bool:
        """Whether the vectors are orthonormal and the residuals within the tolerance, or within rounding if that is larger."""
        floor = min(4e-15 * highest / self.least, _LARGEST_FLOOR)
        return bool(self.residuals.max() <= max(tolerance, floor) and self._deviation <= _LARGEST_FLOOR)


def _by_dense_matrix(operator: sparse.csc_matrix, kernel: Floats, count: int, progress: Progress) -> _CheckedModes:
    def solved() -> Floats:  # by NumPy, because it releases the GIL
        return np.asarray(np.linalg.eigh(operator.toarray())[1])

    progress(0.0)
    vectors = solved() if len(kernel) <= _AT_ONCE else abandonable(solved, progress, 0.5)
    return _CheckedModes(operator, kernel, vectors[:, :count], progress)


def _by_slicing(
    operator: sparse.csc_matrix, kernel: Floats, count: int, tolerance: float, highest: float, progress: Progress
) -> _CheckedModes:
    fronts = Fronts.of(operator)
    places, fronts = fronts.order, fronts.in_order()
    dissected = sparse.csc_matrix(operator[places][:, places])
    _, ordered = lowest_modes(dissected, fronts, kernel[places], count, tolerance=tolerance, progress=progress)
    vectors = np.empty_like(ordered)
    vectors[places] = ordered
    modes = _CheckedModes(operator, kernel, vectors, progress)
    if not modes.good(tolerance, highest):
        # Residuals at tiny triangles have high frequencies, which hardly count in the norm of the inverse: take the smaller norm.
        factors = ShiftedFactors(dissected, fronts, -modes.least, progress, 0.99)
        for group in groups(count, progress, 0.99):
            columns = np.asfortranarray(modes.vectors[places, group])
            residual_vectors = sparse_product(dissected, columns) - columns * modes.kappa[group]
            energy = np.einsum("ij,ij->j", residual_vectors, factors.solve(np.asfortranarray(residual_vectors)))
            share = np.sqrt(np.maximum(energy, 0.0) / np.maximum(modes.kappa[group], modes.least))
            modes.residuals[group] = np.minimum(modes.residuals[group], share)
    return modes


@dataclass(frozen=True, eq=False)
class OneHarmonic:
    """A mode with a mean square of 1 over the whole surface."""

    values: Floats  # (n,) at the vertices; waves are 0 on all components but one; 0 at vertices without a row in the problem
    eigenvalue: float  # kappa, in one over squared mesh units
    share_of_area: float  # of the components where the mode is not 0
    n_components: int


def one_harmonic(
    vertices: ArrayLike,
    faces: ArrayLike,
    mode: int,
    *,
    operator: SurfaceOperatorName = "auto",
    progress: Progress = ignore_progress,
) -> OneHarmonic:
    """Returns mode 0, constant on the whole surface, or mode k, the k-th lowest wave of all components [vallet2008].

    If several waves share one frequency, as on a sphere, a mode is one combination of them, the same in every run.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        mode: the number of the mode, from 0. Larger gives shorter waves.
        operator: see `surface_laplacian`.
        progress: called with the share that is done; may raise to stop.

    Raises:
        FilterInputError: not a mesh, or no such mode.
        ConvergenceError: the modes cannot be computed.
    """
    mode = check_whole_number("mode", mode)
    problem = spectral_problem(vertices, faces, operator=operator)
    if len(problem.mass) == 0:
        raise FilterInputError(f"mode {mode} does not exist: no triangle of this mesh has an area")
    if mode > problem.n_waves:
        raise FilterInputError(f"mode {mode} does not exist: this mesh has modes 0 to {problem.n_waves}")
    area = float(problem.mass.sum())
    if mode == 0:
        progress(1.0)
        return OneHarmonic(problem.on_mesh(np.ones(len(problem.mass))), 0.0, 1.0, problem.n_components)
    kappa, modes = lowest_eigenpairs(problem, mode, constants=False, progress=progress)
    shape = modes[:, -1]
    component = problem.components[np.abs(shape).argmax()]
    share = float(problem.mass[problem.components == component].sum()) / area
    return OneHarmonic(problem.on_mesh(shape * np.sqrt(area)), float(kappa[-1]), share, problem.n_components)


def lowest_modes(
    operator: sparse.csc_matrix, fronts: Fronts, kernel: Floats, count: int, *, tolerance: float, progress: Progress
) -> tuple[Floats, Floats]:
    """Computes the `count` lowest eigenvalues and orthonormal eigenvectors of a semidefinite A with a kernel of dimension 1.

    Each round factorises A - shift I, with about half a band of new eigenvalues expected below the shift. The negative pivots
    count the eigenvalues below it [grimes1994]. `modes_near` computes the missing modes below it, and fills the band with modes
    above it. The last shift lies above the last requested mode and serves to count; if modes are missing, more rounds follow.

    A is scaled so that its k-th eigenvalue is about k. `kernel` is the unit vector with A kernel = 0, and `count` is
    well below n. `tolerance` limits the residual |A x - kappa x| as a share of kappa.
    """
    widest = _BAND if len(kernel) < _LARGE else _BAND_OF_LARGE
    kappa, modes = np.zeros(1), np.asfortranarray(kernel[:, None])
    spacing = 1.0
    for round_ in range(_ROUNDS):
        so_far = len(kappa)
        done = min(1.0, so_far / (count + _GUARD))
        if so_far >= count + _GUARD:
            gap = count - 1 + int(np.diff(kappa[count - 1 :]).argmax())
            factors = ShiftedFactors(operator, fronts, 0.5 * (kappa[gap] + kappa[gap + 1]), progress, 0.99)
            below, above = factors.below - int((kappa < factors.shift).sum()), 0
            if below == 0:
                return kappa[:count], modes[:, :count]
        else:
            band = min(widest, count + _GUARD - so_far)
            factors = _factors_at_next_shift(operator, fronts, kappa, spacing * 0.5 * band, band, progress, done)
            below = factors.below - int((kappa < factors.shift).sum())
            above = max(band - below, 0)
        band_progress = part_of(progress, min(0.99, done), min(0.99, done + (below + above) / (count + _GUARD)))
        locked = modes[:, np.argsort(np.abs(kappa - factors.shift), kind="stable")[: widest + 1]]
        new, vectors = modes_near(
            factors, np.asfortranarray(locked), below=below, above=above, tolerance=tolerance, seed=round_, progress=band_progress
        )
        if len(new) == 0:
            continue
        # Earlier modes at the edge of their band contain a little of the new modes: this overlap is removed.
        for group in groups(len(new), band_progress):
            remove(modes, vectors[:, group])
        new, vectors = _refined_modes(operator, factors, new, vectors, 0.7 * tolerance, band_progress)
        spacing = max(float(new[-1] - kappa[-1]), 0.0) / len(new) or spacing
        kappa, modes = np.concatenate([kappa, new]), np.hstack([modes, vectors])
        order = np.argsort(kappa, kind="stable")
        kappa, modes = kappa[order], np.asfortranarray(modes[:, order])
    raise ConvergenceError(f"{count} modes are not complete after {_ROUNDS} bands")


def _refined_modes(
    operator: sparse.csc_matrix, factors: ShiftedFactors, kappa: Floats, vectors: Floats, tolerance: float, progress: Progress
) -> tuple[Floats, Floats]:
    """Orthonormalises the modes of a band and reduces their residuals to `tolerance` times kappa; overwrites `vectors`.

    Far from the shift the residual is the rounding error of the solves, which is larger if an eigenvalue is near the shift. A
    further solve removes it but mixes in modes near the shift. A Rayleigh-Ritz step within the band separates the modes again.
    """
    for _ in range(_POLISHES):
        residual = np.empty(len(kappa))
        for group in groups(len(kappa), progress):
            residual_vectors = sparse_product(operator, vectors[:, group]) - vectors[:, group] * kappa[group]
            residual[group] = np.linalg.norm(residual_vectors, axis=0)
        bad = np.flatnonzero(residual > tolerance * kappa)
        if len(bad) == 0:
            break
        for group in groups(len(bad), progress):
            before = np.asfortranarray(vectors[:, bad[group]])
            better = factors.solve(before)
            better += factors.solve(before - (sparse_product(operator, better) - factors.shift * better))
            vectors[:, bad[group]] = better / np.linalg.norm(better, axis=0)
        energy = np.empty((len(kappa), len(kappa)))
        for group in groups(len(kappa), progress):
            energy[:, group] = inner_products(vectors, sparse_product(operator, vectors[:, group]), progress)
        kappa, weights = linalg.eigh(0.5 * (energy + energy.T), inner_products(vectors, vectors, progress), check_finite=False)
        vectors = combined(vectors, weights, progress)
    # Gram-Schmidt by the Cholesky factor adds to a mode only lower modes, whose residuals have smaller limits.
    triangle = linalg.cholesky(inner_products(vectors, vectors, progress), check_finite=False)
    return kappa, combined(vectors, linalg.solve_triangular(triangle, np.eye(len(kappa)), check_finite=False), progress)


def _factors_at_next_shift(
    operator: sparse.csc_matrix, fronts: Fronts, kappa: Floats, step: float, band: int, progress: Progress, done: float
) -> ShiftedFactors:
    """Returns the factors at a shift with an eighth of a band to a whole band of new eigenvalues below it, where possible."""
    low, high = 0.0, np.inf
    factors = ShiftedFactors(operator, fronts, float(kappa[-1]) + step, progress, done)
    for _ in range(40):
        missing = factors.below - int((kappa < factors.shift).sum())
        if missing > band:
            high = step
            step = max(step * 0.5 * band / missing, 0.9 * low + 0.1 * high)
        elif missing < band // 8:
            low = step
            step = min(step * max(1.5, min(8.0, 0.5 * band / max(missing, 1))), 0.1 * low + 0.9 * high)
        else:
            break
        if high - low <= 1e-3 * low:
            break
        factors = ShiftedFactors(operator, fronts, float(kappa[-1]) + step, progress, done)
    return factors


def modes_near(
    factors: ShiftedFactors, locked: Floats, *, below: int, above: int, tolerance: float, seed: int, progress: Progress
) -> tuple[Floats, Floats]:
    """Computes `below` modes of A below the shift and at least the next `above` modes above it, besides the known `locked` modes.

    Runs block Lanczos [grimes1994] on (A - shift I)^-1 and makes each block orthogonal to all earlier ones. One inverse iteration
    improves the Ritz vectors; it needs no solve, because the basis and the block after it span the result. The residual in A is
    then the Ritz residual of the inverse times (kappa - shift)^2.

    Exactly `below` modes must be missing below the shift. Returns ascending eigenvalues, and orthonormal modes orthogonal to the
    `locked` ones.
    """
    n, count = len(locked), below + above
    limit = min(n - locked.shape[1], int(_LIMIT * count) + 10 * _SMALL) // BLOCK * BLOCK
    basis = np.empty((n, min(limit, int(2.5 * count) + 2 * _SMALL) + BLOCK), order="F")
    projected = np.zeros((limit, limit))
    block = factors.solve(np.asfortranarray(np.random.default_rng(seed).normal(size=(n, BLOCK))))
    remove(locked, block)
    basis[:, :BLOCK] = linalg.qr(block, mode="economic", check_finite=False)[0]
    size, next_test = 0, int(_FIRST_TEST * count) + _SMALL
    while True:
        block = factors.solve(basis[:, size : size + BLOCK])
        progress(min(1.0, size / (2.0 * count + _SMALL)))
        # Nearly all overlap is with the last two blocks. Once it is removed, one pass over the whole basis is exact.
        coarse = remove(basis[:, max(0, size - BLOCK) : size + BLOCK], block)
        size += BLOCK
        share = remove(basis[:, :size], block)
        if size // BLOCK % _RENEWAL == 0:
            remove(locked, block)
        share[-len(coarse) :] += coarse
        projected[:size, size - BLOCK : size] = share
        following, coupling = linalg.qr(block, mode="economic", check_finite=False)
        if size + BLOCK > basis.shape[1]:
            larger = np.empty((n, min(limit + BLOCK, int(1.5 * basis.shape[1]))), order="F")
            larger[:, :size] = basis[:, :size]
            basis = larger
        basis[:, size : size + BLOCK] = following
        if size < next_test and size + BLOCK <= limit:
            continue
        next_test = int(size * _GROWTH)
        square = np.triu(projected[:size, :size])
        theta, vectors = linalg.eigh(square + np.triu(square, 1).T, check_finite=False)
        error = np.linalg.norm(coupling @ vectors[-BLOCK:], axis=0) / np.abs(theta)
        kappa = factors.shift + 1.0 / theta
        good = error * np.abs(kappa - factors.shift) <= 0.1 * tolerance * np.abs(kappa)
        upper = np.flatnonzero(theta > 0.0)[::-1]
        converged = int(good[upper].argmin()) if not good[upper].all() else len(upper)
        if good[:below].all() and below <= int((theta < 0.0).sum()) and converged >= above:
            chosen = np.concatenate([np.arange(below)[::-1], upper[:converged]]).astype(np.int64)
            order = chosen[np.argsort(kappa[chosen], kind="stable")]
            weights = np.vstack([vectors[:, order], coupling @ vectors[-BLOCK:, order] / theta[order]])
            return kappa[order], combined(basis[:, : size + BLOCK], weights, progress)
        if size + BLOCK > limit:
            raise ConvergenceError(
                f"{count} modes about the eigenvalue {factors.shift:.6g} have not converged in a basis of {size} vectors"
            )


def groups(count: int, progress: Progress, done: float = 1.0) -> Iterator[slice]:
    """Yields the columns 0 to `count` - 1 in groups; calls `progress` with `done` before each group."""
    for first in range(0, count, _TOGETHER):
        progress(done)
        yield slice(first, min(first + _TOGETHER, count))


def sparse_product(operator: sparse.csc_matrix, columns: Floats) -> Floats:
    """Returns A X, (n, k), for a symmetric A; the number of threads changes no bit."""
    product = np.empty(columns.shape, order="F")
    _multiply(CompressedRows.of(operator), columns, product)
    return product


def combined(columns: Floats, weights: Floats, progress: Progress) -> Floats:
    """Returns X W, (n, k)."""
    combinations = np.empty((len(columns), weights.shape[1]), order="F")
    for group in groups(weights.shape[1], progress):
        combinations[:, group] = blas.dgemm(1.0, columns, np.asfortranarray(weights[:, group]))
    return combinations


def inner_products(left: Floats, right: Floats, progress: Progress) -> Floats:
    """Returns X^T Y, (k, l)."""
    products = np.empty((left.shape[1], right.shape[1]), order="F")
    for group in groups(right.shape[1], progress):
        products[:, group] = blas.dgemm(1.0, left, right[:, group], trans_a=True)
    return products


def remove(directions: Floats, block: Floats) -> Floats:
    """Makes the block orthogonal to orthonormal directions, in place; returns its components along them."""
    share = blas.dgemm(1.0, directions, block, trans_a=True)
    blas.dgemm(-1.0, directions, share, 1.0, block, overwrite_c=True)
    return np.asarray(share)


@compiled(parallel=True)
def _multiply(matrix: CompressedRows, columns: Floats, product: Floats) -> None:
    starts, rows, values = matrix
    for c in prange(columns.shape[1]):
        for i in range(columns.shape[0]):
            total = 0.0
            for p in range(starts[i], starts[i + 1]):
                total += values[p] * columns[rows[p], c]
            product[i, c] = total

"""Spectrum slicing: the lowest modes of a large sparse operator, band by band, with the eigenvalues of every band counted.

Written here because ARPACK, in SciPy, searches about one shift and does not count; docs/solvers.md compares their times.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..checks import ConvergenceError
from ..compilation import compiled, prange
from ..execution import Progress, part_of
from ..libraries import blas, linalg, sparse
from ..linear_solvers import CompressedRows, Fronts, ShiftedFactors
from ..mesh import Floats

#: Modes of a band, and in large matrices: more make it costlier to keep the basis orthogonal, fewer take more factorisations.
_BAND, _BAND_OF_LARGE, _LARGE = 100, 160, 50_000
#: The last shift is put into the widest gap between this many modes beyond the last one.
_GUARD = 6
_ROUNDS = 10_000
_POLISHES = 3
#: Columns that the factors solve for at once. Eigenvalues of a higher multiplicity take a second search.
BLOCK = 8
#: Sizes of the basis, in numbers of modes: convergence is tested from the first on and at every growth by the second, up to the
#: limit.
_FIRST_LOOK, _GROWTH, _LIMIT = 1.6, 1.1, 8.0
#: Vectors added to these sizes, for small numbers of modes.
_SMALL = 40
#: Blocks after which locked modes are removed again: rounding brings them back, slowly.
_RENEWAL = 2
#: Columns in a group.
_TOGETHER = 16


def lowest_modes(
    operator: sparse.csc_matrix, fronts: Fronts, kernel: Floats, count: int, *, tolerance: float, progress: Progress
) -> tuple[Floats, Floats]:
    """The `count` lowest eigenvalues and orthonormal eigenvectors of a semidefinite operator with a kernel of dimension 1.

    A shift is put where about half a band of new eigenvalues is expected below it. The signs of its factors' pivots count the
    eigenvalues below [grimes1994]; `modes_near` searches for all that are missing and about as many above. The last shift lies
    above the last mode and only counts. If a mode is missing, it is searched for.

    The operator A is scaled such that there are about kappa eigenvalues below kappa; `kernel` is the unit vector with
    A kernel = 0, `count` well below n, the tolerance that of the residual |A x - kappa x| as a share of kappa.
    """
    n = len(kernel)
    widest = _BAND if n < _LARGE else _BAND_OF_LARGE
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
            factors = _placed(operator, fronts, kappa, spacing * 0.5 * band, band, progress, done)
            below = factors.below - int((kappa < factors.shift).sum())
            above = max(band - below, 0)
        rest = part_of(progress, min(0.99, done), min(0.99, done + (below + above) / (count + _GUARD)))
        locked = modes[:, np.argsort(np.abs(kappa - factors.shift), kind="stable")[: widest + 1]]
        new, vectors = modes_near(
            factors, np.asfortranarray(locked), below=below, above=above, tolerance=tolerance, seed=round_, progress=rest
        )
        if len(new) == 0:
            continue
        # Modes near the edge of an earlier band contain a share of their neighbours there, their residual divided by the gap.
        for group in groups(len(new), rest):
            remove(modes, vectors[:, group])
        new, vectors = _polished(operator, factors, new, vectors, 0.7 * tolerance, rest)
        spacing = max(float(new[-1] - kappa[-1]), 0.0) / len(new) or spacing
        kappa, modes = np.concatenate([kappa, new]), np.hstack([modes, vectors])
        order = np.argsort(kappa, kind="stable")
        kappa, modes = kappa[order], np.asfortranarray(modes[:, order])
    raise ConvergenceError(f"{count} modes are not complete after {_ROUNDS} bands")


def _polished(
    operator: sparse.csc_matrix, factors: ShiftedFactors, kappa: Floats, vectors: Floats, tolerance: float, progress: Progress
) -> tuple[Floats, Floats]:
    """The modes of a band, orthonormal, with residuals of at most `tolerance` times kappa; `vectors` is overwritten.

    Far from the shift the residual is noise of the solves, amplified by the nearest eigenvalue. A further solve removes it, but
    adds modes near the shift; the best vectors in the space of the band are free of these.
    """
    for _ in range(_POLISHES):
        residual = np.empty(len(kappa))
        for group in groups(len(kappa), progress):
            rest = sparse_product(operator, vectors[:, group]) - vectors[:, group] * kappa[group]
            residual[group] = np.linalg.norm(rest, axis=0)
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
        overlap = inner_products(vectors, vectors, progress)
        kappa, weights = linalg.eigh(0.5 * (energy + energy.T), overlap, check_finite=False)
        vectors = combined(vectors, weights, progress)
    # Gram-Schmidt by Cholesky's factor: a mode is changed by lower ones only, whose residuals must be smaller.
    triangle = linalg.cholesky(inner_products(vectors, vectors, progress), check_finite=False)
    inverse = linalg.solve_triangular(triangle, np.eye(len(kappa)), check_finite=False)
    return kappa, combined(vectors, inverse, progress)


def _placed(
    operator: sparse.csc_matrix, fronts: Fronts, kappa: Floats, step: float, band: int, progress: Progress, done: float
) -> ShiftedFactors:
    """Factors for a shift above all eigenvalues so far, with an eighth of a band to a band of new ones below it."""
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
    """The `below` modes of A nearest below the shift, and at least `above` of those nearest above it, without the locked ones.

    Block Lanczos [grimes1994] with (A - shift I)^-1, every new block made orthogonal to all earlier ones. One inverse iteration
    improves the Ritz vectors; it needs no solve, since the last block contains it. The residual in A is then the Ritz residual in
    the inverse times (kappa - shift)^2.

    There must be exactly `below` modes. Returns ascending eigenvalues and orthonormal modes, orthogonal to the `locked` ones.
    """
    n, count = len(locked), below + above
    limit = min(n - locked.shape[1], int(_LIMIT * count) + 10 * _SMALL) // BLOCK * BLOCK
    basis = np.empty((n, min(limit, int(2.5 * count) + 2 * _SMALL) + BLOCK), order="F")
    projected = np.zeros((limit, limit))
    block = factors.solve(np.asfortranarray(np.random.default_rng(seed).normal(size=(n, BLOCK))))
    remove(locked, block)
    basis[:, :BLOCK] = linalg.qr(block, mode="economic", check_finite=False)[0]
    size, look = 0, int(_FIRST_LOOK * count) + _SMALL
    while True:
        now = basis[:, size : size + BLOCK]
        block = factors.solve(now)
        progress(min(1.0, size / (2.0 * count + _SMALL)))
        # First against the last two blocks, where nearly all of the overlap is: then one pass over the whole basis is exact.
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
        if size < look and size + BLOCK <= limit:
            continue
        look = int(size * _GROWTH)
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
    """The columns from 0 to `count` in groups; calls `progress` with `done` before each."""
    for first in range(0, count, _TOGETHER):
        progress(done)
        yield slice(first, min(first + _TOGETHER, count))


def sparse_product(operator: sparse.csc_matrix, columns: Floats) -> Floats:
    """A X, (n, k), for a symmetric A, on all threads with the same bits for any number of them."""
    product = np.empty(columns.shape, order="F")
    _multiply(CompressedRows.of(operator), columns, product)
    return product


def combined(columns: Floats, weights: Floats, progress: Progress) -> Floats:
    """X W, (n, k)."""
    combinations = np.empty((len(columns), weights.shape[1]), order="F")
    for group in groups(weights.shape[1], progress):
        combinations[:, group] = blas.dgemm(1.0, columns, np.asfortranarray(weights[:, group]))
    return combinations


def inner_products(left: Floats, right: Floats, progress: Progress) -> Floats:
    """X^T Y, (k, l)."""
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

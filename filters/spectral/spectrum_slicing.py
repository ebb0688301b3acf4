"""Spectrum slicing: the lowest modes of a large sparse operator, band by band, with the eigenvalues of every band counted.

Written here because ARPACK, in SciPy, searches about one shift and does not count; docs/solvers.md compares their times.
"""

from __future__ import annotations

import numpy as np

from ..checks import ConvergenceError
from ..execution import Progress
from ..libraries import linalg, sparse
from ..linear_solvers import ShiftedFactors
from ..mesh import Floats
from .columnwise import combined, groups, inner_products, remove, sparse_product
from .shifted_lanczos import modes_near

#: Modes of a band: with more, keeping the basis orthogonal costs more; with fewer, more factorisations are needed.
_BAND, _BAND_OF_LARGE, _LARGE = 100, 160, 50_000
#: Modes beyond the last one wanted, in whose widest gap the last shift is put.
_GUARD = 6
_ROUNDS = 10_000
_POLISHES = 3


def lowest_modes(
    operator: sparse.csc_matrix, kernel: Floats, count: int, *, tolerance: float, progress: Progress
) -> tuple[Floats, Floats]:
    """The `count` lowest eigenvalues and orthonormal eigenvectors of a semidefinite operator with a kernel of dimension 1.

    A shift is put where about half a band of new eigenvalues is expected below it. The signs of its factors' pivots count the
    eigenvalues below [grimes1994]; `modes_near` searches for all that are missing and about as many above. The last shift lies
    above the last mode and only counts; if a mode is missing, it is searched for.

    Args:
        operator: A, (n, n) symmetric, positive semidefinite, in an order that keeps its factors sparse, scaled such that
            there are about kappa eigenvalues below kappa.
        kernel: (n,) the unit vector with A kernel = 0.
        count: how many, at least 1, well below n.
        tolerance: of the residual |A x - kappa x|, as a share of kappa.
        progress: called several times a second; may raise to stop.

    Raises:
        ConvergenceError: the modes of a band do not converge.
    """
    n = len(kernel)
    widest = _BAND if n < _LARGE else _BAND_OF_LARGE
    kappa, modes = np.zeros(1), np.asfortranarray(kernel[:, None])
    spacing = 1.0
    for round_ in range(_ROUNDS):
        known = len(kappa)
        done = min(1.0, known / (count + _GUARD))
        if known >= count + _GUARD:
            gap = count - 1 + int(np.diff(kappa[count - 1 :]).argmax())
            factors = ShiftedFactors(operator, 0.5 * (kappa[gap] + kappa[gap + 1]), progress, 0.99)
            below, above = factors.below - int((kappa < factors.shift).sum()), 0
            if below == 0:
                return kappa[:count], modes[:, :count]
        else:
            band = min(widest, count + _GUARD - known)
            factors = _placed(operator, kappa, spacing * 0.5 * band, band, progress, done)
            below = factors.below - int((kappa < factors.shift).sum())
            above = max(band - below, 0)

        def partial(share: float, start: float = done, part: int = below + above) -> None:
            progress(min(0.99, start + share * part / (count + _GUARD)))

        locked = modes[:, np.argsort(np.abs(kappa - factors.shift), kind="stable")[: widest + 1]]
        found, vectors = modes_near(
            factors, np.asfortranarray(locked), below=below, above=above, tolerance=tolerance, seed=round_, progress=partial
        )
        if len(found) == 0:
            continue
        # Modes near the edge of an earlier band contain a share of their neighbours there, their residual divided by the gap.
        for group in groups(len(found), partial):
            remove(modes, vectors[:, group])
        found, vectors = _polished(operator, factors, found, vectors, 0.7 * tolerance, partial)
        spacing = max(float(found[-1] - kappa[-1]), 0.0) / len(found) or spacing
        kappa, modes = np.concatenate([kappa, found]), np.hstack([modes, vectors])
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
            given = np.asfortranarray(vectors[:, bad[group]])
            better = factors.solve(given)
            better += factors.solve(given - (sparse_product(operator, better) - factors.shift * better))
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
    operator: sparse.csc_matrix, kappa: Floats, step: float, band: int, progress: Progress, done: float
) -> ShiftedFactors:
    """Factors for a shift above all known eigenvalues, with between an eighth of a band and a band of unknown ones below it."""
    low, high = 0.0, np.inf
    factors = ShiftedFactors(operator, float(kappa[-1]) + step, progress, done)
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
        factors = ShiftedFactors(operator, float(kappa[-1]) + step, progress, done)
    return factors

"""Block Lanczos about a shift: the modes with the eigenvalues nearest to it."""

from __future__ import annotations

import numpy as np

from ..checks import ConvergenceError
from ..execution import Progress
from ..libraries import linalg
from ..linear_solvers import ShiftedFactors
from ..mesh import Floats
from .columnwise import combined, remove

#: Columns that the factors solve for at once. Eigenvalues of a higher multiplicity take a second search.
BLOCK = 8
#: Convergence is tested from a basis of the first factor times the number of wanted modes on, and then at every growth by the
#: second, up to the limit.
_FIRST_LOOK, _GROWTH, _LIMIT = 1.6, 1.1, 8.0
#: Vectors added to these sizes, for small numbers of modes.
_SMALL = 40
#: Blocks after which locked modes are removed again: rounding brings them back, slowly.
_RENEWAL = 2


def modes_near(
    factors: ShiftedFactors, locked: Floats, *, below: int, above: int, tolerance: float, seed: int, progress: Progress
) -> tuple[Floats, Floats]:
    """The `below` modes of A nearest below the shift, and at least `above` of those nearest above it, without the locked ones.

    Block Lanczos [grimes1994] with (A - shift I)^-1, every new block made orthogonal to all earlier ones. One inverse iteration
    improves the Ritz vectors; it needs no solve, since the last block contains it. The residual in A is then the Ritz residual in
    the inverse times (kappa - shift)^2.

    Args:
        factors: of A - shift I.
        locked: (n, l) orthonormal modes that are known; the search is orthogonal to them.
        below: how many to find below; there must be exactly as many.
        above: how many to find above.
        tolerance: of the residual |A x - kappa x| as a share of kappa.
        seed: of the random block to start from.
        progress: called at every step with a growing share; may raise to stop.

    Returns:
        (k,) eigenvalues, ascending, complete but for the locked modes, and (n, k) orthonormal modes.
    """
    n, wanted = len(locked), below + above
    limit = min(n - locked.shape[1], int(_LIMIT * wanted) + 10 * _SMALL) // BLOCK * BLOCK
    basis = np.empty((n, min(limit, int(2.5 * wanted) + 2 * _SMALL) + BLOCK), order="F")
    projected = np.zeros((limit, limit))
    block = factors.solve(np.asfortranarray(np.random.default_rng(seed).normal(size=(n, BLOCK))))
    remove(locked, block)
    basis[:, :BLOCK] = linalg.qr(block, mode="economic", check_finite=False)[0]
    size, look = 0, int(_FIRST_LOOK * wanted) + _SMALL
    while True:
        now = basis[:, size : size + BLOCK]
        block = factors.solve(now)
        progress(min(1.0, size / (2.0 * wanted + _SMALL)))
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
                f"{wanted} modes about the eigenvalue {factors.shift:.6g} have not converged in a basis of {size} vectors"
            )

"""Filters by a rational function of the operator with one real pole, for waves of many edges and for thin triangles.

With R = sigma (S + sigma M)^-1 M a mode of eigenvalue kappa is multiplied by mu = sigma / (kappa + sigma), which lies in (0, 1]
however large kappa gets. A response with a limit for short waves is a smooth function of mu, and its Chebyshev series in
t = 2 mu - 1 is summed as that of `polynomial`, with a solve in place of a product: about 30 of them for the default low pass and
1e-6, on any mesh. All systems have the same symmetric positive definite matrix; nothing is complex [guttel2013].
"""

from __future__ import annotations

import math
from contextlib import suppress

import numpy as np

from ..checks import ConvergenceError
from ..execution import Progress, ignore_progress, part_of
from ..libraries import sparse
from ..linear_solvers import FINEST_TOLERANCE, Cholesky, SpdSolver
from ..mesh import Floats
from .chebyshev import ChebyshevSeries, chebyshev_series
from .polynomial import Applied, nearby_order, put_back
from .responses import Response

#: The poles that are tried go from the lowest squared cutoff times the first factor to the highest times the second.
_LOWEST_POLE, _HIGHEST_POLE, _POLES = 0.2, 30.0, 40
_LARGEST_DEGREE = 400
#: Systems of at most this many rows are factorised, which takes up to a second.
LARGEST_FACTORS = 120_000
#: The share of the tolerance that the solves may use.
_SHARE_OF_SOLVES = 0.3


def rational_series(response: Response, *, tolerance: float) -> tuple[ChebyshevSeries, float]:
    """The shortest series in t = 2 sigma / (kappa + sigma) - 1 of a response on all kappa from 0, and its sigma."""
    lowest, highest = _LOWEST_POLE * response.cutoffs[0] ** 2, _HIGHEST_POLE * response.cutoffs[-1] ** 2
    series = [(_series(response, pole, tolerance), float(pole)) for pole in np.geomspace(lowest, highest, _POLES)]
    return min(series, key=lambda pair: (pair[0].error > tolerance, pair[0].degree, pair[0].error))


def rational_filter(
    dirichlet: sparse.csr_matrix,
    mass: Floats,
    values: Floats,
    series: ChebyshevSeries,
    pole: float,
    *,
    tolerance: float,
    progress: Progress = ignore_progress,
) -> tuple[Applied, float]:
    """The series of `rational_series` applied to (n, k) values.

    An error e_k of the k-th solve enters all later terms, multiplied by at most 4 sum_{j>k} |c_j| (j - k). These factors fall
    with k, so the first solves have to be the most exact.

    Args:
        dirichlet: S, (n, n).
        mass: (n,), above 0.
        values: v, (n, k).
        series: of degree d.
        pole: sigma, in the unit of kappa.
        tolerance: of the error in the M-norm by all solves together, as a share of |v|_M.
        progress: called during the solves; may raise to stop.

    Returns:
        The filtered values, and an estimate of the error by the solves in the M-norm, not as a share.

    Raises:
        ConvergenceError: a system cannot be solved.
    """
    order = None if series.degree == 0 or len(mass) <= LARGEST_FACTORS else nearby_order(dirichlet, values.shape[1] * 300)
    if order is not None:
        dirichlet, mass, values = sparse.csr_matrix(dirichlet[order][:, order]), mass[order], values[order]
    c, degree = series.coefficients, series.degree
    system = _System(dirichlet, mass, pole, degree, progress)
    amplification = _amplification(np.abs(c))
    size = m_norm(mass, values)
    now, before, total = values.copy(), np.zeros_like(values), c[0] * values
    image, image_before = np.zeros_like(values), np.zeros_like(values)
    error = 0.0
    for k in range(degree):
        allowed = _SHARE_OF_SOLVES * tolerance * size / (degree * max(float(amplification[k]), 1e-300))
        # R T_k = 4 R R T_{k-1} - 2 R T_{k-1} - R T_{k-2}, and R changes little in what it was applied to before.
        guess = now if k == 0 else 2.0 * image - image_before
        image_before = image
        image, missed = system.solve(now, guess, allowed, part_of(progress, k / degree, (k + 1) / degree))
        error += float(amplification[k]) * missed
        following = 2.0 * image - now
        now, before = (following if k == 0 else 2.0 * following - before), now
        total += c[k + 1] * now
        progress((k + 1) / degree)
    squares = np.maximum(now * now, before * before) if degree > 0 else now * now
    largest = series.error * math.sqrt(float(squares.sum(axis=1).max(initial=0.0)))
    return Applied(total if order is None else put_back(total, order), largest), error


class _System:
    """Solves A x = sigma M b for A = S + sigma M, by factors up to `LARGEST_FACTORS` rows, else by multigrid."""

    def __init__(self, dirichlet: sparse.csr_matrix, mass: Floats, pole: float, solves: int, progress: Progress) -> None:
        self._mass, self._pole = mass, pole
        self._matrix = sparse.csr_matrix(dirichlet + pole * sparse.diags_array(mass))
        self._factors: Cholesky | None = None
        if len(mass) <= LARGEST_FACTORS and solves > 0:
            # If rounding spoils the factors the iterative solver takes over.
            with suppress(ConvergenceError):
                self._factors = Cholesky(self._matrix, progress=progress)
        self._solver = SpdSolver(self._matrix)

    def solve(self, values: Floats, guess: Floats, allowed: float, progress: Progress) -> tuple[Floats, float]:
        """R b, and its error in the M-norm, which is to be at most `allowed`."""
        right = (self._pole * self._mass)[:, None] * values
        if self._factors is not None:
            x = self._factors.solve(right)
            residual = right - self._matrix @ x
            if self._bound(residual) > allowed:
                x += self._factors.solve(residual)
                residual = right - self._matrix @ x
            error = self._bound(residual)
            if error > allowed:
                # Rounding at tiny triangles makes that bound far too large; the size of a further correction is closer.
                error = min(error, m_norm(self._mass, self._factors.solve(residual)))
            return x, error
        # |e|_M <= |e|_A / sqrt(sigma), since A >= sigma M.
        root = math.sqrt(self._pole)
        reference = root * max(m_norm(self._mass, values), np.finfo(float).tiny)
        share = min(max(allowed * root / reference, FINEST_TOLERANCE), 1e-3)
        solution = self._solver.solve(right, tolerance=share, reference=reference, start=guess, progress=progress)
        if solution.method == "cholesky":
            return solution.values, self._bound(right - self._matrix @ solution.values)
        return solution.values, solution.error / root

    def _bound(self, residual: Floats) -> float:
        """|A^-1 r|_M <= |r|_{M^-1} / sigma."""
        return m_norm(1.0 / self._mass, residual) / self._pole


def m_norm(mass: Floats, values: Floats) -> float:
    """|v|_M = sqrt(sum_i m_i |v_i|^2), summed in a fixed order."""
    return math.sqrt(float((mass * (values * values).sum(axis=1)).sum()))


def _series(response: Response, pole: float, tolerance: float) -> ChebyshevSeries:
    def sampled(t: Floats) -> Floats:
        return response.profile(np.sqrt(pole * (1.0 - t) / (1.0 + t)))

    # kappa = sigma tan^2(theta / 2): the angles of the lowest cutoff from 0 and of the highest from pi.
    root = math.sqrt(pole)
    width = 2.0 * min(math.atan(response.cutoffs[0] / root), math.atan(root / response.cutoffs[-1]))
    return chebyshev_series(sampled, tolerance=tolerance, width=width, largest_degree=_LARGEST_DEGREE)


def _amplification(sizes: Floats) -> Floats:
    """(degree,) 4 sum_{j > k} |c_j| (j - k): R enters T_{k+1} four times, and the rest grows as the polynomials U do."""
    beyond = np.cumsum(sizes[::-1])[::-1]
    return 4.0 * np.cumsum(beyond[::-1])[::-1][1:]

"""Factors of a shifted operator, A - shift I = L D L^T, which solve systems and count the eigenvalues below the shift."""

from __future__ import annotations

from functools import partial

import numpy as np

from ..checks import ConvergenceError
from ..execution import Progress, abandonable
from ..libraries import sparse
from ..mesh import Floats
from .fronts import Fronts

#: Shifts that are tried.
_ATTEMPTS = 4
#: Factors with a backward error of at most the first are taken at once; if there are none, the best ones up to the second. The
#: count is right while no eigenvalue is closer to the shift than this share of the largest one, and one step of refinement makes
#: up for what the modes lose.
_GOOD, _ROUGH = 1e-12, 1e-9


class ShiftedFactors:
    """L D L^T of A - shift I for a symmetric A, without row exchanges.

    Without exchanges D is diagonal, and by Sylvester's law of inertia it has as many negative entries as A has eigenvalues below
    the shift. A pivot close to 0 would spoil that; then the shift is moved a little.

    Attributes:
        shift: the shift of the factors, close to the one that was to be taken.
        below: how many eigenvalues of A, counted with multiplicity, lie below the shift.
    """

    def __init__(self, matrix: sparse.csc_matrix, fronts: Fronts, shift: float, progress: Progress, done: float) -> None:
        """Factorises.

        Args:
            matrix: A, (n, n) symmetric.
            fronts: of its pattern.
            shift: of the order of A's eigenvalues, above 0 or below.
            progress: called about ten times a second with `done`; may raise to stop, see `abandonable`.
            done: the share of the work that was done before.

        Raises:
            ConvergenceError: no shift close by gives factors.
        """
        identity = sparse.eye_array(matrix.shape[0], format="csr")
        probe = np.random.default_rng(0).normal(size=(matrix.shape[0], 1))
        size = float(np.asarray(abs(matrix).sum(axis=0)).max(initial=0.0))
        best, self._fronts = np.inf, fronts
        for attempt in range(_ATTEMPTS):
            tried = shift * (1.0 + 1e-4 * attempt)
            shifted = sparse.csr_matrix(matrix - tried * identity)
            values, pivots = abandonable(partial(fronts.factors, shifted), progress, done)
            x = fronts.solve(values, probe)
            error = float(np.linalg.norm(shifted @ x - probe) / (size * np.linalg.norm(x) + np.linalg.norm(probe)))
            if error < best:
                best, self.shift, self.below = error, tried, int((pivots < 0.0).sum())
                self._values = values
            if best <= _GOOD:
                break
        if not best <= _ROUGH:
            raise ConvergenceError(f"the operator of {matrix.shape[0]} vertices has no stable factors near the shift {shift:.6g}")

    def solve(self, right_side: Floats) -> Floats:
        """(A - shift I)^-1 times (n, b) columns, Fortran-ordered."""
        return self._fronts.solve(self._values, np.asfortranarray(right_side))

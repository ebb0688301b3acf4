"""Factors of a shifted operator, A - shift I = L D L^T, which solve systems and count the eigenvalues below the shift."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ..checks import ConvergenceError
from ..compilation import compiled
from ..execution import Progress, abandonable
from ..libraries import sparse
from ..mesh import Floats, Ints

#: Columns that one pass over the factors solves for: as many as fit into the registers.
_TOGETHER = 8
#: Shifts that are tried.
_ATTEMPTS = 4
#: Factors with a backward error of at most the first are taken at once; if there are none, the best ones up to the second. The
#: count is right while no eigenvalue is closer to the shift than this share of the largest one, and one step of refinement makes
#: up for what the modes lose.
_GOOD, _ROUGH = 1e-12, 1e-9


class ShiftedFactors:
    """L D L^T of A - shift I for a symmetric A, by SuperLU without row exchanges.

    Without exchanges D is diagonal, and by Sylvester's law of inertia it has as many negative entries as A has eigenvalues below
    the shift. A pivot close to 0 would spoil that; then the shift is moved a little. Rows are eliminated in the order in which
    they stand, which should be that of `nested_dissection`. Solves are written here because SuperLU's own take the columns one by
    one; docs/solvers.md compares their times.

    Attributes:
        shift: the shift of the factors, close to the one that was to be taken.
        below: how many eigenvalues of A, counted with multiplicity, lie below the shift.
    """

    def __init__(self, matrix: sparse.csc_matrix, shift: float, progress: Progress, done: float) -> None:
        """Factorises.

        Args:
            matrix: A, (n, n) symmetric.
            shift: of the order of A's eigenvalues, above 0 or below.
            progress: called about ten times a second with `done`; may raise to stop, see `abandonable`.
            done: the share of the work that was done before.

        Raises:
            ConvergenceError: no shift close by gives factors.
        """
        identity = sparse.eye_array(matrix.shape[0], format="csc")
        probe = np.random.default_rng(0).normal(size=(matrix.shape[0], 1))
        size = float(np.asarray(abs(matrix).sum(axis=0)).max(initial=0.0))
        best = np.inf
        for attempt in range(_ATTEMPTS):
            tried = shift * (1.0 + 1e-4 * attempt)
            shifted = sparse.csc_matrix(matrix - tried * identity)
            lu = abandonable(partial(_factorised, shifted), progress, done)
            if lu is None or not (lu.perm_r == lu.perm_c).all():
                continue
            lower = lu.L
            factors = (lower.indptr.astype(np.int64), lower.indices, lower.data, lu.U.diagonal(), lu.perm_c.astype(np.int32))
            x = _solved(factors, probe)
            error = float(np.linalg.norm(shifted @ x - probe) / (size * np.linalg.norm(x) + np.linalg.norm(probe)))
            if error < best:
                best, self.shift, self._factors = error, tried, factors
            if best <= _GOOD:
                break
        if not best <= _ROUGH:
            raise ConvergenceError(f"the operator of {matrix.shape[0]} vertices has no stable factors near the shift {shift:.6g}")
        self.below = int((self._factors[3] < 0.0).sum())

    def solve(self, right_side: Floats) -> Floats:
        """(A - shift I)^-1 times (n, b) columns, Fortran-ordered."""
        return _solved(self._factors, right_side)


def _solved(factors: Any, right_side: Floats) -> Floats:
    x = np.empty(right_side.shape, order="F")
    solve: Any = _solve
    for first in range(0, right_side.shape[1], _TOGETHER):
        group = slice(first, first + _TOGETHER)
        solve(*factors, right_side[:, group], x[:, group])
    return x


def _factorised(matrix: sparse.csc_matrix) -> Any:
    """SuperLU's factors; None if it meets a pivot that is 0."""
    try:
        return sparse.linalg.splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return None


# A pass is limited by reading the factors from memory, which a second thread would not speed up. The row of a pivot is held in
# eight variables, which the compiler keeps in registers; an array it would have to read and write at every entry.
@compiled
def _solve(starts: Any, rows: Ints, values: Floats, pivots: Floats, place: Ints, b: Floats, x: Floats) -> None:
    n, count = b.shape
    y = np.zeros((n, _TOGETHER))
    for c in range(count):
        for i in range(n):
            y[place[i], c] = b[i, c]
    for j in range(n):
        s, t, u, v, w, q, r, z = y[j, 0], y[j, 1], y[j, 2], y[j, 3], y[j, 4], y[j, 5], y[j, 6], y[j, 7]
        for p in range(np.uint64(starts[j]), np.uint64(starts[j + 1])):
            k = np.uint32(rows[p])
            if k != j:
                value = values[p]
                y[k, 0] -= value * s
                y[k, 1] -= value * t
                y[k, 2] -= value * u
                y[k, 3] -= value * v
                y[k, 4] -= value * w
                y[k, 5] -= value * q
                y[k, 6] -= value * r
                y[k, 7] -= value * z
    for j in range(n - 1, -1, -1):
        d = pivots[j]
        s, t, u, v = y[j, 0] / d, y[j, 1] / d, y[j, 2] / d, y[j, 3] / d
        w, q, r, z = y[j, 4] / d, y[j, 5] / d, y[j, 6] / d, y[j, 7] / d
        for p in range(np.uint64(starts[j]), np.uint64(starts[j + 1])):
            k = np.uint32(rows[p])
            if k != j:
                value = values[p]
                s -= value * y[k, 0]
                t -= value * y[k, 1]
                u -= value * y[k, 2]
                v -= value * y[k, 3]
                w -= value * y[k, 4]
                q -= value * y[k, 5]
                r -= value * y[k, 6]
                z -= value * y[k, 7]
        y[j, 0], y[j, 1], y[j, 2], y[j, 3], y[j, 4], y[j, 5], y[j, 6], y[j, 7] = s, t, u, v, w, q, r, z
    for c in range(count):
        for i in range(n):
            x[i, c] = y[place[i], c]

"""The equations of the bending energy to a few digits: conjugate gradients, preconditioned by factors of half the order."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..checks import FilterInputError
from ..execution import Progress
from ..libraries import sparse
from ..linear_solvers import Cholesky, conjugate_gradients, preconditioned_norm
from ..mesh import Floats, Longs

# How far conjugate gradients go down between refinements, and in how many steps at most.
_INNER, _MOST_ITERATIONS = 1e-7, 200
# Beyond this size the factors outgrow their 32-bit indices and the memory of most machines.
_MOST_ROWS = 3_000_000


class FloatingComponents(NamedTuple):
    """Components that nothing holds: their displacements have the mean 0.

    Attributes:
        labels: (f,) of each free vertex, -1 where its component has a fixed vertex.
        mass: (f,).
        highest: no label is above.
    """

    labels: Longs
    mass: Floats
    highest: int

    def centred(self, values: Floats) -> Floats:
        """The values less their means, weighted by the mass."""
        return values - self._spread(self._sums(self.mass[:, None] * values))

    def balanced(self, forces: Floats) -> Floats:
        """The transpose: forces less their sums, shared out by the mass."""
        return forces - self.mass[:, None] * self._spread(self._sums(forces))

    def _sums(self, values: Floats) -> Floats:
        if not (self.labels >= 0).any():
            return np.zeros((self.highest + 1, values.shape[1]))
        sums = np.stack([np.bincount(self.labels + 1, column, self.highest + 1) for column in values.T], axis=1)
        masses = np.bincount(self.labels + 1, self.mass, self.highest + 1)
        sums[0] = 0.0
        return np.asarray(sums / np.where(masses > 0.0, masses, 1.0)[:, None])

    def _spread(self, means: Floats) -> Floats:
        return np.asarray(means[self.labels + 1])


class HalfFactors:
    """The inverse of H M^-1 H = S M^-1 S + 2 sqrt(w) S + w M, H = S + sqrt(w) M, all times a unit.

    It lies between one and two times the energy's matrix where W is 1, whatever w: a dozen steps of conjugate gradients do. Its
    factors, those of a matrix of second order, take a third of the time and memory that those of fourth order take. Making them
    is silent and cannot be interrupted, for 0.9 s at 41,000 vertices; SuperLU, which can be, takes six times as long.
    """

    def __init__(self, dirichlet: sparse.csr_matrix, mass: Floats, weight: float, unit: float, progress: Progress) -> None:
        root = math.sqrt(weight)
        size = 1.0 / (1.0 + root)
        half = sparse.csr_matrix(dirichlet * size)
        half.setdiag(half.diagonal() + mass * (root * size))
        progress(0.0)
        if half.shape[0] > _MOST_ROWS:
            raise FilterInputError(
                f"{half.shape[0]:,} vertices are more than the {_MOST_ROWS:,} that can be solved for at once; select fewer, or "
                "take Implicit Fairing Smoothing"
            )
        self._factors = Cholesky(half)
        self._mass = (mass * (size * size / unit))[:, None]

    def __call__(self, residual: Floats) -> Floats:
        return self._factors.solve(self._mass * self._factors.solve(residual))


class InnerSolver:
    """Solves to a few digits, for refinement."""

    def __init__(
        self, matrix: sparse.csr_matrix, make: Callable[[Progress], HalfFactors], floating: FloatingComponents, progress: Progress
    ) -> None:
        self._matrix, self._make, self._floating, self._progress = matrix, make, floating, progress
        self._inverse: HalfFactors | None = None

    def __call__(self, right_side: Floats) -> Floats:
        b = self._floating.balanced(right_side)
        norm = preconditioned_norm(self._matrix, b, self._precondition)
        descent = conjugate_gradients(
            self._matrix,
            b,
            target=_INNER * norm,
            max_iterations=_MOST_ITERATIONS,
            precondition=self._precondition,
            progress=lambda share: self._progress(0.5 + 0.4 * share),
        )
        return self._floating.centred(descent.values)

    def _precondition(self, residual: Floats) -> Floats:
        if self._inverse is None:
            self._inverse = self._make(self._progress)
        return self._floating.centred(self._inverse(self._floating.balanced(residual)))

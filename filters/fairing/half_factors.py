"""The equations of the bending energy to a few digits: conjugate gradients, preconditioned by inverses of half the order."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..execution import Progress
from ..libraries import sparse
from ..linear_solvers import Cholesky, SmoothedAggregation, conjugate_gradients, preconditioned_norm
from ..mesh import Floats, Longs

# How far conjugate gradients go down between refinements, and in how many steps at most.
_INNER, _MOST_ITERATIONS = 1e-7, 200
# Up to so many rows factors are quicker; they take over from cycles that stall up to the second number, where memory ends.
_QUICK_FACTORS, _MOST_ROWS = 150_000, 3_000_000
# Cycles of multigrid that stand for the inverse of a half: with one, details much larger than edges take twice the iterations.
_CYCLES = 2


class FloatingComponents(NamedTuple):
    """Components that nothing holds: their displacements have the mean 0.

    Attributes:
        labels: (f,) of each free vertex, -1 where its component has a fixed vertex.
        mass: (f,).
        masses: (components + 1,) of each component's free vertices, that of the fixed ones first.
    """

    labels: Longs
    mass: Floats
    masses: Floats

    @classmethod
    def of(cls, labels: Longs, mass: Floats, count: int) -> FloatingComponents:
        """Of `count` components."""
        masses = np.bincount(labels + 1, mass, count + 1)
        return cls(labels, mass, np.where(masses > 0.0, masses, 1.0))

    def centred(self, values: Floats) -> Floats:
        """The values less their means, weighted by the mass."""
        if self._all_held:
            return values
        return values - self._spread(self._sums(self.mass[:, None] * values))

    def balanced(self, forces: Floats) -> Floats:
        """The transpose: forces less their sums, shared out by the mass."""
        if self._all_held:
            return forces
        return forces - self.mass[:, None] * self._spread(self._sums(forces))

    @property
    def _all_held(self) -> bool:
        return not (self.labels >= 0).any()

    @property
    def _is_one(self) -> bool:
        return len(self.masses) == 2 and bool((self.labels >= 0).all())

    def _sums(self, values: Floats) -> Floats:
        if self._is_one:
            return np.asarray(values.sum(axis=0) / self.masses[1])
        sums = np.stack([np.bincount(self.labels + 1, column, len(self.masses)) for column in values.T], axis=1)
        sums[0] = 0.0
        return np.asarray(sums / self.masses[:, None])

    def _spread(self, means: Floats) -> Floats:
        return means if self._is_one else np.asarray(means[self.labels + 1])


class Halves:
    """About the inverse of H M^-1 H = S M^-1 S + 2 sqrt(w) S + w M, H = S + sqrt(w) M, all times a unit.

    It lies between one and two times the energy's matrix where W is 1, whatever w: a dozen steps of conjugate gradients do. The
    factors of H, a matrix of second order, take a third of the time and memory that those of fourth order take. Making them
    is silent and cannot be interrupted, for 0.9 s at 41,000 vertices; SuperLU, which can be, takes six times as long. Of large
    meshes two cycles of multigrid stand for the inverse of H: three times the steps, which can be interrupted, and half the
    memory.
    """

    def __init__(self, dirichlet: sparse.csr_matrix, mass: Floats, weight: float, unit: float, progress: Progress) -> None:
        root = math.sqrt(weight)
        size = 1.0 / (1.0 + root)
        self._half = sparse.csr_matrix(dirichlet * size)
        self._half.setdiag(self._half.diagonal() + mass * (root * size))
        self._mass = (mass * (size * size / unit))[:, None]
        self._progress = progress
        progress(0.0)
        self._factors = Cholesky(self._half) if self._half.shape[0] <= _QUICK_FACTORS else None
        self._multigrid = None if self._factors else SmoothedAggregation(self._half, progress=lambda _: progress(0.0))

    def factorise(self) -> bool:
        """Takes factors from now on; False if they were taken already, or would be too large."""
        if self._factors is not None or self._half.shape[0] > _MOST_ROWS:
            return False
        self._factors, self._multigrid = Cholesky(self._half), None
        return True

    def __call__(self, residual: Floats) -> Floats:
        return self._solved(self._mass * self._solved(residual))

    def _solved(self, b: Floats) -> Floats:
        if self._factors is not None:
            return self._factors.solve(b)
        assert self._multigrid is not None
        return self._multigrid.iterated(np.ascontiguousarray(b), _CYCLES)


class InnerSolver:
    """Solves to a few digits, for refinement."""

    def __init__(
        self,
        matrix: sparse.csr_matrix,
        make: Callable[[Progress], Halves],
        floating: FloatingComponents,
        enough: float,
        progress: Progress,
    ) -> None:
        """Prepares nothing yet.

        Args:
            matrix: of the energy.
            make: gives the preconditioner.
            floating: the components that nothing holds.
            enough: the energy norm below which an error does not count.
            progress: called at every step; may raise to stop.
        """
        self._matrix, self._make, self._floating, self._progress = matrix, make, floating, progress
        self._enough = enough
        self._inverse: Halves | None = None

    def __call__(self, right_side: Floats) -> Floats:
        b = self._floating.balanced(right_side)
        while True:
            target = max(_INNER * preconditioned_norm(self._matrix, b, self._precondition), self._enough)
            descent = conjugate_gradients(
                self._matrix,
                b,
                target=target,
                max_iterations=_MOST_ITERATIONS,
                precondition=self._precondition,
                progress=lambda share: self._progress(0.5 + 0.4 * share),
            )
            if descent.norm <= target or self._inverse is None or not self._inverse.factorise():
                return self._floating.centred(descent.values)

    def _precondition(self, residual: Floats) -> Floats:
        if self._inverse is None:
            self._inverse = self._make(self._progress)
        return self._floating.centred(self._inverse(self._floating.balanced(residual)))

"""The energy of bending and distance on prescribed masses, and its minimiser."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from ..checks import ConvergenceError
from ..execution import Progress
from ..libraries import sparse
from ..linear_solvers import DirectMethod, laplacian_power, refined_solution
from ..mesh import Bools, Floats, Longs
from .half_factors import FloatingComponents, Halves, InnerSolver

# Feature weights that vary by more than this share are uneven, and up to so many unknowns all is factorised then.
_EVEN, _FACTORISED = 0.05, 400_000
# In no component does a root mean square error of this share of its diagonal count.
_ENOUGH = 1e-12


class BendingEnergy(NamedTuple):
    """p'^T S B S p' + w (p' - p)^T M (p' - p), B = M^-1 W."""

    dirichlet: sparse.csr_matrix
    mass: Floats
    bending: Floats
    weight: float

    def minimiser(self, points: Floats, prescribed: Floats, free: Bools, diagonal: float, progress: Progress) -> Floats:
        """(n, 3) the displacement of all vertices: solved for where they are free, prescribed elsewhere."""
        if not free.any():
            return prescribed
        # Divided by a mean of both terms the system stays finite for every w.
        typical = float(self.mass[free].mean())
        unit = 1.0 / (1.0 / typical + self.weight * typical)
        columns = self.dirichlet if free.all() else sparse.csr_matrix(self.dirichlet[:, free])
        data = self.mass[free] * (self.weight * unit)
        bending = self.bending * unit
        matrix = sparse.csr_matrix(columns.T @ sparse.csr_matrix(sparse.diags_array(bending) @ columns))
        matrix.setdiag(matrix.diagonal() + data)
        start = points + prescribed
        moved = prescribed.copy()

        def residual(displacement: Floats) -> Floats:
            moved[free] = displacement
            force = laplacian_power(self.dirichlet, bending, 2, start, moved - prescribed)[free]
            return np.asarray(-force - data[:, None] * displacement)

        # The energy of a component without fixed vertex is blind to its translation; but its equations sum up to 0.
        count, labels = sparse.csgraph.connected_components(self.dirichlet, directed=False)
        anchored = np.bincount(labels[~free], minlength=count) > 0
        loose = np.where(anchored[labels[free]], -1, labels[free])
        floating = FloatingComponents.of(loose, data, count)
        half = partial(Halves, columns if free.all() else columns[free], self.mass[free], self.weight, unit)
        enough = _ENOUGH * _smallest_norm(start[free], data, labels[free], count)
        quick = InnerSolver(matrix, half, floating, enough, progress)
        # Where the weights vary much, the halves are a poor guide and the factors of the whole are faster.
        uneven = float((self.bending * self.mass)[free].min()) < _EVEN * float((self.bending * self.mass)[free].max())
        methods: list[DirectMethod | InnerSolver] = [quick, "superlu"]
        if uneven and len(data) <= _FACTORISED:
            methods.reverse()
        zero = np.zeros((len(data), 3))
        try:
            solution = refined_solution(matrix, residual, zero, extent=diagonal, method=methods[0], progress=progress)
        except ConvergenceError:
            solution = refined_solution(matrix, residual, zero, extent=diagonal, method=methods[1], progress=progress)
        moved[free] = solution.values
        return moved


def _smallest_norm(points: Floats, data: Floats, labels: Longs, count: int) -> float:
    """The least norm of a shift of a component by its own diagonal: sqrt(sum of data) times that.

    The energy norm of an error e is at least the root of the sum of data e^2.
    """
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, labels, points)
    np.maximum.at(high, labels, points)
    sums = np.bincount(labels, data, count)
    there = sums > 0.0
    return float((np.linalg.norm(high[there] - low[there], axis=1) * np.sqrt(sums[there])).min())

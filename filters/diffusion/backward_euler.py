"""One backward Euler step of the diffusion equation, on a surface or on a curve."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..checks import ConvergenceError
from ..execution import Progress
from ..libraries import sparse
from ..linear_solvers import SpdSolver
from ..mesh import Bools, Floats, Ints, Longs, bounding_box
from ..operators import Laplacian

#: The root mean square error of the coordinates that the solver leaves, as a share of the bounding-box diagonal.
TOLERANCE = 1e-10
# Times the squared lengths of a mesh of ordinary size this does not overflow, and longer steps give the same result to rounding.
_LONGEST_STEP = 1e100
_ROUNDING = 2.0**-47


class BackwardEulerStep:
    """(M - t C) p' = M p, solved for the displacement d = p' - p: (M - t C) d = t C p.

    Divided by 1 + t, the matrix is a mean of M and -C and stays finite for every t. It is positive definite where a vertex is
    fixed or has mass. A component without fixed vertex floats: C is blind to its translation, and for large t the matrix nearly
    so. But its equations sum up to sum_i M_i d_i = 0: that is imposed, and the component keeps its centroid to rounding.

    The error: with ||x||_A the energy norm of A = M - t C, sum_i M_i |e_i|^2 <= ||e||_A^2, since -C is semidefinite. The solver
    brings ||e||_A to `TOLERANCE` times the norm of a shift of everything by the diagonal, whose square is diagonal^2 sum_i M_i.
    """

    def __init__(self, laplacian: Laplacian, time_step: float, *, fixed: Bools, components: Ints, steps: int = 1) -> None:
        """Sets up the system; nothing is solved yet.

        Args:
            laplacian: L = M^-1 C on n vertices.
            time_step: t, at least 0, in the unit of 1 / L.
            fixed: (n,) the vertices whose displacement is prescribed. Those without an edge of any weight stay too, and so do
                components without mass, of which the equation says nothing.
            components: (n,) a label from 0 for every vertex, at least one each component of C; -1 for vertices without any.
            steps: how many steps with this system are to come.
        """
        t = min(time_step, _LONGEST_STEP)
        self._stiffness, self._stiffness_share = laplacian.stiffness, t / (1.0 + t)
        coupled = (components >= 0) & (laplacian.stiffness.diagonal() < 0.0)
        labels = np.where(coupled, components, 0)
        masses = np.bincount(labels, weights=laplacian.mass * coupled, minlength=1)
        free = coupled & ~fixed & (masses[labels] > 0.0)
        self._free, self._all_free = np.flatnonzero(free), bool(free.all())
        self._mass, self._steps = laplacian.mass[self._free] / (1.0 + t), steps
        self._floating = _Floating.among(labels[self._free], labels[coupled & ~free], self._mass)
        self._solver = self._assemble() if len(self._free) else None

    def displacement(self, points: Floats, prescribed: Floats, *, diagonal: float, progress: Progress) -> Floats:
        """The displacement of all vertices.

        Args:
            points: (n, d) p: coordinates, or one value a vertex.
            prescribed: (n, d) the displacement of the fixed vertices; 0 elsewhere.
            diagonal: the length against which errors count.
            progress: called every few solver steps; may raise to stop.

        Returns:
            (n, d); the prescribed displacement where a vertex is fixed.

        Raises:
            ConvergenceError: the solver stalls.
        """
        if self._solver is None:
            return prescribed
        start = points + prescribed
        extent = largest_side(start)
        if extent <= TOLERANCE * diagonal:
            # To rounding, the surface is a point already.
            return prescribed
        try:
            return self._solve(self._solver, start, prescribed, extent, diagonal, progress)
        except ConvergenceError:
            # The weights of slivers, large and of both signs, are no longer semidefinite once rounded. Those that are left are,
            # since no row has an entry that outweighs its diagonal.
            positive = without_negative_weights(self._stiffness)
            if positive is self._stiffness:
                raise
            self._stiffness = positive
            self._solver = self._assemble()
            return self._solve(self._solver, start, prescribed, extent, diagonal, progress)

    def _assemble(self) -> SpdSolver:
        stiffness = self._stiffness if self._all_free else self._stiffness[self._free][:, self._free]
        entries = stiffness.data * -self._stiffness_share, stiffness.indices, stiffness.indptr
        matrix = sparse.csr_matrix(entries, shape=stiffness.shape)
        # A little more on the diagonal, no more than rounding, outweighs the rounding errors of its row.
        matrix.setdiag(matrix.diagonal() * (1.0 + _ROUNDING) + self._mass)
        return SpdSolver(matrix, solves=self._steps)

    def _solve(
        self, solver: SpdSolver, start: Floats, prescribed: Floats, extent: float, diagonal: float, progress: Progress
    ) -> Floats:
        force = self._stiffness_share * (self._stiffness @ start)
        if not self._all_free:
            force = force[self._free]
        reference = diagonal * float(np.sqrt(self._mass.sum()))
        moved = solver.solve(force, tolerance=TOLERANCE, reference=reference, progress=progress).values
        moved -= self._floating.means(moved, self._mass)
        # Diffusion moves nothing out of the box, except a little where weights are negative.
        if not np.abs(moved).max() <= 2.0 * extent:
            raise ConvergenceError("the solution leaves the box: the matrix is not positive definite to rounding")
        if self._all_free:
            return moved
        everywhere = prescribed.copy()
        everywhere[self._free] = moved
        return everywhere


def largest_side(points: Floats) -> float:
    """The longest side of the bounding box of (n, d) points."""
    low, high = bounding_box(points) if points.shape[1] == 3 else (points.min(axis=0), points.max(axis=0))
    return float((high - low).max())


def without_negative_weights(stiffness: sparse.csr_matrix) -> sparse.csr_matrix:
    """C with its negative weights set to 0 and rows that sum to 0 again; C itself if it has none."""
    rows = np.repeat(np.arange(stiffness.shape[0]), np.diff(stiffness.indptr))
    negative = (stiffness.data < 0.0) & (stiffness.indices != rows)
    if not negative.any():
        return stiffness
    positive = stiffness.copy()
    positive.data[negative] = 0.0
    positive.setdiag(0.0)
    positive.setdiag(-np.asarray(positive.sum(axis=1)).ravel())
    return positive


class _Floating(NamedTuple):
    """The components without fixed vertex.

    Attributes:
        component: (f,) a label from 0 for every free vertex.
        weight: one over the mass of each component, 0 for those with a fixed vertex.
    """

    component: Longs
    weight: Floats

    @classmethod
    def among(cls, free_labels: Ints, fixed_labels: Ints, mass: Floats) -> _Floating:
        labels, component = np.unique(free_labels, return_inverse=True)
        total = np.bincount(component, weights=mass, minlength=len(labels))
        floats = (total > 0.0) & ~np.isin(labels, fixed_labels)
        return cls(component, np.divide(1.0, total, out=np.zeros(len(labels)), where=floats))

    def means(self, values: Floats, mass: Floats) -> Floats:
        """(f, d) at every free vertex the mean of the values over its component, weighted by mass; 0 if it has a fixed vertex."""
        weighted = mass[:, None] * values
        if len(self.weight) == 1:
            return np.broadcast_to(weighted.sum(axis=0) * self.weight[0], values.shape)
        sums = [np.bincount(self.component, weights=column, minlength=len(self.weight)) * self.weight for column in weighted.T]
        return np.column_stack(sums)[self.component]

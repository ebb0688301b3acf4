"""One backward Euler step of the diffusion equation, on a surface or on a curve."""

from typing import NamedTuple

import numpy as np

from ..operators.laplacian import Laplacian
from ..progress import Progress
from ..solvers import SpdSolver
from ..topology import Bools, Floats, Ints, Longs

#: The root mean square error of the coordinates that the solver leaves, as a share of the bounding-box diagonal.
TOLERANCE = 1e-11
# Squared lengths of a mesh of ordinary size times this overflow nowhere, and diffuse it to a point to the last bit.
_LONGEST_STEP = 1e100
_ROUNDING = 2.0**-47


class BackwardEulerStep:
    """(M - t C) p' = M p, solved for the displacement d = p' - p: (M - t C) d = t C p.

    Divided by 1 + t, the matrix is a mean of M and -C and stays finite for every t. It is positive definite where a vertex is
    held or has mass. Where a component floats, C knows no difference between two places of it, and for large t the matrix hardly
    does; but the equations sum up to sum_i M_i d_i = 0, so that is imposed, and the component keeps its centroid to rounding.

    The error: with ||x||_A the energy norm of A = M - t C, sum_i M_i |e_i|^2 <= ||e||_A^2, since -C is semidefinite. The solver
    brings ||e||_A to `TOLERANCE` times the norm of a shift of everything by the diagonal, whose square is diagonal^2 sum_i M_i.
    """

    def __init__(self, laplacian: Laplacian, time_step: float, *, held: Bools, components: Ints, steps: int = 1) -> None:
        """Sets up the system; nothing is solved yet.

        Args:
            laplacian: L = M^-1 C on n vertices.
            time_step: t, at least 0, in the unit of 1 / L.
            held: (n,) the vertices whose displacement is given. Those without an edge of any weight stay too, and so do
                components without mass, of which the equation says nothing.
            components: (n,) a label from 0 for every vertex, at least one each component of C; -1 for vertices without any.
            steps: how many steps with this system are to come.
        """
        t = min(time_step, _LONGEST_STEP)
        self._stiffness, self._stiffness_share = laplacian.stiffness, t / (1.0 + t)
        coupled = (components >= 0) & (laplacian.stiffness.diagonal() < 0.0)
        labels = np.where(coupled, components, 0)
        masses = np.bincount(labels, weights=laplacian.mass * coupled, minlength=1)
        free = coupled & ~held & (masses[labels] > 0.0)
        self._free = np.flatnonzero(free)
        self._mass = laplacian.mass[self._free] / (1.0 + t)
        self._floating = _Floating.among(labels[self._free], labels[coupled & ~free], self._mass)
        matrix = self._stiffness * -self._stiffness_share
        if len(self._free) < len(free):
            matrix = matrix[self._free][:, self._free]
        # Rounding may have left the weights of slivers a little indefinite; this much more on the diagonal is rounding too.
        matrix.setdiag(matrix.diagonal() * (1.0 + _ROUNDING) + self._mass)
        self._solver = SpdSolver(matrix, solves=steps) if len(self._free) else None

    def displacement(self, points: Floats, given: Floats, *, diagonal: float, progress: Progress) -> Floats:
        """The displacement of all vertices.

        Args:
            points: (n, 3) p.
            given: (n, 3) the displacement of the held vertices; 0 elsewhere.
            diagonal: the length against which errors count.
            progress: called every few solver steps; may raise to stop.

        Returns:
            (n, 3); the given displacement where a vertex is held.

        Raises:
            ConvergenceError: the solver stalls, as it does on matrices that are not positive definite.
        """
        moved = given.copy()
        if self._solver is None:
            return moved
        force = self._stiffness_share * (self._stiffness @ (points + given))[self._free]
        force -= self._mass[:, None] * self._floating.sums_per_mass(force)
        reference = diagonal * float(np.sqrt(self._mass.sum()))
        solution = self._solver.solve(force, tolerance=TOLERANCE, reference=reference, progress=progress).values
        moved[self._free] = solution - self._floating.sums_per_mass(self._mass[:, None] * solution)
        return moved


class _Floating(NamedTuple):
    """The components of which no vertex is held.

    Attributes:
        component: (f,) a label from 0 for every free vertex.
        weight: one over the mass of each component, 0 for those that are held somewhere.
    """

    component: Longs
    weight: Floats

    @classmethod
    def among(cls, free_labels: Ints, held_labels: Ints, mass: Floats) -> "_Floating":
        labels, component = np.unique(free_labels, return_inverse=True)
        total = np.bincount(component, weights=mass, minlength=len(labels))
        floats = (total > 0.0) & ~np.isin(labels, held_labels)
        return cls(component, np.divide(1.0, total, out=np.zeros(len(labels)), where=floats))

    def sums_per_mass(self, values: Floats) -> Floats:
        """(f, 3) at every free vertex the sum of the values over its component divided by its mass; 0 if it is held somewhere."""
        if len(self.weight) == 1:
            return np.broadcast_to(values.sum(axis=0) * self.weight[0], values.shape)
        sums = [np.bincount(self.component, weights=column, minlength=len(self.weight)) * self.weight for column in values.T]
        return np.column_stack(sums)[self.component]

"""The flows of implicit fairing: which operator each of several backward Euler steps takes, on the border and inside it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, TypeAlias, get_args

import numpy as np

from ..execution import Progress, part_of
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, bounding_box
from ..operators import Laplacian, OperatorName, build_laplacian, curve_laplacian, mixed_voronoi_areas
from ..topology import BorderPolicy, connected_components
from .backward_euler import BackwardEulerStep

#: "linear": C and M of the input for all steps. "mean_curvature": both are built anew for every step. "conformalized": C of the
#: input, M anew.
Flow: TypeAlias = Literal["linear", "mean_curvature", "conformalized"]
FLOWS: tuple[Flow, ...] = get_args(Flow)


class ImplicitFlow:
    """Steps of a given length on one mesh.

    Under the border policy "along" a step is two: one of the border curves alone, since their vertices see no others, and one of
    the rest with the new borders prescribed. Together they are the backward Euler step of that coupled system.

    Attributes:
        components: (n,) a label from 0 for every vertex of a component; -1 for vertices that no face uses.
    """

    def __init__(
        self,
        points: Floats,
        faces: Ints,
        operator: OperatorName,
        *,
        time_step: float,
        steps: int,
        flow: Flow,
        border: BorderPolicy,
        border_edges: Ints,
        movable: Bools | None,
    ) -> None:
        """Describes the flow; nothing is built yet.

        Args:
            points: (n, 3) coordinates of the start.
            faces: (m, 3) triangles, or (0, 3) for a point cloud.
            operator: see `build_laplacian`.
            time_step: t, in the unit of one over L.
            steps: how many steps are to come.
            flow: see `Flow`.
            border: see `BorderPolicy`.
            border_edges: (b, 2) the edges with one face.
            movable: (n,) which vertices may move; None for all.
        """
        self._faces, self._operator = faces, operator
        self._time_step, self._steps, self._flow = time_step, steps, flow
        self._diagonal = float(np.linalg.norm(np.subtract(*bounding_box(points)))) if len(points) else 0.0
        self._border_edges = border_edges
        self._along = border == "along" and len(border_edges) > 0
        on_border = np.zeros(len(points), dtype=np.bool_)
        if border != "free":
            on_border[border_edges] = True
        fixed = np.zeros(len(points), dtype=np.bool_) if movable is None else ~movable
        self._fixed, self._fixed_on_curve = fixed | on_border, fixed | ~on_border
        self.components = connected_components(faces, len(points))[0]
        self._curve: Laplacian | None = None
        self._surface: Laplacian | None = None
        self._systems: list[BackwardEulerStep] = []

    def step(self, points: Floats, progress: Progress) -> Floats:
        """The points after one step."""
        if not self._systems or self._flow != "linear":
            self._systems = self._build(points)
        return self.smoothed(points, progress)

    def smoothed(self, points: Floats, progress: Progress) -> Floats:
        """(n, d) coordinates or values at the vertices after a step by the operators of the last step of the mesh."""
        moved = np.zeros_like(points)
        count = len(self._systems)
        for k, system in enumerate(self._systems):
            part = part_of(progress, k / count, (k + 1) / count)
            moved = system.displacement(points, moved, diagonal=self._diagonal, progress=part)
        return points + moved

    def _build(self, points: Floats) -> list[BackwardEulerStep]:
        systems = []
        if self._along:
            self._curve = self._updated(self._curve, lambda: curve_laplacian(points, self._border_edges, self._operator))
            systems.append(self._system(self._curve, self._fixed_on_curve, _connected(self._curve)))
        if self._flow == "conformalized" and self._surface is not None and self._operator == "laplace_beltrami":
            # What _updated would give, without building a stiffness only to leave it.
            self._surface = Laplacian(self._surface.stiffness, mixed_voronoi_areas(points, self._faces))
        else:
            self._surface = self._updated(self._surface, lambda: build_laplacian(points, self._faces, self._operator))
        is_cloud = len(self._faces) == 0
        systems.append(self._system(self._surface, self._fixed, _connected(self._surface) if is_cloud else self.components))
        return systems

    def _updated(self, previous: Laplacian | None, build: Callable[[], Laplacian]) -> Laplacian:
        laplacian = build()
        if previous is None or self._flow == "mean_curvature":
            return laplacian
        return Laplacian(previous.stiffness, laplacian.mass)

    def _system(self, laplacian: Laplacian, fixed: Bools, components: Ints) -> BackwardEulerStep:
        steps = self._steps if self._flow == "linear" else 1
        return BackwardEulerStep(laplacian, self._time_step, fixed=fixed, components=components, steps=steps)


def _connected(laplacian: Laplacian) -> Ints:
    labels: Ints = sparse.csgraph.connected_components(laplacian.stiffness, directed=False)[1]
    return labels

"""What a run finds out about its mesh before and after the steps: its measures, or only what it cannot do without."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from ..filters.geometry import mean_edge_length
from ..filters.inspection.connectivity import Connectivity
from ..filters.inspection.surface_measures import SurfaceMeasures, box_diagonal, measures_and_connectivity
from ..filters.mesh import check_points
from ..filters.neighbours import nearest_neighbours
from .origins import InputMesh, mesh_of
from .plain_values import plain
from .shape_change import ShapeChange, shape_change


@dataclass(frozen=True, eq=False)
class Found:
    """What is known of a mesh.

    Attributes:
        arrays: its vertices and faces; None if nobody needs them.
        measures: of it; None if none are wanted.
        diagonal: of the bounding box of all vertices.
        resolution: gives the mean edge, or for a cloud the mean distance of nearest points; 0 if there is neither.
    """

    arrays: InputMesh | None
    measures: SurfaceMeasures | None
    diagonal: float
    resolution: Callable[[], float]

    @property
    def described(self) -> dict[str, Any] | None:
        """The measures by name, in terms of JSON."""
        return None if self.measures is None else plain(asdict(self.measures))


class Measuring:
    """Looks at the mesh of a run; how it is connected is not found anew if that has not changed."""

    def __init__(self, *, wanted: bool, followed: bool) -> None:
        """See the class; `wanted` says whether measures are taken, `followed` whether the arrays are needed even without."""
        self._wanted = wanted
        self._followed = followed
        self._connectivity: Connectivity | None = None

    def look(self, mesh: Any) -> Found:
        """What is known of a pymeshlab mesh.

        Raises:
            FilterInputError: a coordinate is not finite.
        """
        if not self._wanted:
            diagonal = box_diagonal(check_points(mesh.vertex_matrix()))
            return Found(mesh_of(mesh) if self._followed else None, None, diagonal, lambda: _resolution(mesh))
        arrays = mesh_of(mesh)
        measures, self._connectivity = measures_and_connectivity(
            arrays.vertices, arrays.faces, edges=mesh.edge_matrix(), known=self._connectivity
        )
        return Found(arrays, measures, measures.diagonal, lambda: measures.mean_edge or measures.mean_spacing or 0.0)


def change_of(before: Found, after: Found) -> ShapeChange | None:
    """What lies between two meshes; None if they were not measured."""
    if before.arrays is None or before.measures is None or after.arrays is None or after.measures is None:
        return None
    return shape_change(before.arrays, after.arrays, (before.measures, after.measures))


def _resolution(mesh: Any) -> float:
    """The mean edge, or the mean spacing, of a mesh that is not measured."""
    vertices, faces = mesh_of(mesh)
    if len(faces) or mesh.edge_number():
        return mean_edge_length(vertices, faces if len(faces) else mesh.edge_matrix())
    return float(nearest_neighbours(vertices, 1)[0].mean()) if len(vertices) > 1 else 0.0

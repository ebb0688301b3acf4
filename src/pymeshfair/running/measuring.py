"""Measures of the mesh of a run before and after the steps; without measures, only the sizes that every run needs."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from ..filters.geometry import vector_lengths
from ..filters.inspection.surface_measures import Connectivity, SurfaceMeasures, box_diagonal, measures_and_connectivity
from ..filters.mesh import check_points
from ..mesh_data import MeshData
from .plain_values import plain

#: faces that a usual length is found from
_SOME = 10_000


@dataclass(frozen=True, eq=False)
class MeasuredMesh:
    """A mesh and its measures."""

    mesh: MeshData
    measures: SurfaceMeasures | None  # None if none are wanted; so the connectivity
    connectivity: Connectivity | None
    diagonal: float  # of the bounding box of all vertices
    #: gives the mean edge, or for a cloud the mean distance of nearest points; 0 if there is neither
    resolution: Callable[[], float]

    @property
    def described(self) -> dict[str, Any] | None:
        """The measures by name, in terms of JSON."""
        return None if self.measures is None else plain(asdict(self.measures))


def measure(mesh: MeshData, *, wanted: bool = True, former: MeasuredMesh | None = None) -> MeasuredMesh:
    """Measure a mesh, without `wanted` its diagonal alone; the connectivity of a former one is taken over if it is the same."""
    if not wanted:
        return MeasuredMesh(mesh, None, None, box_diagonal(check_points(mesh.vertices)), lambda: usual_edge(mesh))
    measures, connectivity = measures_and_connectivity(
        mesh.vertices, mesh.faces, edges=mesh.edges, former=None if former is None else former.connectivity
    )
    resolution = measures.mean_edge or measures.mean_spacing or 0.0
    return MeasuredMesh(mesh, measures, connectivity, measures.diagonal, lambda: resolution)


def usual_edge(mesh: MeshData) -> float:
    """About the mean edge, from some thousands of faces, or the mean distance of points: what coordinates must tell apart."""
    if not len(mesh.faces):
        return mesh.mean_edge
    faces = mesh.faces[:: max(1, len(mesh.faces) // _SOME)]
    return float(vector_lengths(mesh.vertices[faces[:, 0]] - mesh.vertices[faces[:, 1]]).mean())

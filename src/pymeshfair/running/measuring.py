"""Measures a mesh, and finds its self-intersecting faces.

MeshLab finds these faces, and crashes on some meshes. So it runs in a worker: that of the run, or else one for the search alone.
"""

import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..declaration import Bools
from ..errors import RunError
from ..filters.geometry import vector_lengths
from ..filters.inspection.surface_measures import Connectivity, SurfaceMeasures, box_diagonal, measures_and_connectivity
from ..filters.mesh import check_points
from ..filters.topology import proper_faces
from ..mesh_data import MeshData
from ..operating_system import this_system
from ..processes.process import Pool
from ..processes.worker import Order
from ..registry import find_filter
from ..scripts.script import Step
from .document import Document
from .job import plain

_SAMPLE = 10_000  # `usual_edge` looks at one to two times this number of faces of a larger mesh


@dataclass(frozen=True, eq=False)
class MeasuredMesh:
    """A mesh and its measures."""

    mesh: MeshData
    measures: SurfaceMeasures | None  # None if they are not wanted
    connectivity: Connectivity | None  # None without measures
    diagonal: float  # of the bounding box of all vertices
    resolution: Callable[[], float]  # returns the mean edge length; for a cloud the mean distance to the nearest point; else 0

    @property
    def described(self) -> dict[str, Any] | None:
        return None if self.measures is None else plain(asdict(self.measures))


def measure(mesh: MeshData, *, wanted: bool = True, former: MeasuredMesh | None = None) -> MeasuredMesh:
    """Measure a mesh, or only its diagonal if not `wanted`; the connectivity of `former` is reused if the faces are the same."""
    if not wanted:
        return MeasuredMesh(mesh, None, None, box_diagonal(check_points(mesh.vertices)), lambda: usual_edge(mesh))
    measures, connectivity = measures_and_connectivity(
        mesh.vertices, mesh.faces, edges=mesh.edges, former=None if former is None else former.connectivity
    )
    resolution = measures.mean_edge or measures.mean_spacing or 0.0
    return MeasuredMesh(mesh, measures, connectivity, measures.diagonal, lambda: resolution)


def usual_edge(mesh: MeshData) -> float:
    """The length that written coordinates must resolve: the mean edge of a sample of faces; without faces `mesh.mean_edge`."""
    if not len(mesh.faces):
        return mesh.mean_edge
    faces = mesh.faces[:: max(1, len(mesh.faces) // _SAMPLE)]
    return float(vector_lengths(mesh.vertices[faces[:, 0]] - mesh.vertices[faces[:, 1]]).mean())


def self_intersecting(mesh: MeshData, folder: Path) -> Bools:
    """(m,) the faces that cut others, found in this process; the mesh is centred: MeshLab's tests lose digits far from 0."""
    proper = proper_faces(mesh.faces)  # MeshLab drops degenerate faces, which cut nothing
    if not proper.any():
        return proper
    middle = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
    document = Document(folder)
    document.add(MeshData(vertices=mesh.vertices - middle, faces=mesh.faces[proper]))
    document.apply(Step(find_filter("compute_selection_by_self_intersections_per_face"), {}, 0))
    cuts = np.zeros(len(proper), dtype=np.bool_)
    cuts[proper] = document.current.face_selection
    return cuts


def self_intersecting_apart(mesh: MeshData) -> Bools:
    """Like `self_intersecting`, in a separate process, because MeshLab may crash."""
    alone = MeshData(vertices=mesh.vertices, faces=mesh.faces)
    with tempfile.TemporaryDirectory(prefix="pymeshfair-cuts-") as folder, Pool() as pool, pool.lend() as process:
        answer = process.do(Order.of(self_intersecting, alone, Path(folder), memory_limit=this_system().usable_memory()))
    if answer.error is not None:
        raise RunError(f"MeshLab's search for faces that cut others failed: {answer.error}") from answer.error
    return np.asarray(answer.result)

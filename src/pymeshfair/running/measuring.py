"""Measures of a mesh: before and after the steps of a run, or its size alone; and the faces that cut others.

MeshLab finds these. It ends the process on some meshes, so that a process of its own looks for them, but at the end of a run.
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

_SOME = 10_000  # faces that a usual length is found from


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


def self_intersecting(mesh: MeshData, folder: Path) -> Bools:
    """(m,) the faces that cut others, about the middle, where MeshLab's tests have all their digits; in this process."""
    proper = proper_faces(mesh.faces)  # MeshLab drops the others, which cut nothing
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
    """The same in a process of its own, which MeshLab may end."""
    alone = MeshData(vertices=mesh.vertices, faces=mesh.faces)
    with tempfile.TemporaryDirectory(prefix="pymeshfair-cuts-") as folder, Pool() as pool, pool.lend() as process:
        answer = process.do(Order.of(self_intersecting, alone, Path(folder), memory_limit=this_system().usable_memory()))
    if answer.error is not None:
        raise RunError(f"MeshLab did not look for faces that cut others: {answer.error}") from answer.error
    faces: Bools = answer.result
    return faces

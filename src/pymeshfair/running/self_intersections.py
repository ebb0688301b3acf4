"""The faces that cut others, as MeshLab finds them."""

import tempfile
from pathlib import Path

import numpy as np

from ..declaration import Bools
from ..errors import RunError
from ..filters.topology import proper_faces
from ..mesh_data import MeshData
from ..operating_system import this_system
from ..processes.process import Pool
from ..processes.worker import Order
from ..registry import find_filter
from ..scripts.script import Step
from .document import Document


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

"""Writes a mesh to a file of arrays, for another process that looks at it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..declaration import Bools
from ..files.formats import attributes_of
from ..mesh_data import MeshData
from ..registry import find_filter
from ..scripts.script import Step
from .document import Document

#: names of arrays, and what `pymeshfair.files.formats.ATTRIBUTES` calls what they hold
_ARRAYS = {
    "vertex_normals": "vertex normals",
    "vertex_scalars": "vertex scalars",
    "vertex_colors": "vertex colours",
    "face_scalars": "face scalars",
    "face_colors": "face colours",
}


def write_arrays(mesh: MeshData, path: Path, *, intersections: Path | None) -> None:
    """Write what a mesh has.

    Args:
        mesh: the mesh.
        path: the .npz file to write.
        intersections: a folder for the files of MeshLab, which then finds the faces that cut others; None to leave that out.
    """
    present = attributes_of(mesh)
    arrays = {"vertices": mesh.vertices, "faces": mesh.faces, "edges": mesh.edges}
    arrays |= {name: getattr(mesh, name) for name, attribute in _ARRAYS.items() if attribute in present}
    if intersections is not None:
        arrays["self_intersecting"] = self_intersecting(mesh, intersections)
    np.savez(path, **arrays)  # type: ignore[arg-type]


def self_intersecting(mesh: MeshData, folder: Path) -> Bools:
    """(m,) the faces that cut others, as MeshLab finds them; near the origin, where its tests have all their digits."""
    if not len(mesh.faces):
        return np.zeros(0, dtype=np.bool_)
    middle = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
    document = Document(folder)
    document.add(MeshData(vertices=mesh.vertices - middle, faces=mesh.faces))
    document.apply(Step(find_filter("compute_selection_by_self_intersections_per_face"), {}, 0))
    chosen = document.current
    found = np.zeros(len(mesh.faces), np.bool_)
    ids = np.arange(len(chosen.faces)) if chosen.face_ids is None else chosen.face_ids
    found[ids[chosen.face_selection & (ids >= 0)]] = True
    return found

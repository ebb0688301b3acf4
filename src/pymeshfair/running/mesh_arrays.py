"""Writes the current mesh to a file of arrays, for a supervisor that looks at it without MeshLab."""

from __future__ import annotations

from collections.abc import Set
from pathlib import Path
from typing import Any

import numpy as np

from ..declaration import Bools

#: name of the array, what `pymeshfair.files.formats.ATTRIBUTES` calls it, and pymeshlab's method; None: every mesh has it
_ARRAYS = (
    ("vertices", None, "vertex_matrix"),
    ("faces", None, "face_matrix"),
    ("edges", None, "edge_matrix"),
    ("vertex_normals", "vertex normals", "vertex_normal_matrix"),
    ("vertex_scalars", "vertex scalars", "vertex_scalar_array"),
    ("vertex_colors", "vertex colours", "vertex_color_matrix"),
    ("face_scalars", "face scalars", "face_scalar_array"),
    ("face_colors", "face colours", "face_color_matrix"),
)


def write_arrays(meshes: Any, present: Set[str], path: Path, *, intersections: bool) -> None:
    """Write what the current mesh has.

    Args:
        meshes: the mesh set.
        present: which attributes the mesh has.
        path: the .npz file to write.
        intersections: whether to find the faces that cut others; the mesh is shifted for that.
    """
    mesh = meshes.current_mesh()
    arrays = {
        name: np.ascontiguousarray(getattr(mesh, method)())
        for name, attribute, method in _ARRAYS
        if attribute is None or attribute in present
    }
    arrays["faces"], arrays["edges"] = arrays["faces"].astype(np.int32), arrays["edges"].astype(np.int32)
    if intersections:
        arrays["self_intersecting"] = _self_intersecting(meshes)
    np.savez(path, **arrays)  # type: ignore[arg-type]


def _self_intersecting(meshes: Any) -> Bools:
    """(m,) the faces that cut others, as MeshLab finds them; near the origin, where its tests have all their digits."""
    if meshes.current_mesh().face_number() == 0:
        return np.zeros(0, dtype=np.bool_)
    meshes.apply_filter("compute_matrix_from_translation", traslmethod="Center on Layer BBox")
    meshes.apply_filter("compute_selection_by_self_intersections_per_face")
    return np.asarray(meshes.current_mesh().face_selection_array(), dtype=np.bool_)

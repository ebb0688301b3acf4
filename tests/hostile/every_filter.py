"""What a filter makes of an awkward mesh, and whether that may be so."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
import pymeshlab

import pymeshfair
from pymeshfair.declaration import Filter
from pymeshfair.errors import PymeshfairError
from tests.meshes import Floats, Mesh

#: diagonals that a vertex may be moved by, or lie beyond the box of the mesh
BOUND = 2.0


def complaint_about(declared: Filter, mesh: Mesh, values: Mapping[str, Any]) -> str | None:
    """What is wrong with how a filter treats a mesh of which half is selected; None if it ends well or refuses in plain words."""
    vertices, faces = mesh
    meshes = pymeshfair.MeshSet()
    meshes.on_note = lambda note: None
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces, v_scalar_array=np.linspace(0.0, 1.0, len(vertices))))
    meshes.compute_selection_by_condition_per_vertex(condselect="q < 0.5")
    meshes.compute_selection_by_condition_per_face(condselect="q0 < 0.5 && q1 < 0.5")
    before = meshes.current_mesh().vertex_matrix()
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        try:
            meshes.apply_filter(declared.python_name, **values)
        except pymeshlab.PyMeshLabException as error:
            cause = error.__cause__
            if not isinstance(error, PymeshfairError) or not (cause is None or isinstance(cause, PymeshfairError)):
                return f"raises {type(cause or error).__name__}: {str(cause or error)[:120]}"
            return None
        except Exception as error:
            return f"raises {type(error).__name__}: {str(error)[:120]}"
    if heard:
        return f"warns: {heard[0].message}"
    return _complaint_about_result(before, meshes.current_mesh(), faces)


def _complaint_about_result(before: Floats, mesh: Any, faces: np.ndarray) -> str | None:
    after = mesh.vertex_matrix()
    if not np.isfinite(after).all() or not np.isfinite(mesh.vertex_scalar_array()).all():
        return "makes numbers that are not finite"
    proper = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
    used = np.zeros(len(before), dtype=bool)
    used[proper] = True
    strays = np.flatnonzero(~used)
    if len(after) < len(before) or not np.array_equal(before[strays], after[strays]) or not used.any():
        used[:] = True  # as it does to a filter of clouds
    scale = np.abs(before[used]).max() or 1.0
    low, high = before[used].min(axis=0) / scale, before[used].max(axis=0) / scale
    reach = BOUND * float(np.linalg.norm(high - low)) * (1 + 1e-9) + 1e-12
    count = min(len(before), len(after))
    moved = np.linalg.norm(after[:count] / scale - before[:count] / scale, axis=1)
    if moved.max() > reach:
        return f"moves vertex {int(moved.argmax())} by {moved.max() / reach * BOUND:.3g} diagonals"
    new = after[len(before) :] / scale
    if len(new) and max((low - new).max(), (new - high).max()) > reach:
        return "puts a new vertex far outside of the mesh"
    return None

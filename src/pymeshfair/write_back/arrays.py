"""Reads the arrays of a pymeshlab mesh."""

from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..mesh_data import as_levels

_READ: dict[str, tuple[str, type]] = {
    "vertices": ("vertex_matrix", np.float64),
    "faces": ("face_matrix", np.int32),
    "edges": ("edge_matrix", np.int32),
    "vertex_selection": ("vertex_selection_array", np.bool_),
    "face_selection": ("face_selection_array", np.bool_),
    "vertex_scalars": ("vertex_scalar_array", np.float64),
    "face_scalars": ("face_scalar_array", np.float64),
    "vertex_colors": ("vertex_color_matrix", np.float64),
    "face_colors": ("face_color_matrix", np.float64),
    "vertex_normals": ("vertex_normal_matrix", np.float64),
    "face_normals": ("face_normal_matrix", np.float64),
}
#: What an `Edit` can change without adding or removing elements; a layer has attributes of the same names.
EDITABLE = tuple(name for name in _READ if name not in ("faces", "edges"))


def read_array(mesh: Any, name: str) -> NDArray[Any]:
    """One of the arrays of `Layer`, copied from the mesh, C-contiguous (pymeshlab's own are column by column).

    Face normals are right only while the mesh has no matrix; see `Workbench.matrix_aside`.
    """
    method, dtype = _READ[name]
    try:
        return np.ascontiguousarray(getattr(mesh, method)(), dtype=dtype)
    except pymeshlab.MissingCompactnessException:
        # Deleted elements still have their places, as in a mesh edited through other bindings; MeshLab itself compacts
        # after each filter.
        mesh.compact()
        return np.ascontiguousarray(getattr(mesh, method)(), dtype=dtype)


def attributes_of(mesh: Any, element: str) -> dict[str, NDArray[Any]]:
    """The colours, scalars and selection of vertices or faces, as far as there are any, as `MeshData` has them."""
    found: dict[str, NDArray[Any]] = {}
    if getattr(mesh, f"has_{element}_color")():
        found["colors"] = as_levels(read_array(mesh, f"{element}_colors"))
    if getattr(mesh, f"has_{element}_scalar")():
        found["scalars"] = read_array(mesh, f"{element}_scalars")
    if getattr(mesh, f"selected_{element}_number")():
        found["selection"] = read_array(mesh, f"{element}_selection")
    return found


def empty_array(name: str) -> NDArray[Any]:
    """The same array of a mesh without elements."""
    columns = {"vertex_colors": (4,), "face_colors": (4,), "edges": (2,)}.get(name, (3,))
    flat = name.endswith(("selection", "scalars"))
    return np.empty((0,) if flat else (0, *columns), dtype=_READ[name][1])

"""Checks that what a filter gave back fits the mesh that it was given."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..declaration import Edit, Layer
from ..errors import MeshError

_WIDTHS = {"vertices": 3, "vertex_normals": 3, "face_normals": 3, "vertex_colors": 4, "face_colors": 4}
_FLAGS = ("vertex_selection", "face_selection", "delete_vertices", "delete_faces")
_NUMBERS = (*_WIDTHS, "vertex_scalars", "face_scalars")


def checked_edit(edit: Any, layer: Layer) -> Edit:
    """The edit with arrays of the types that `Edit` promises.

    Raises:
        MeshError: it is no `Edit`, an array's length is not that of the mesh, or a number is NaN or infinite; the message begins
            with a verb, for the filter's name to go before it.
    """
    if not isinstance(edit, Edit):
        raise MeshError(f"gave back {type(edit).__name__} instead of an Edit")
    changes: dict[str, Any] = {}
    for name in (*_NUMBERS, *_FLAGS):
        value = getattr(edit, name)
        if value is not None:
            per_face = name in ("delete_faces",) or name.startswith("face_")
            rows = len(layer.faces) if per_face else len(layer.vertices)
            changes[name] = _checked(name, value, rows)
    return replace(edit, **changes) if changes else edit


def _checked(name: str, value: Any, rows: int) -> NDArray[Any]:
    dtype = np.bool_ if name in _FLAGS else np.float64
    array = np.asarray(value)
    if array.dtype != dtype and (name in _FLAGS or not np.issubdtype(array.dtype, np.number)):
        raise MeshError(f"gave back {name} of type {array.dtype}; they must be {np.dtype(dtype)}")
    array = array.astype(dtype, copy=False)
    shape = (rows, _WIDTHS[name]) if name in _WIDTHS else (rows,)
    if array.shape != shape:
        raise MeshError(f"gave back {name} of shape {array.shape}; this mesh needs {shape}")
    if name in _NUMBERS and not np.isfinite(array).all():
        bad = ~np.isfinite(array.reshape(rows, -1)).all(axis=1)
        raise MeshError(f"gave back {name} with NaN or infinity in {int(bad.sum())} of {rows} rows, first in row {bad.argmax()}")
    if name.endswith("colors") and not ((array >= 0.0) & (array <= 1.0)).all():
        raise MeshError(f"gave back {name} outside 0 to 1, from {array.min():g} to {array.max():g}")
    return array


def adds_or_removes(edit: Edit) -> bool:
    """Whether the edit changes how many elements or layers there are, so that nothing can be put off beyond it."""
    deletes = any(x is not None and x.any() for x in (edit.delete_vertices, edit.delete_faces))
    return deletes or bool(edit.new_layers)

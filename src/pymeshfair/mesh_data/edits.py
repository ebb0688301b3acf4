"""Checks that the edit of a filter fits its mesh."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..declaration import Edit, Layer
from ..errors import MeshError

_WIDTHS = {"vertices": 3, "added_vertices": 3, "vertex_normals": 3, "face_normals": 3, "vertex_colors": 4, "face_colors": 4}
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
    changes: dict[str, Any] = _added(edit, layer)
    rows = {"vertex": len(layer.vertices), "face": len(layer.faces)}
    if edit.vertices is not None:
        changes["vertices"] = _checked("vertices", edit.vertices, rows["vertex"])
    if adds(edit):
        rows["vertex"] += len(changes.get("added_vertices", ()))
        rows["face"] += len(changes.get("added_faces", ()))
    for name in (*_NUMBERS, *_FLAGS):
        value = getattr(edit, name)
        if value is not None and name not in changes:
            per_face = name in ("delete_faces",) or name.startswith("face_")
            changes[name] = _checked(name, value, rows["face" if per_face else "vertex"])
    return replace(edit, **changes) if changes else edit


def _added(edit: Edit, layer: Layer) -> dict[str, Any]:
    """The added vertices and faces, checked; by name, those that are not None."""
    added: dict[str, Any] = {}
    if edit.added_vertices is not None:
        added["added_vertices"] = _checked("added_vertices", edit.added_vertices, len(np.atleast_1d(edit.added_vertices)))
    if edit.added_faces is not None:
        count = len(layer.vertices) + len(added.get("added_vertices", ()))
        added["added_faces"] = _checked_faces(np.asarray(edit.added_faces), count)
    if adds(edit) and not len(layer.faces):
        raise MeshError(
            f"gave back elements to add to {layer.label!r}, which has no faces; MeshLab can add to meshes with faces alone, "
            "others need a new layer"
        )
    return added


def _checked_faces(faces: NDArray[Any], vertices: int) -> NDArray[np.int32]:
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
        raise MeshError(f"gave back added_faces of shape {faces.shape} and type {faces.dtype}; they must be (b, 3) whole numbers")
    wrong = ((faces < 0) | (faces >= vertices)).any(axis=1)
    if wrong.any():
        first = int(wrong.argmax())
        raise MeshError(
            f"gave back {int(wrong.sum())} added_faces with indices outside 0 to {vertices - 1}, first in row {first}: "
            f"{faces[first].tolist()}"
        )
    twice = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    if twice.any():
        first = int(twice.argmax())
        raise MeshError(
            f"gave back {int(twice.sum())} added_faces with the same vertex twice, first in row {first}: {faces[first].tolist()}"
        )
    return faces.astype(np.int32, copy=False)


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


def adds(edit: Edit) -> bool:
    """Whether the edit adds vertices or faces to the layer."""
    return any(value is not None and len(value) > 0 for value in (edit.added_vertices, edit.added_faces))


def adds_or_removes(edit: Edit) -> bool:
    """Whether the edit changes how many elements or layers there are, so that it cannot be deferred."""
    deletes = any(x is not None and x.any() for x in (edit.delete_vertices, edit.delete_faces))
    return deletes or adds(edit) or bool(edit.new_layers)

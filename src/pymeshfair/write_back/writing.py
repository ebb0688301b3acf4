"""Writes an `Edit` to the current layer of a pymeshlab mesh set, in place and exactly, and changes nothing else.

A layer is put back as it was when adding elements to it fails or is interrupted.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Any

import numpy as np
import pymeshlab

from ..declaration import Edit, NewLayer
from ..errors import MeshError
from ..mesh_data import adds
from ..meshlab.base import BASE
from .addition import add_elements, write_vertex_uv, write_wedge_uv
from .arrays import EDITABLE, read_array
from .attributes import ELEMENTS, explain
from .growth import shrink
from .values import verify, write_selection, write_values
from .workbench import Workbench

_FAILURES = (MeshError, pymeshlab.PyMeshLabException, RuntimeError, ValueError)


@contextmanager
def undone_on_failure(bench: Workbench, mesh: Any) -> Iterator[None]:
    """The current layer without its matrix; if the context ends with any exception, the layer becomes what it was.

    What is deleted within the context does not come back. Three things MeshLab cannot take away again: scalars and colours of
    faces, and texture coordinates of vertices, that the mesh did not have; nor does it make polygons of triangles.

    Raises:
        MeshError: something failed, and something else could not be put back.
    """
    base = BASE
    layers = {layer.id() for layer in base.__iter__(bench.meshset)}
    matrix = mesh.transform_matrix()
    before: _Before | None = None
    try:
        with bench.matrix_aside(mesh):
            before = _Before(mesh)
            yield
    except BaseException as error:
        for layer in [layer.id() for layer in base.__iter__(bench.meshset)]:
            if layer not in layers:  # a helper layer that an interruption has left
                base.set_current_mesh(bench.meshset, layer)
                bench.apply("delete_current_mesh")
                bench.helper_ids[:] = sorted({*bench.helper_ids, layer})
        base.set_current_mesh(bench.meshset, mesh.id())
        lost: list[str] = []
        if before is not None:
            _set_matrix(bench, mesh, np.eye(4))
            lost = before.put_back(bench, mesh)
        _set_matrix(bench, mesh, matrix)
        if lost and isinstance(error, Exception):
            raise MeshError(f"{error}; and {', '.join(lost)} of {mesh.label()!r} could not be put back") from error
        raise


def _set_matrix(bench: Workbench, mesh: Any, matrix: Any) -> None:
    if not np.array_equal(mesh.transform_matrix(), matrix):
        bench.apply("set_matrix", transformmatrix=matrix, compose=False, freeze=False)


class _Before:
    """The arrays of a layer without a matrix that an addition changes."""

    def __init__(self, mesh: Any) -> None:
        self._faces = read_array(mesh, "faces")
        self._values = {name: read_array(mesh, name) for name in EDITABLE if _has(mesh, name)}
        self._uv = mesh.vertex_tex_coord_matrix() if mesh.has_vertex_tex_coord() else None
        self._wedges = mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2) if mesh.has_wedge_tex_coord() else None

    def put_back(self, bench: Workbench, mesh: Any) -> list[str]:
        """Restore the current layer; returns what could not be restored, in words."""
        lost = []
        try:
            shrink(bench, mesh, len(self._values["vertices"]), self._faces)
        except _FAILURES:
            lost.append("faces")
        if self._wedges is not None and not lost:
            now = mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2)
            for face in np.flatnonzero(((now != self._wedges) & ~np.isnan(self._wedges)).any(axis=(1, 2))):
                with suppress(*_FAILURES):
                    write_wedge_uv(bench, mesh, self._wedges, np.empty((0, 2)), int(face))
            if not np.array_equal(mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2), self._wedges, equal_nan=True):
                lost.append("texture coordinates")
        if self._uv is not None and not lost:
            try:
                write_vertex_uv(bench, mesh, self._uv)
            except _FAILURES:
                lost.append("texture coordinates of vertices")
        # Normals come last: they change with the coordinates. Helper attributes may use up the selection on their way in.
        for name in (*(name for name in EDITABLE if not name.endswith("selection")), "vertex_selection", "face_selection"):
            if name in self._values and not _same(mesh, name, self._values[name]):
                changes: dict[str, Any] = {name: self._values[name]}
                try:
                    write_values(bench, mesh, replace(Edit(), **changes))
                except _FAILURES:
                    lost.append(name.replace("_", " "))
        return lost


def _has(mesh: Any, name: str) -> bool:
    return name not in ("face_scalars", "face_colors") or bool(getattr(mesh, f"has_{name[:-1]}")())


def _same(mesh: Any, name: str, wanted: Any) -> bool:
    return np.array_equal(read_array(mesh, name), wanted, equal_nan=wanted.dtype.kind == "f")


def write_edit(bench: Workbench, edit: Edit) -> tuple[str, ...]:
    """Make the current layer what the edit says; the edit has been checked (`checked_edit`).

    Coordinates keep every bit except the sign of a zero. The normals of a mesh with faces follow from new coordinates, as after
    any filter of MeshLab. New layers come last and the first becomes the current one.

    If adding elements fails or is interrupted, the mesh is put back (`undone_on_failure`); an interrupted deletion is not.

    Returns:
        Sentences about what could not be kept, for the user to read.

    Raises:
        MeshError: MeshLab cannot hold or delete what the edit says.
    """
    mesh = BASE.current_mesh(bench.meshset) if BASE.mesh_number(bench.meshset) else None
    notes: tuple[str, ...] = ()
    if mesh is not None:
        try:
            _check_deletable(mesh, edit)
            if adds(edit):
                with undone_on_failure(bench, mesh):
                    edit, notes = add_elements(bench, mesh, edit)
                    write_values(bench, mesh, edit)
            else:
                with bench.matrix_aside(mesh):
                    write_values(bench, mesh, edit)
            _delete(bench, mesh, edit)
        except (pymeshlab.PyMeshLabException, RuntimeError) as error:  # pymeshlab's two ways to say that a filter failed
            raise explain(bench, error) from error
    for index, layer in enumerate(edit.new_layers):
        _add_layer(bench, layer, current=index == 0)
    return notes


def _check_deletable(mesh: Any, edit: Edit) -> None:
    gone = edit.delete_vertices
    if gone is None or not gone.any():
        return
    edges = read_array(mesh, "edges")
    if len(edges) and gone[edges].any():
        raise MeshError(
            f"MeshLab cannot delete edges, so the {int(gone[edges].any(axis=1).sum())} edges of {mesh.label()!r} that end in "
            "vertices to be deleted would lose an end; select the vertices and build the polyline anew from the others"
        )


def _delete(bench: Workbench, mesh: Any, edit: Edit) -> None:
    if not any(x is not None and x.any() for x in (edit.delete_vertices, edit.delete_faces)):
        return
    vertices, faces = read_array(mesh, "vertices"), read_array(mesh, "faces")
    selected = [read_array(mesh, f"{element}_selection") for element in ELEMENTS]
    gone = np.zeros(len(vertices), dtype=np.bool_) if edit.delete_vertices is None else edit.delete_vertices
    gone_faces = gone[faces].any(axis=1)
    if edit.delete_faces is not None:
        gone_faces |= edit.delete_faces
    for element, doomed in (("face", gone_faces), ("vertex", gone)):
        if doomed.any():
            write_selection(bench, mesh, element, doomed)  # type: ignore[arg-type]
            bench.apply("meshing_remove_selected_faces" if element == "face" else "meshing_remove_selected_vertices")
    for element, before, doomed in zip(ELEMENTS, selected, (gone, gone_faces), strict=True):
        write_selection(bench, mesh, element, before[~doomed])
    verify(mesh, "vertices", vertices[~gone])
    verify(mesh, "faces", (np.cumsum(~gone) - 1)[faces[~gone_faces]])


def _add_layer(bench: Workbench, layer: NewLayer, *, current: bool) -> None:
    arrays: dict[str, Any] = {
        "vertex_matrix": layer.vertices,
        "face_matrix": layer.faces,
        "edge_matrix": layer.edges,
        "v_normals_matrix": layer.vertex_normals,
        "v_scalar_array": layer.vertex_scalars,
    }
    values = {name: np.asarray(value) for name, value in arrays.items() if value is not None}
    try:
        mesh = pymeshlab.Mesh(**values)
    except (pymeshlab.PyMeshLabException, TypeError) as error:
        raise MeshError(f"the new layer {layer.label!r} is no mesh that MeshLab can hold: {error}") from error
    BASE.add_mesh(bench.meshset, mesh, layer.label, current)

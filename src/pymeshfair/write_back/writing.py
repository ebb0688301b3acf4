"""Writes an `Edit` to the current layer of a pymeshlab mesh set, in place and exactly, and changes nothing else."""

from __future__ import annotations

from typing import Any

import numpy as np
import pymeshlab

from ..declaration import Edit, NewLayer
from ..errors import MeshError
from ..mesh_data import adds
from ..meshlab.base import BASE
from .addition import add_elements
from .arrays import read_array
from .attributes import ELEMENTS, explain
from .rollback import undone_on_failure
from .values import verify, write_selection, write_values
from .workbench import Workbench


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

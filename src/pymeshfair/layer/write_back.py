"""Writes an `Edit` to the current layer of a pymeshlab mesh set, in place and to the bit, and touches nothing else.

pymeshlab has no call that sets an array of an existing mesh, so MeshLab's own filters carry the numbers: coordinates of a mesh
with faces morph to those of a helper layer, everything else comes in as custom attributes (`attributes`) and is copied
"by function". Each result is read back and compared.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Bools, Edit, Floats, NewLayer
from ..errors import MeshError
from .addition import add_elements
from .arrays import read_array
from .attributes import Element, bring_in, explain, has_room, spare_names
from .edits import adds
from .refill import move_points
from .workbench import Workbench

_SELECTED_BY = {"vertex": "compute_selection_by_condition_per_vertex", "face": "compute_selection_by_condition_per_face"}
_SCALAR_BY = {"vertex": "compute_scalar_by_function_per_vertex", "face": "compute_scalar_by_function_per_face"}
_NORMAL_BY = {"vertex": "compute_normal_by_function_per_vertex", "face": "compute_normal_by_function_per_face"}
_COLOR_BY = {"vertex": "compute_color_by_function_per_vertex", "face": "compute_color_by_function_per_face"}
_COLOR_CHANNELS = {"vertex": "xyza", "face": "rgba"}
_ELEMENTS: tuple[Element, Element] = ("vertex", "face")

#: A morph is s + (t - s) in floating point; from what the first leaves over, the second reaches t exactly.
_MOST_MORPHS = 3


def write_edit(bench: Workbench, edit: Edit) -> tuple[str, ...]:
    """Make the current layer what the edit says; the edit has been checked (`checked_edit`).

    Coordinates keep every bit except the sign of a zero. The normals of a mesh with faces follow from new coordinates, as after
    any filter of MeshLab. New layers come last and the first becomes the current one.

    Returns:
        Sentences about what could not be kept, for the user to read.

    Raises:
        MeshError: MeshLab cannot hold or delete what the edit says.
    """
    mesh = pymeshlab.MeshSet.current_mesh(bench.meshset) if pymeshlab.MeshSet.mesh_number(bench.meshset) else None
    notes: tuple[str, ...] = ()
    if mesh is not None:
        try:
            with bench.matrix_aside(mesh):
                if adds(edit):
                    edit, notes = add_elements(bench, mesh, edit)
                _write_values(bench, mesh, edit)
                _delete(bench, mesh, edit)
        except (pymeshlab.PyMeshLabException, RuntimeError) as error:  # pymeshlab's two ways to say that a filter failed
            raise explain(bench, error) from error
    for index, layer in enumerate(edit.new_layers):
        _add_layer(bench, layer, current=index == 0)
    return notes


def _write_values(bench: Workbench, mesh: Any, edit: Edit) -> None:
    for element in _ELEMENTS:
        if (scalars := getattr(edit, f"{element}_scalars")) is not None:
            _write_scalars(bench, mesh, element, scalars)
        if (colors := getattr(edit, f"{element}_colors")) is not None:
            _write_colors(bench, mesh, element, colors)
        if (selection := getattr(edit, f"{element}_selection")) is not None:
            _write_selection(bench, mesh, element, selection)
    if edit.vertices is not None:
        _write_vertices(bench, mesh, edit.vertices)
    for element in _ELEMENTS:
        if (normals := getattr(edit, f"{element}_normals")) is not None:
            _write_normals(bench, mesh, element, normals)


def _write_vertices(bench: Workbench, mesh: Any, vertices: Floats) -> None:
    if np.array_equal(read_array(mesh, "vertices"), vertices):
        return
    if mesh.face_number():
        with bench.helper_layer(pymeshlab.Mesh(vertex_matrix=vertices)) as target:
            for _ in range(_MOST_MORPHS):
                bench.apply("compute_coord_linear_morphing", targetmesh=target, percentmorph=100)
                if np.array_equal(read_array(mesh, "vertices"), vertices):
                    return
    elif not has_room(bench, "vertex", 6):
        move_points(bench, mesh, spare_names(), vertices)
    else:
        normals = read_array(mesh, "vertex_normals")
        x, y, z = bring_in(bench, mesh, "vertex", list(vertices.T))
        bench.apply("compute_coord_by_function", x=x, y=y, z=z)
        _write_normals(bench, mesh, "vertex", normals)  # MeshLab has normalised them on the way
    _verify(mesh, "vertices", vertices)


def _write_normals(bench: Workbench, mesh: Any, element: Element, normals: Floats) -> None:
    if np.array_equal(read_array(mesh, f"{element}_normals"), normals):
        return
    x, y, z = bring_in(bench, mesh, element, list(normals.T))
    bench.apply(_NORMAL_BY[element], x=x, y=y, z=z)
    _verify(mesh, f"{element}_normals", normals)


def _write_scalars(bench: Workbench, mesh: Any, element: Element, scalars: Floats) -> None:
    known = getattr(mesh, f"has_{element}_scalar")()
    if known and np.array_equal(read_array(mesh, f"{element}_scalars"), scalars):
        return
    (name,) = bring_in(bench, mesh, element, [scalars])
    bench.apply(_SCALAR_BY[element], q=name)
    _verify(mesh, f"{element}_scalars", scalars)


def _write_colors(bench: Workbench, mesh: Any, element: Element, colors: Floats) -> None:
    channels = np.rint(colors * 255.0)
    known = getattr(mesh, f"has_{element}_color")()
    if known and np.array_equal(_channels(mesh, element), channels):
        return
    # The four bytes travel in one number and are taken apart there; rint(x - 0.49...) is what muParser has for floor(x).
    (name,) = bring_in(bench, mesh, element, [channels @ [1.0, 256.0, 65536.0, 16777216.0]])
    below = [f"rint({name}/{256**k}-0.49999998509883881)" for k in (1, 2, 3)]
    bytes_ = (f"{name}-256*{below[0]}", f"{below[0]}-256*{below[1]}", f"{below[1]}-256*{below[2]}", below[2])
    bench.apply(_COLOR_BY[element], **dict(zip(_COLOR_CHANNELS[element], bytes_, strict=True)))
    if not np.array_equal(_channels(mesh, element), channels):
        raise MeshError(f"MeshLab did not take the new {element} colors; please report this")


def _channels(mesh: Any, element: Element) -> Floats:
    return np.rint(read_array(mesh, f"{element}_colors") * 255.0)


def _write_selection(bench: Workbench, mesh: Any, element: Element, selection: Bools) -> None:
    name = f"{element}_selection"
    if np.array_equal(read_array(mesh, name), selection):
        return
    if selection.all() or not selection.any():
        simply = "set_selection_all" if selection.any() else "set_selection_none"
        bench.apply(simply, allverts=element == "vertex", allfaces=element == "face")
    else:
        (attribute,) = bring_in(bench, mesh, element, [selection.astype(np.float64)])
        bench.apply(_SELECTED_BY[element], condselect=f"{attribute}>0.5")
    _verify(mesh, name, selection)


def _delete(bench: Workbench, mesh: Any, edit: Edit) -> None:
    if not any(x is not None and x.any() for x in (edit.delete_vertices, edit.delete_faces)):
        return
    vertices, faces, edges = (read_array(mesh, name) for name in ("vertices", "faces", "edges"))
    selected = [read_array(mesh, f"{element}_selection") for element in _ELEMENTS]
    gone = np.zeros(len(vertices), dtype=np.bool_) if edit.delete_vertices is None else edit.delete_vertices
    gone_faces = gone[faces].any(axis=1)
    if edit.delete_faces is not None:
        gone_faces |= edit.delete_faces
    if len(edges) and gone[edges].any():
        raise MeshError(
            f"MeshLab cannot delete edges, so the {int(gone[edges].any(axis=1).sum())} edges of {mesh.label()!r} that end in "
            "vertices to be deleted would lose an end; select the vertices and build the polyline anew from the others"
        )
    for element, doomed in (("face", gone_faces), ("vertex", gone)):
        if doomed.any():
            _write_selection(bench, mesh, element, doomed)  # type: ignore[arg-type]
            bench.apply("meshing_remove_selected_faces" if element == "face" else "meshing_remove_selected_vertices")
    for element, before, doomed in zip(_ELEMENTS, selected, (gone, gone_faces), strict=True):
        _write_selection(bench, mesh, element, before[~doomed])
    _verify(mesh, "vertices", vertices[~gone])
    _verify(mesh, "faces", (np.cumsum(~gone) - 1)[faces[~gone_faces]])


def _verify(mesh: Any, name: str, wanted: NDArray[Any]) -> None:
    if not np.array_equal(read_array(mesh, name), wanted):
        raise MeshError(
            f"MeshLab did not take the new {name.replace('_', ' ')} of {mesh.label()!r} exactly; please report this mesh"
        )


def _add_layer(bench: Workbench, layer: NewLayer, *, current: bool) -> None:
    arrays: dict[str, Any] = {
        "vertex_matrix": layer.vertices,
        "face_matrix": layer.faces,
        "edge_matrix": layer.edges,
        "v_normals_matrix": layer.vertex_normals,
        "v_scalar_array": layer.vertex_scalars,
    }
    given = {name: np.asarray(value) for name, value in arrays.items() if value is not None}
    try:
        mesh = pymeshlab.Mesh(**given)
    except (pymeshlab.PyMeshLabException, TypeError) as error:
        raise MeshError(f"the new layer {layer.label!r} is no mesh that MeshLab can hold: {error}") from error
    pymeshlab.MeshSet.add_mesh(bench.meshset, mesh, layer.label, current)

"""Replaces arrays of the current layer exactly, without adding or removing elements.

pymeshlab has no call that sets an array of an existing mesh, so MeshLab's own filters carry the numbers: coordinates of a mesh
with faces morph to those of a helper layer, everything else comes in as custom attributes (`attributes`) and is copied
"by function". Each result is read back and compared.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Bools, Edit, Floats
from ..errors import MeshError
from .arrays import read_array
from .attributes import ELEMENTS, Element, bring_in, has_room, spare_names
from .refill import move_points
from .workbench import Workbench

_SELECTED_BY = {"vertex": "compute_selection_by_condition_per_vertex", "face": "compute_selection_by_condition_per_face"}
_SCALAR_BY = {"vertex": "compute_scalar_by_function_per_vertex", "face": "compute_scalar_by_function_per_face"}
_NORMAL_BY = {"vertex": "compute_normal_by_function_per_vertex", "face": "compute_normal_by_function_per_face"}
_COLOR_BY = {"vertex": "compute_color_by_function_per_vertex", "face": "compute_color_by_function_per_face"}
_COLOR_CHANNELS = {"vertex": "xyza", "face": "rgba"}

#: A morph is s + (t - s) in floating point; from what the first leaves over, the second reaches t exactly.
_MOST_MORPHS = 3


def write_values(bench: Workbench, mesh: Any, edit: Edit) -> None:
    """Write the edit's scalars, colours, selection, coordinates and normals to the current layer, in this order.

    Raises:
        MeshError: MeshLab did not take them exactly.
    """
    for element in ELEMENTS:
        if (scalars := getattr(edit, f"{element}_scalars")) is not None:
            _write_scalars(bench, mesh, element, scalars)
        if (colors := getattr(edit, f"{element}_colors")) is not None:
            _write_colors(bench, mesh, element, colors)
        if (selection := getattr(edit, f"{element}_selection")) is not None:
            write_selection(bench, mesh, element, selection)
    if edit.vertices is not None:
        _write_vertices(bench, mesh, edit.vertices)
    for element in ELEMENTS:
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
        _write_normals(bench, mesh, "vertex", normals)  # MeshLab normalises them when it moves points
    verify(mesh, "vertices", vertices)


def _write_normals(bench: Workbench, mesh: Any, element: Element, normals: Floats) -> None:
    if np.array_equal(read_array(mesh, f"{element}_normals"), normals):
        return
    x, y, z = bring_in(bench, mesh, element, list(normals.T))
    bench.apply(_NORMAL_BY[element], x=x, y=y, z=z)
    verify(mesh, f"{element}_normals", normals)


def _write_scalars(bench: Workbench, mesh: Any, element: Element, scalars: Floats) -> None:
    had = getattr(mesh, f"has_{element}_scalar")()
    if had and np.array_equal(read_array(mesh, f"{element}_scalars"), scalars):
        return
    (name,) = bring_in(bench, mesh, element, [scalars])
    bench.apply(_SCALAR_BY[element], q=name)
    verify(mesh, f"{element}_scalars", scalars)


def _write_colors(bench: Workbench, mesh: Any, element: Element, colors: Floats) -> None:
    channels = np.rint(colors * 255.0)
    had = getattr(mesh, f"has_{element}_color")()
    if had and np.array_equal(_channels(mesh, element), channels):
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


def write_selection(bench: Workbench, mesh: Any, element: Element, selection: Bools) -> None:
    """Make the selection of vertices (or faces) of the current layer this one."""
    name = f"{element}_selection"
    if np.array_equal(read_array(mesh, name), selection):
        return
    if selection.all() or not selection.any():
        simply = "set_selection_all" if selection.any() else "set_selection_none"
        bench.apply(simply, allverts=element == "vertex", allfaces=element == "face")
    else:
        (attribute,) = bring_in(bench, mesh, element, [selection.astype(np.float64)])
        bench.apply(_SELECTED_BY[element], condselect=f"{attribute}>0.5")
    verify(mesh, name, selection)


def verify(mesh: Any, name: str, wanted: NDArray[Any]) -> None:
    """Raise `MeshError` if the mesh does not have this array."""
    if not np.array_equal(read_array(mesh, name), wanted):
        raise MeshError(
            f"MeshLab did not take the new {name.replace('_', ' ')} of {mesh.label()!r} exactly; please report this mesh"
        )

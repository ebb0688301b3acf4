"""Writes an `Edit` to the current layer of a pymeshlab mesh set, in place and exactly, and changes nothing else."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Bools, Edit, Floats, NewLayer
from ..errors import MeshError
from ..mesh_data import adds
from ..mesh_data.apply_edit import check_deletable, removes
from ..meshlab.base import BASE
from .additions import add_elements
from .workbench import ELEMENTS, Element, Workbench, bring_in, check_names, check_taken, read_array


def write_edit(bench: Workbench, edit: Edit) -> tuple[str, ...]:
    """Apply an edit, which has been checked (`checked_edit`), to the current layer; sentences about losses, for the user.

    Coordinates keep every bit except the sign of a zero. The normals of a mesh with faces follow from new coordinates, as after
    any filter of MeshLab. New layers come last and the first becomes the current one. Ctrl-C waits until all is written.
    """
    with _uninterrupted():
        notes = _write(bench, BASE.current_mesh(bench.meshset), edit) if bench.has_current() else ()
        for index, layer in enumerate(edit.new_layers):
            _add_layer(bench, layer, current=index == 0)
    return notes


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Ctrl-C has its effect at the end of the context: within it a mesh is not whole between two filters of MeshLab's."""
    usual = signal.getsignal(signal.SIGINT)
    if usual is None or threading.current_thread() is not threading.main_thread():  # where no signal comes, or none of Python's
        yield
        return
    came: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)
        if came:
            signal.raise_signal(signal.SIGINT)


def _write(bench: Workbench, mesh: Any, edit: Edit) -> tuple[str, ...]:
    notes: tuple[str, ...] = ()
    try:
        if edit.delete_vertices is not None:
            check_deletable(edit, read_array(mesh, "edges"), mesh.label())
        with bench.matrix_aside(mesh):
            if adds(edit):
                edit, notes = add_elements(bench, mesh, edit)
            _write_values(bench, mesh, edit)
        if removes(edit):
            _delete(bench, mesh, edit)
    except (pymeshlab.PyMeshLabException, RuntimeError) as error:  # pymeshlab's two ways to say that a filter failed
        check_names(bench, mesh)
        raise MeshError(f"MeshLab could not take the result: {error}") from error
    return notes


def _delete(bench: Workbench, mesh: Any, edit: Edit) -> None:
    vertices, faces = read_array(mesh, "vertices"), read_array(mesh, "faces")
    selected = [read_array(mesh, f"{element}_selection") for element in ELEMENTS]
    gone = np.zeros(len(vertices), dtype=np.bool_) if edit.delete_vertices is None else edit.delete_vertices
    gone_faces = gone[faces].any(axis=1)
    if edit.delete_faces is not None:
        gone_faces |= edit.delete_faces
    for element, doomed in (("face", gone_faces), ("vertex", gone)):
        if doomed.any():
            _write_selection(bench, mesh, element, doomed)  # type: ignore[arg-type]
            bench.apply("meshing_remove_selected_faces" if element == "face" else "meshing_remove_selected_vertices")
    for element, before, doomed in zip(ELEMENTS, selected, (gone, gone_faces), strict=True):
        _write_selection(bench, mesh, element, before[~doomed])
    _verify(mesh, "vertices", vertices[~gone])
    _verify(mesh, "faces", (np.cumsum(~gone) - 1)[faces[~gone_faces]])


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


_COLOR_CHANNELS = {"vertex": "xyza", "face": "rgba"}


def _write_values(bench: Workbench, mesh: Any, edit: Edit) -> None:
    """Write the edit's scalars, colours, selection, coordinates and normals to the current layer, in this order."""
    for element in ELEMENTS:
        if (scalars := getattr(edit, f"{element}_scalars")) is not None:
            _write_numbers(bench, mesh, element, "scalar", scalars)
        if (colors := getattr(edit, f"{element}_colors")) is not None:
            _write_colors(bench, mesh, element, colors)
        if (selection := getattr(edit, f"{element}_selection")) is not None:
            _write_selection(bench, mesh, element, selection)
    if edit.vertices is not None:
        _write_vertices(bench, mesh, edit.vertices)
    for element in ELEMENTS:
        if (normals := getattr(edit, f"{element}_normals")) is not None:
            _write_numbers(bench, mesh, element, "normal", normals)


def _write_vertices(bench: Workbench, mesh: Any, vertices: Floats) -> None:
    if np.array_equal(read_array(mesh, "vertices"), vertices, equal_nan=True):
        return
    if mesh.face_number():
        bench.move_to(mesh, vertices)
        return
    normals = read_array(mesh, "vertex_normals")
    x, y, z = bring_in(bench, mesh, "vertex", list(vertices.T))
    bench.apply("compute_coord_by_function", x=x, y=y, z=z)
    _write_numbers(bench, mesh, "vertex", "normal", normals)  # MeshLab normalises them when it moves points
    _verify(mesh, "vertices", vertices)


def _write_numbers(bench: Workbench, mesh: Any, element: Element, kind: str, values: Floats) -> None:
    """Write "normal"s or "scalar"s of vertices or faces."""
    name = f"{element}_{kind}s"
    had = kind == "normal" or getattr(mesh, f"has_{element}_scalar")()
    if had and np.array_equal(read_array(mesh, name), values, equal_nan=True):
        return
    brought = bring_in(bench, mesh, element, list(np.atleast_2d(values.T)))
    bench.apply(
        f"compute_{kind}_by_function_per_{element}", **dict(zip("xyz" if kind == "normal" else "q", brought, strict=True))
    )
    _verify(mesh, name, values)


def _write_colors(bench: Workbench, mesh: Any, element: Element, colors: Floats) -> None:
    channels = np.rint(colors * 255.0)
    had = getattr(mesh, f"has_{element}_color")()
    if had and np.array_equal(_channels(mesh, element), channels):
        return
    # The four bytes travel in one number and are taken apart there; rint(x - 0.49...) is what muParser has for floor(x).
    (name,) = bring_in(bench, mesh, element, [channels @ [1.0, 256.0, 65536.0, 16777216.0]])
    below = [f"rint({name}/{256**k}-0.49999998509883881)" for k in (1, 2, 3)]
    bytes_ = (f"{name}-256*{below[0]}", f"{below[0]}-256*{below[1]}", f"{below[1]}-256*{below[2]}", below[2])
    bench.apply(f"compute_color_by_function_per_{element}", **dict(zip(_COLOR_CHANNELS[element], bytes_, strict=True)))
    check_taken(mesh, _channels(mesh, element), channels, f"new {element} colors")


def _channels(mesh: Any, element: Element) -> Floats:
    return np.rint(read_array(mesh, f"{element}_colors") * 255.0)


def _write_selection(bench: Workbench, mesh: Any, element: Element, selection: Bools) -> None:
    """Make the selection of vertices (or faces) of the current layer this one."""
    name = f"{element}_selection"
    if np.array_equal(read_array(mesh, name), selection):
        return
    if selection.all() or not selection.any():
        alike = "all" if selection.any() else "none"
        bench.apply(f"set_selection_{alike}", allverts=element == "vertex", allfaces=element == "face")
    else:
        (attribute,) = bring_in(bench, mesh, element, [selection.astype(np.float64)])
        bench.apply(f"compute_selection_by_condition_per_{element}", condselect=f"{attribute}>0.5")
    _verify(mesh, name, selection)


def _verify(mesh: Any, name: str, wanted: NDArray[Any]) -> None:
    """Raise `MeshError` if the mesh does not have this array of `Layer`."""
    check_taken(mesh, read_array(mesh, name), wanted, f"new {name.replace('_', ' ')}")

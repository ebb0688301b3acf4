"""Writes an `Edit` to the current layer of a pymeshlab mesh set, in place and exactly."""

import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Bools, Edit, Floats, NewLayer
from ..errors import MeshError
from ..mesh_data import MeshData, Texture, adds
from ..mesh_data.apply_edit import check_deletable, removes, texture_donors, with_additions
from ..meshlab.base import BASE
from .attributes import ELEMENTS, Element, bring_in, check_names, clear_beyond, has_room, move_points
from .growth import check_growable, grow, shrink
from .workbench import EDITABLE, Workbench, attributes_of, check_taken, read_array, wedges_of

_FAILURES = (MeshError, pymeshlab.PyMeshLabException, RuntimeError, ValueError)


@contextmanager
def undone_on_failure(bench: Workbench, mesh: Any) -> Iterator[None]:
    """Restores the current layer, which has no transformation matrix, after an exception; raises `MeshError` if that fails.

    Deleted elements are not restored. Face scalars, face colours and vertex texture coordinates stay if the layer had none,
    and triangulated polygons stay triangles: MeshLab has no filter that undoes this.
    """
    layers, before = {layer.id() for layer in BASE.__iter__(bench.meshset)}, _Before(mesh)
    try:
        yield
    except BaseException as error:
        for helper in {layer.id() for layer in BASE.__iter__(bench.meshset)} - layers:  # left by an interruption
            BASE.set_current_mesh(bench.meshset, helper)
            bench.apply("delete_current_mesh")
            bench.helper_ids[:] = sorted({*bench.helper_ids, helper})
        BASE.set_current_mesh(bench.meshset, mesh.id())
        bench.set_matrix(mesh, np.eye(4))
        if (lost := before.put_back(bench, mesh)) and isinstance(error, Exception):
            raise MeshError(f"{error}; and {', '.join(lost)} of {mesh.label()!r} could not be put back") from error
        raise


class _Before:
    """Copies of the arrays that adding elements changes, read while the layer has no transformation matrix."""

    def __init__(self, mesh: Any) -> None:
        self._faces = read_array(mesh, "faces")
        lacking = [name for name in ("face_scalars", "face_colors") if not getattr(mesh, f"has_{name[:-1]}")()]
        self._values = {name: read_array(mesh, name) for name in EDITABLE if name not in lacking}
        self._uv = mesh.vertex_tex_coord_matrix() if mesh.has_vertex_tex_coord() else None
        self._wedges = wedges_of(mesh)

    def put_back(self, bench: Workbench, mesh: Any) -> list[str]:
        lost = []

        def restore(what: str, write: Callable[..., None], *values: Any) -> None:
            try:
                write(bench, mesh, *values)
            except _FAILURES:
                lost.append(what)

        restore("faces", shrink, len(self._values["vertices"]), self._faces)
        if not lost and self._wedges is not None:
            restore("texture coordinates", self._put_back_wedges)
        if not lost and self._uv is not None:
            restore("texture coordinates of vertices", write_vertex_uv, self._uv)
        # Coordinates change normals, so normals come later. Selections come last: restored texture coordinates change them.
        for name in (*(name for name in EDITABLE if not name.endswith("selection")), "vertex_selection", "face_selection"):
            if name in self._values:
                changes: dict[str, Any] = {name: self._values[name]}
                restore(name.replace("_", " "), write_values, Edit(**changes))
        return lost

    def _put_back_wedges(self, bench: Workbench, mesh: Any) -> None:
        assert self._wedges is not None
        is_same = np.isclose(wedges_of(mesh), self._wedges, rtol=0.0, atol=0.0, equal_nan=True).all(axis=(1, 2))
        if not is_same.all():
            write_wedge_uv(bench, mesh, self._wedges, np.empty((0, 2)), np.flatnonzero(~is_same))


def write_edit(bench: Workbench, edit: Edit, matrix: Floats | None = None) -> tuple[str, ...]:
    """Applies a checked edit (`checked_edit`) to the current layer; returns sentences about losses for the user.

    Coordinates keep every bit except the sign of a zero. New coordinates of a mesh with faces change its normals, as
    after any filter of MeshLab. New layers get `matrix`. They are added at the end, and the first becomes the current layer.

    If adding elements fails or is interrupted, the mesh is restored (`undone_on_failure`); an interrupted deletion is not undone.
    """
    mesh = BASE.current_mesh(bench.meshset) if bench.has_current() else None
    notes: tuple[str, ...] = ()
    if mesh is not None:
        try:
            if edit.delete_vertices is not None:
                check_deletable(edit, read_array(mesh, "edges"), mesh.label())
            with bench.matrix_aside(mesh) as before:
                with undone_on_failure(bench, mesh) if adds(edit) else nullcontext():
                    if adds(edit):
                        edit, notes = add_elements(bench, mesh, edit)
                    write_values(bench, mesh, edit)
                    if not removes(edit):
                        bench.set_matrix(mesh, before)  # here, so that an interruption of this step, too, undoes the addition
                _delete(bench, mesh, edit)
        except (pymeshlab.PyMeshLabException, RuntimeError) as error:  # pymeshlab raises either if a filter fails
            check_names(bench, mesh)
            raise MeshError(f"MeshLab could not take the result: {error}") from error
    for index, layer in enumerate(edit.new_layers):
        _add_layer(bench, layer, matrix, current=index == 0)
    return notes


def _delete(bench: Workbench, mesh: Any, edit: Edit) -> None:
    if not removes(edit):
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


def _add_layer(bench: Workbench, layer: NewLayer, matrix: Floats | None, *, current: bool) -> None:
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
    if matrix is not None:
        bench.set_matrix(max(BASE.__iter__(bench.meshset), key=lambda layer: int(layer.id())), matrix)


def add_elements(bench: Workbench, mesh: Any, edit: Edit) -> tuple[Edit, tuple[str, ...]]:
    """Adds the edit's vertices and faces to the current layer, which has faces and no transformation matrix.

    Returns an edit of the larger mesh with the values still to write, such as coordinates, and sentences about losses.
    """
    check_growable(mesh)
    check_names(bench, mesh)
    before, wedges = _as_data(bench, mesh), wedges_of(mesh)
    n, faces = len(before.vertices), before.faces
    enlarged, may_donate = with_additions(before, edit), texture_donors(before)
    remaining: dict[str, Any] = {"vertices": enlarged.vertices, "added_vertices": None, "added_faces": None}
    for element, attributes in zip(ELEMENTS, (enlarged.vertex_attributes, enlarged.face_attributes), strict=True):
        for name in ("selection", "scalars", "colors"):
            if name in attributes and getattr(edit, f"{element}_{name}") is None:
                remaining[f"{element}_{name}"] = attributes[name] / 255.0 if name == "colors" else attributes[name]

    # MeshLab gives new faces the texture of the face that they grow from. So the faces of one texture grow together.
    of_old, of_new = np.split(enlarged.face_attributes.get("texture", np.zeros(len(enlarged.faces), np.int32)), [len(faces)])
    order = np.append(np.arange(len(faces)), len(faces) + np.argsort(of_new, kind="stable"))
    grown = []
    for number in np.unique(of_new) if len(of_new) else of_old[may_donate][:1]:
        vertices, added = len(enlarged.vertices) - mesh.vertex_number(), enlarged.faces[len(faces) :][of_new == number]
        grown.append(grow(bench, mesh, vertices, added, may_donate & (of_old == number)))
    seeds, triangulated = zip(*grown, strict=True)
    clear_beyond(bench, mesh, "vertex", n)
    clear_beyond(bench, mesh, "face", len(faces))
    if wedges is not None:
        uv = enlarged.face_attributes["wedge_texture_coordinates"][order[len(faces) :], 0]
        write_wedge_uv(bench, mesh, wedges, uv, seeds)
    if (uv := enlarged.vertex_attributes.get("texture_coordinates")) is not None:
        write_vertex_uv(bench, mesh, uv)
    notes = ("all polygons became triangles, since new faces need a triangle to start from",) if any(triangulated) else ()
    edit = replace(edit, **remaining)
    of_faces = {k: v[order] for k, v in vars(edit).items() if v is not None and (k == "delete_faces" or k.startswith("face_"))}
    return replace(edit, **of_faces), notes


def _as_data(bench: Workbench, mesh: Any) -> MeshData:
    """Reads the layer and the attributes that determine the attributes of added elements."""
    vertices, faces = read_array(mesh, "vertices"), read_array(mesh, "faces")
    of = {e: {"selection": read_array(mesh, f"{e}_selection"), **attributes_of(mesh, e)} for e in ("vertex", "face")}
    textures: tuple[Texture, ...] = ()
    if (wedges := wedges_of(mesh)) is not None:
        of["face"]["wedge_texture_coordinates"] = wedges
        # `grow` also gives the vertices texture coordinates. Each vertex gets those of its first corner instead.
        uv = of["vertex"]["texture_coordinates"] = np.zeros((len(vertices), 2))
        uv[faces.ravel()[::-1]] = wedges.reshape(-1, 2)[::-1]
        textures = _image(mesh)
    if wedges is not None and mesh.texture_number() > 1:
        numbers = of["face"]["texture"] = np.full(len(faces), -1, np.int32)
        for number in range(mesh.texture_number()):
            bench.apply("compute_selection_by_condition_per_face", condselect=f"ti=={number}")
            numbers[read_array(mesh, "face_selection")] = number
        # Faces without an image are no donors.
        of["face"]["wedge_texture_coordinates"] = np.where(numbers[:, None, None] < 0, np.nan, wedges)
    if mesh.has_vertex_tex_coord():
        of["vertex"]["texture_coordinates"] = mesh.vertex_tex_coord_matrix()
    return MeshData(vertices=vertices, faces=faces, vertex_attributes=of["vertex"], face_attributes=of["face"], textures=textures)


def _image(mesh: Any) -> tuple[Texture, ...]:
    """Returns the image of a mesh with one texture; nothing for several, since pymeshlab does not give their numbers."""
    image = next(iter(mesh.textures().values())) if mesh.texture_number() == 1 else None
    if image is None or not (image.width() and image.height()):
        return ()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "texture.ppm"
        image.save(str(file))
        return (Texture("", file.read_bytes()),) if file.exists() else ()


def write_vertex_uv(bench: Workbench, mesh: Any, uv: Floats) -> None:
    """Sets the (n, 2) texture coordinates of the vertices."""
    if np.array_equal(mesh.vertex_tex_coord_matrix(), uv, equal_nan=True):
        return
    u, v = bring_in(bench, mesh, "vertex", list(uv.T))
    bench.apply("compute_texcoord_by_function_per_vertex", u=u, v=v, onselected=False)
    check_taken(mesh, mesh.vertex_tex_coord_matrix(), uv, "texture coordinates")


def write_wedge_uv(bench: Workbench, mesh: Any, wedges: Floats, uv: Floats, seeds: Iterable[int]) -> None:
    """Sets (a, 2) `uv` at all corners of the added faces, and restores the (m, 3, 2) `wedges` at the `seeds` of `grow`."""
    old = len(wedges)
    chosen = "||".join([f"fi>={old}", *(f"fi=={seed}" for seed in seeds)])
    bench.apply("compute_selection_by_condition_per_face", condselect=chosen)
    u, v = bring_in(bench, mesh, "face", list(np.concatenate([np.zeros((old, 2)), uv]).T))
    finite = np.where(np.isfinite(wedges), wedges, 0.0)
    expressions = {
        f"{axis}{corner}": "".join(f"fi=={seed}?{float(finite[seed, corner, column])!r}:" for seed in seeds) + name
        for corner in range(3)
        for column, (axis, name) in enumerate((("u", u), ("v", v)))
    }
    bench.apply("compute_texcoord_by_function_per_wedge", **expressions, onselected=True)
    check_taken(mesh, wedges_of(mesh), np.concatenate([wedges, np.repeat(uv[:, None], 3, axis=1)]), "texture coordinates")


_COLOR_CHANNELS = {"vertex": "xyza", "face": "rgba"}


def write_values(bench: Workbench, mesh: Any, edit: Edit) -> None:
    """Writes the edit's scalars, colours, selection, coordinates and normals to the current layer, in this order."""
    for element in ELEMENTS:
        if (scalars := getattr(edit, f"{element}_scalars")) is not None:
            _write_numbers(bench, mesh, element, "scalar", scalars)
        if (colors := getattr(edit, f"{element}_colors")) is not None:
            _write_colors(bench, mesh, element, colors)
        if (selection := getattr(edit, f"{element}_selection")) is not None:
            write_selection(bench, mesh, element, selection)
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
    if not has_room(bench, "vertex", 6):
        move_points(bench, mesh, vertices)
    else:
        normals = read_array(mesh, "vertex_normals")
        x, y, z = bring_in(bench, mesh, "vertex", list(vertices.T))
        bench.apply("compute_coord_by_function", x=x, y=y, z=z)
        _write_numbers(bench, mesh, "vertex", "normal", normals)  # MeshLab normalises normals when it moves points
    verify(mesh, "vertices", vertices)


def _write_numbers(bench: Workbench, mesh: Any, element: Element, kind: str, values: Floats) -> None:
    name = f"{element}_{kind}s"
    had = kind == "normal" or getattr(mesh, f"has_{element}_scalar")()
    if had and np.array_equal(read_array(mesh, name), values, equal_nan=True):
        return
    brought = bring_in(bench, mesh, element, list(np.atleast_2d(values.T)))
    parameters = dict(zip("xyz" if kind == "normal" else "q", brought, strict=True))
    bench.apply(f"compute_{kind}_by_function_per_{element}", **parameters)
    verify(mesh, name, values)


def _write_colors(bench: Workbench, mesh: Any, element: Element, colors: Floats) -> None:
    channels = np.rint(colors * 255.0)
    if getattr(mesh, f"has_{element}_color")() and np.array_equal(_channels(mesh, element), channels):
        return
    # One number holds the four bytes, and expressions split it; muParser has no floor(x), so they use rint(x - 0.49...).
    (name,) = bring_in(bench, mesh, element, [channels @ [1.0, 256.0, 65536.0, 16777216.0]])
    below = [f"rint({name}/{256**k}-0.49999998509883881)" for k in (1, 2, 3)]
    bytes_ = (f"{name}-256*{below[0]}", f"{below[0]}-256*{below[1]}", f"{below[1]}-256*{below[2]}", below[2])
    bench.apply(f"compute_color_by_function_per_{element}", **dict(zip(_COLOR_CHANNELS[element], bytes_, strict=True)))
    check_taken(mesh, _channels(mesh, element), channels, f"new {element} colors")


def _channels(mesh: Any, element: Element) -> Floats:
    return np.rint(read_array(mesh, f"{element}_colors") * 255.0)


def write_selection(bench: Workbench, mesh: Any, element: Element, selection: Bools) -> None:
    """Sets the selection of vertices or faces."""
    name = f"{element}_selection"
    if np.array_equal(read_array(mesh, name), selection):
        return
    if selection.all() or not selection.any():
        all_or_none = "all" if selection.any() else "none"
        bench.apply(f"set_selection_{all_or_none}", allverts=element == "vertex", allfaces=element == "face")
    else:
        (attribute,) = bring_in(bench, mesh, element, [selection.astype(np.float64)])
        bench.apply(f"compute_selection_by_condition_per_{element}", condselect=f"{attribute}>0.5")
    verify(mesh, name, selection)


def verify(mesh: Any, name: str, wanted: NDArray[Any]) -> None:
    """Raises `MeshError` unless the array of the mesh, named as in `Layer`, is exactly `wanted`."""
    check_taken(mesh, read_array(mesh, name), wanted, f"new {name.replace('_', ' ')}")

"""A pymeshlab mesh as the `Layer` that a filter reads, and MeshLab's filters applied silently, outside the filter script."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Bools, Floats, Ints, Layer
from ..errors import MeshError
from ..mesh_data import as_levels
from ..mesh_data.mesh_data import Has, Measures
from ..meshlab.base import BASE, MESHLAB, UnknownLayerError, apply_filter

#: A morph is s + (t - s) in floating point; from what the first leaves over, the second reaches t exactly.
_MOST_MORPHS = 3
#: by the names of `Layer`, pymeshlab's method that gives an array, and its type
_ARRAYS: dict[str, tuple[str, type]] = {
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
EDITABLE = tuple(name for name in _ARRAYS if name not in ("faces", "edges"))


def read_array(mesh: Any, name: str) -> NDArray[Any]:
    """One of the arrays of `Layer`, copied from the mesh, C-contiguous (pymeshlab's own are column by column).

    Face normals are right only while the mesh has no matrix; see `Workbench.matrix_aside`.
    """
    method, dtype = _ARRAYS[name]
    try:
        return np.ascontiguousarray(getattr(mesh, method)(), dtype=dtype)
    except pymeshlab.MissingCompactnessException:
        # Deleted elements still have their places, as in a mesh edited through other bindings; MeshLab itself compacts
        # after each filter.
        mesh.compact()
        return np.ascontiguousarray(getattr(mesh, method)(), dtype=dtype)


def check_taken(mesh: Any, now: NDArray[Any], wanted: NDArray[Any], what: str) -> None:
    """Raise `MeshError` if MeshLab has not made an array of a mesh exactly the wanted one."""
    if not np.array_equal(now, wanted, equal_nan=now.dtype.kind == "f"):
        raise MeshError(f"MeshLab did not take the {what} of {mesh.label()!r} exactly; please report this mesh")


def attributes_of(mesh: Any, element: str) -> dict[str, NDArray[Any]]:
    """The colours, scalars and selection of vertices or faces, as far as there are any, as `MeshData` has them."""
    attributes: dict[str, NDArray[Any]] = {}
    if getattr(mesh, f"has_{element}_color")():
        attributes["colors"] = as_levels(read_array(mesh, f"{element}_colors"))
    if getattr(mesh, f"has_{element}_scalar")():
        attributes["scalars"] = read_array(mesh, f"{element}_scalars")
    if getattr(mesh, f"selected_{element}_number")():
        attributes["selection"] = read_array(mesh, f"{element}_selection")
    return attributes


def _empty_array(name: str) -> NDArray[Any]:
    """The same array of a mesh without elements."""
    columns = {"vertex_colors": (4,), "face_colors": (4,), "edges": (2,)}.get(name, (3,))
    flat = name.endswith(("selection", "scalars"))
    return np.empty((0,) if flat else (0, *columns), dtype=_ARRAYS[name][1])


class MeshLayer(Measures):
    """A pymeshlab mesh as a `Layer`.

    Arrays are read when first asked for and then kept, so a layer serves until the mesh changes.
    """

    vertices: Floats
    faces: Ints
    edges: Ints
    vertex_normals: Floats
    face_normals: Floats
    vertex_selection: Bools
    face_selection: Bools
    vertex_scalars: Floats
    face_scalars: Floats
    vertex_colors: Floats
    face_colors: Floats
    has_vertex_scalars, has_vertex_colors, has_face_scalars, has_face_colors = Has(), Has(), Has(), Has()

    def __init__(self, mesh: Any, bench: Workbench) -> None:
        """See the class; None reads as an empty mesh."""
        self._mesh, self._bench, self.other = mesh, bench, bench.other

    def __getattr__(self, name: str) -> Any:
        """Read an array; it is an attribute of the layer from then on."""
        if name not in _ARRAYS:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        if self._mesh is None:
            array = _empty_array(name)
        elif name in ("face_scalars", "face_colors") and not self.has(name):
            raise MeshError(f"the mesh {self.label!r} has no {name.replace('_', ' ')}")
        elif name == "face_normals":
            with self._bench.matrix_aside(self._mesh):
                array = read_array(self._mesh, name)
        else:
            array = read_array(self._mesh, name)
        array.flags.writeable = False
        setattr(self, name, array)
        return array

    @property
    def label(self) -> str:
        return "" if self._mesh is None else str(self._mesh.label())

    @property
    def has_wedge_tex_coords(self) -> bool:
        return self._mesh is not None and bool(self._mesh.has_wedge_tex_coord())

    def has(self, name: str) -> bool:
        """Whether the mesh has an array, such as ``"vertex_scalars"``."""
        return self._mesh is not None and bool(getattr(self._mesh, f"has_{name[:-1]}")())


class Workbench:
    """Reads the layers of a mesh set, and applies MeshLab's filters outside its script and without output on the screen.

    It calls the methods of `pymeshlab.MeshSet` itself, never those of a subclass.

    Attributes:
        meshset: the mesh set; any `pymeshlab.MeshSet` serves.
        helper_ids: ids that MeshLab has given to helper layers, ascending. MeshLab never gives an id twice, so every helper layer
            leaves a gap behind.
        verbose: whether the mesh set reports its own filters on the screen; those applied here are silent.
        prints_parameters: the same for their parameters alone.
    """

    def __init__(self, meshset: Any, *, verbose: bool = False) -> None:
        self.meshset = meshset
        self.helper_ids: list[int] = []
        self.verbose = verbose
        self.prints_parameters = False

    def has_current(self) -> bool:
        """Whether the mesh set has a current layer."""
        try:
            BASE.current_mesh_id(self.meshset)
        except pymeshlab.PyMeshLabException:
            return False
        return True

    def current(self) -> MeshLayer:
        """The current layer as it is now; an empty one if there is none."""
        return MeshLayer(BASE.current_mesh(self.meshset) if self.has_current() else None, self)

    def other(self, mesh_id: int) -> Layer:
        """The layer of that id; raise `UnknownLayerError` if there is none."""
        self.check(mesh_id)
        return MeshLayer(BASE.mesh(self.meshset, mesh_id), self)

    def check(self, mesh_id: int, where: str = "") -> None:
        """Raise `UnknownLayerError`, its message beginning with `where`, if there is no layer of that id."""
        if mesh_id >= 0 and BASE.mesh_id_exists(self.meshset, mesh_id):
            return
        there = ", ".join(f"{m.id()} {m.label()!r}" for m in BASE.__iter__(self.meshset)) or "none"
        gaps = "; ids skip numbers, see current_mesh_id() after a layer is made" if self.helper_ids else ""
        raise UnknownLayerError(f"{where}there is no layer {mesh_id} in the mesh set (it has {there}{gaps})")

    def apply(self, filter_name: str, /, **parameters: Any) -> dict[str, Any]:
        """Apply a filter of MeshLab to the current layer; its report."""
        with MESHLAB:
            BASE.set_verbosity(self.meshset, False)
            BASE.set_parameter_verbosity(self.meshset, False)
            try:
                return apply_filter(self.meshset, filter_name, parameters, verbose=False)
            finally:
                BASE.set_verbosity(self.meshset, self.verbose)
                BASE.set_parameter_verbosity(self.meshset, self.prints_parameters)

    @contextmanager
    def helper_layer(self, mesh: Any) -> Iterator[int]:
        """Another layer for as long as the context lasts; gives its id. The current layer stays the current one."""
        current = BASE.current_mesh_id(self.meshset)
        BASE.add_mesh(self.meshset, mesh, "", False)
        helper: int = [m.id() for m in BASE.__iter__(self.meshset)][-1]
        self.helper_ids.append(helper)
        try:
            yield helper
        finally:
            BASE.set_current_mesh(self.meshset, helper)
            self.apply("delete_current_mesh")
            BASE.set_current_mesh(self.meshset, current)

    def move_to(self, mesh: Any, places: NDArray[np.float64]) -> None:
        """Move the vertices of the current layer, a mesh with faces, to (n, 3) places; raise `MeshError` unless exactly there."""
        with self.helper_layer(pymeshlab.Mesh(vertex_matrix=places)) as target:
            for _ in range(_MOST_MORPHS):
                self.apply("compute_coord_linear_morphing", targetmesh=target, percentmorph=100)
                if np.array_equal(read_array(mesh, "vertices"), places):
                    return
        check_taken(mesh, read_array(mesh, "vertices"), places, "new vertices")

    @contextmanager
    def matrix_aside(self, mesh: Any) -> Iterator[None]:
        """A layer without its matrix for as long as the context lasts.

        pymeshlab's face_normal_matrix() applies the matrix, scaled by the cube root of its determinant; of a mirrored layer it
        gives NaN. Everything else it gives is free of the matrix.
        """
        matrix = mesh.transform_matrix()
        self.set_matrix(mesh, np.eye(4))
        try:
            yield
        finally:
            self.set_matrix(mesh, matrix)

    def set_matrix(self, mesh: Any, matrix: NDArray[np.float64]) -> None:
        """Give a layer a matrix, unless it has it."""
        if np.array_equal(mesh.transform_matrix(), matrix):
            return
        current = BASE.current_mesh_id(self.meshset)
        BASE.set_current_mesh(self.meshset, mesh.id())
        self.apply("set_matrix", transformmatrix=matrix, compose=False, freeze=False)
        BASE.set_current_mesh(self.meshset, current)

    def without_helpers(self, mesh_id: int) -> int:
        """The id that a layer would have without helper layers: the one for scripts."""
        return mesh_id - sum(helper < mesh_id for helper in self.helper_ids)

    def with_helpers(self, mesh_id: int) -> int:
        """The layer's id in this mesh set, from the one in a script; undoes `without_helpers`."""
        for helper in self.helper_ids:
            if helper <= mesh_id:
                mesh_id += 1
        return mesh_id

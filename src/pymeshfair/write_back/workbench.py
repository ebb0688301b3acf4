"""A pymeshlab mesh as the `Layer` that a filter reads, and MeshLab's filters applied silently, outside the filter script."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..errors import MeshError
from ..mesh_data import MeshData, View, as_levels
from ..mesh_data.mesh_data import ReadWhenAsked
from ..meshlab.base import BASE, MESHLAB, UnknownLayerError, apply_filter

#: A morph is s + (t - s) in floating point; from what the first leaves over, the second reaches t exactly.
_MOST_MORPHS = 3
_KINDS = {"selection": "selection_array", "scalars": "scalar_array", "colors": "color_matrix", "normals": "normal_matrix"}
#: by the names of `Layer`, pymeshlab's method that gives an array
_ARRAYS = {
    **{"vertices": "vertex_matrix", "faces": "face_matrix", "edges": "edge_matrix"},
    **{f"{element}_{kind}": f"{element}_{method}" for kind, method in _KINDS.items() for element in ("vertex", "face")},
}
#: What an `Edit` can change without adding or removing elements; a layer has attributes of the same names.
EDITABLE = tuple(name for name in _ARRAYS if name not in ("faces", "edges"))


def read_array(mesh: Any, name: str) -> NDArray[Any]:
    """One of the arrays of `Layer`, copied from the mesh, C-contiguous (pymeshlab's own are column by column).

    Face normals are right only while the mesh has no matrix; see `Workbench.matrix_aside`.
    """
    try:
        return np.ascontiguousarray(getattr(mesh, _ARRAYS[name])())
    except pymeshlab.MissingCompactnessException:
        # Deleted elements still have their places, as in a mesh edited through other bindings; MeshLab itself compacts
        # after each filter.
        mesh.compact()
        return np.ascontiguousarray(getattr(mesh, _ARRAYS[name])())


def check_taken(mesh: Any, now: NDArray[Any], wanted: NDArray[Any], what: str) -> None:
    """Raise `MeshError` if MeshLab has not made an array of a mesh exactly the wanted one."""
    if not np.array_equal(now, wanted, equal_nan=now.dtype.kind == "f"):
        raise MeshError(f"MeshLab did not take the {what} of {mesh.label()!r} exactly; please report this mesh")


def attributes_of(mesh: Any, element: str) -> dict[str, NDArray[Any]]:
    """The colours, scalars and selection of vertices or faces, as far as there are any, as `MeshData` has them."""
    return {name: read() for name, read in _readers(mesh, element).items()}


def _readers(mesh: Any, element: str) -> dict[str, Callable[[], NDArray[Any]]]:
    readers: dict[str, Callable[[], NDArray[Any]]] = {}
    if getattr(mesh, f"has_{element}_color")():
        readers["colors"] = lambda: as_levels(read_array(mesh, f"{element}_colors"))
    if getattr(mesh, f"has_{element}_scalar")():
        readers["scalars"] = partial(read_array, mesh, f"{element}_scalars")
    if getattr(mesh, f"selected_{element}_number")():
        readers["selection"] = partial(read_array, mesh, f"{element}_selection")
    return readers


def wedges_of(mesh: Any) -> Any:
    """(m, 3, 2) the texture coordinates of the corners of faces, None if there are none."""
    return mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2) if mesh.has_wedge_tex_coord() else None


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

    def current(self) -> View:
        """The current layer as it is now; an empty one if there is none."""
        has_none = MeshData(vertices=np.empty((0, 3)))
        return View(self._read(BASE.current_mesh(self.meshset)) if self.has_current() else has_none, self._find)

    def _find(self, mesh_id: int) -> MeshData:
        self.check(mesh_id)
        return self._read(BASE.mesh(self.meshset, mesh_id))

    def _read(self, mesh: Any) -> MeshData:
        """A layer whose attributes are read when they are first asked for, so that it serves until the mesh changes."""
        vertex, face = _readers(mesh, "vertex"), _readers(mesh, "face")

        def face_normals() -> NDArray[Any]:
            with self.matrix_aside(mesh):
                return read_array(mesh, "face_normals")

        vertex["normals"], face["normals"] = partial(read_array, mesh, "vertex_normals"), face_normals
        if mesh.has_wedge_tex_coord():
            face["wedge_texture_coordinates"] = partial(wedges_of, mesh)
        return MeshData(
            vertices=read_array(mesh, "vertices"),
            faces=read_array(mesh, "faces"),
            edges=read_array(mesh, "edges"),
            vertex_attributes=ReadWhenAsked(vertex),
            face_attributes=ReadWhenAsked(face),
            label=mesh.label(),
        )

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

"""Reads a pymeshlab mesh as the `Layer` of a filter, and applies MeshLab's filters silently, outside the filter script."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import KW_ONLY, dataclass, field
from functools import partial
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..errors import MeshError
from ..mesh_data import MeshData, View, as_levels
from ..mesh_data.mesh_data import LazyAttributes
from ..meshlab.base import BASE, MESHLAB, UnknownLayerError, apply_filter

#: The most morphs for one move. A morph from s to t computes s + (t - s); further morphs correct the rounding error.
_MOST_MORPHS = 3
_KINDS = {"selection": "selection_array", "scalars": "scalar_array", "colors": "color_matrix", "normals": "normal_matrix"}
#: for each array of `Layer`, the method of pymeshlab that returns it
_ARRAYS = {
    **{"vertices": "vertex_matrix", "faces": "face_matrix", "edges": "edge_matrix"},
    **{f"{element}_{kind}": f"{element}_{method}" for kind, method in _KINDS.items() for element in ("vertex", "face")},
}
#: The arrays that an `Edit` can change without adding or removing elements; a layer has attributes of the same names.
EDITABLE = tuple(name for name in _ARRAYS if name not in ("faces", "edges"))


def read_array(mesh: Any, name: str) -> NDArray[Any]:
    """Returns a C-contiguous copy of an array of `Layer` (pymeshlab's arrays are column-major).

    Face normals are right only while the mesh has no transformation matrix; see `Workbench.matrix_aside`.
    """
    if not mesh.is_compact():  # deleted elements leave gaps, which MeshLab closes only at the end of its filters
        mesh.compact()
    array = np.ascontiguousarray(getattr(mesh, _ARRAYS[name])())
    return array[(array >= 0).all(axis=1)] if name == "edges" else array  # MeshLab keeps edges of deleted vertices, with -1


def check_taken(mesh: Any, now: NDArray[Any], wanted: NDArray[Any], what: str) -> None:
    """Raises `MeshError` unless MeshLab has stored an array of a mesh exactly."""
    if not np.array_equal(now, wanted, equal_nan=now.dtype.kind == "f"):
        raise MeshError(f"MeshLab did not take the {what} of {mesh.label()!r} exactly; please report this mesh")


def attributes_of(mesh: Any, element: str) -> dict[str, NDArray[Any]]:
    """Returns colours, scalars and selection of vertices or faces where present, in the form of `MeshData`."""
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
    """Returns (m, 3, 2) the texture coordinates of the corners of faces, None if there are none."""
    return mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2) if mesh.has_wedge_tex_coord() else None


@dataclass(eq=False)
class Workbench:
    """Reads the layers of a mesh set, and applies MeshLab's filters.

    It calls only methods of the class `pymeshlab.MeshSet`, even if a subclass overrides them.
    """

    meshset: Any  # any `pymeshlab.MeshSet` serves
    _: KW_ONLY
    verbose: bool = False  # whether the mesh set reports its filters on the screen; filters applied by `apply` are always silent
    prints_parameters: bool = field(default=False, init=False)  # whether the mesh set reports the parameters of its filters, too
    #: ascending ids of helper layers, also of removed ones; MeshLab never uses an id twice, so ids have gaps
    helper_ids: list[int] = field(default_factory=list, init=False)

    def has_current(self) -> bool:
        with suppress(pymeshlab.PyMeshLabException):  # raised if no layer is current, even if there are layers
            return bool(BASE.current_mesh_id(self.meshset) >= 0)
        return False

    def current(self) -> View:
        """Returns the current layer as it is now, or an empty one if there is none."""
        empty = MeshData(vertices=np.empty((0, 3)))
        return View(self._read(BASE.current_mesh(self.meshset)) if self.has_current() else empty, self._find)

    def _find(self, mesh_id: int) -> MeshData:
        self.check(mesh_id)
        return self._read(BASE.mesh(self.meshset, mesh_id))

    def _read(self, mesh: Any) -> MeshData:
        """Returns a layer that reads its attributes at the first access; valid until the mesh changes."""
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
            vertex_attributes=LazyAttributes(vertex),
            face_attributes=LazyAttributes(face),
            matrix=np.array(mesh.transform_matrix()),
            label=mesh.label(),
        )

    def check(self, mesh_id: int, where: str = "") -> None:
        """Raises `UnknownLayerError` if no layer has that id; the message begins with `where`."""
        if mesh_id >= 0 and BASE.mesh_id_exists(self.meshset, mesh_id):
            return
        layers = ", ".join(f"{m.id()} {m.label()!r}" for m in BASE.__iter__(self.meshset)) or "none"
        gaps = "; ids have gaps: current_mesh_id() gives the id of a new layer" if self.helper_ids else ""
        raise UnknownLayerError(f"{where}there is no layer {mesh_id} in the mesh set (it has {layers}{gaps})")

    def apply(self, filter_name: str, /, **parameters: Any) -> dict[str, Any]:
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
        """Adds a layer while the context is open; yields its id. The current layer stays current."""
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
        """Moves the vertices of the current layer, which must have faces, exactly to (n, 3) places, or raises `MeshError`."""
        with self.helper_layer(pymeshlab.Mesh(vertex_matrix=places)) as target:
            for _ in range(_MOST_MORPHS):
                self.apply("compute_coord_linear_morphing", targetmesh=target, percentmorph=100)
                if np.array_equal(read_array(mesh, "vertices"), places):
                    return
        check_taken(mesh, read_array(mesh, "vertices"), places, "new vertices")

    @contextmanager
    def matrix_aside(self, mesh: Any) -> Iterator[NDArray[np.float64]]:
        """Removes the transformation matrix of a layer while the context is open; yields the matrix.

        The matrix changes pymeshlab's face normals, which are NaN for a mirrored layer. It changes no other array.
        """
        matrix = mesh.transform_matrix()
        try:
            self.set_matrix(mesh, np.eye(4))
            yield matrix
        finally:
            self.set_matrix(mesh, matrix)

    def set_matrix(self, mesh: Any, matrix: NDArray[np.float64]) -> None:
        """Sets the transformation matrix of a layer, unless the layer has this matrix already."""
        if np.array_equal(mesh.transform_matrix(), matrix):
            return
        current = BASE.current_mesh_id(self.meshset)
        BASE.set_current_mesh(self.meshset, mesh.id())
        self.apply("set_matrix", transformmatrix=matrix, compose=False, freeze=False)
        BASE.set_current_mesh(self.meshset, current)

    def without_helpers(self, mesh_id: int) -> int:
        """Converts the id of a layer to its id in scripts, which have no helper layers."""
        return mesh_id - sum(helper < mesh_id for helper in self.helper_ids)

    def with_helpers(self, mesh_id: int) -> int:
        """Converts the id of a layer in a script to its id in this mesh set; inverse of `without_helpers`."""
        for helper in self.helper_ids:
            if helper <= mesh_id:
                mesh_id += 1
        return mesh_id

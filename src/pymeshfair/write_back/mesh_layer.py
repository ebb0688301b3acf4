"""A pymeshlab mesh as the `Layer` that filters are given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, Edit, Floats, Ints, Layer
from ..errors import MeshError
from ..mesh_data.mesh_data import Has, Measures
from .workbench import EDITABLE, Workbench, empty_array, read_array

_T = TypeVar("_T")


class _Array(Generic[_T]):
    """An array of a layer, under its own name."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, layer: MeshLayer, owner: type) -> _T:
        return cast("_T", layer._array(self._name))


class MeshLayer(Measures):
    """A pymeshlab mesh as the `Layer` that a filter reads, with edits that MeshLab has not been told yet.

    Arrays are read when first asked for and then kept, so a layer serves until the mesh changes otherwise.
    """

    vertices, faces, edges = _Array[Floats](), _Array[Ints](), _Array[Ints]()
    vertex_normals, face_normals = _Array[Floats](), _Array[Floats]()
    vertex_selection, face_selection = _Array[Bools](), _Array[Bools]()
    vertex_scalars, face_scalars = _Array[Floats](), _Array[Floats]()
    vertex_colors, face_colors = _Array[Floats](), _Array[Floats]()
    has_vertex_scalars, has_vertex_colors, has_face_scalars, has_face_colors = Has(), Has(), Has(), Has()

    def __init__(
        self,
        mesh: Any,
        bench: Workbench,
        *,
        other: Callable[[int], Layer],
        settle: Callable[[], None],
        edit: Edit | None = None,
    ) -> None:
        """See the class; None reads as an empty mesh, and `settle` writes the edits that MeshLab must derive something from."""
        self._mesh = mesh
        self._bench = bench
        self._other = other
        self._settle = settle
        self.pending = edit or Edit()
        self._arrays: dict[str, NDArray[Any]] = {}

    @property
    def has_pending(self) -> bool:
        """Whether there are changes that MeshLab has not been told of yet."""
        return any(getattr(self.pending, name) is not None for name in EDITABLE)

    def edited(self, edit: Edit) -> MeshLayer:
        """The layer as it is after an edit that adds and removes no elements; shares the arrays that stay."""
        changed = {name: value for name in EDITABLE if (value := getattr(edit, name)) is not None}
        before = {name: value for name in EDITABLE if (value := getattr(self.pending, name)) is not None}
        if "vertices" in changed and len(self.faces):
            # Normals follow from coordinates; those of an earlier edit belong to the earlier surface.
            before.pop("vertex_normals", None)
            before.pop("face_normals", None)
        after = MeshLayer(self._mesh, self._bench, other=self._other, settle=self._settle, edit=Edit(**{**before, **changed}))
        kept = set(self._arrays) - set(changed)
        if "vertices" in changed:
            kept -= {"vertex_normals", "face_normals"} if len(self.faces) else set()
        elif "mean_edge" in vars(self):
            after.mean_edge = self.mean_edge
        after._arrays = {name: self._arrays[name] for name in kept}
        return after

    def _array(self, name: str) -> NDArray[Any]:
        if name not in self._arrays:
            value = getattr(self.pending, name, None)
            if value is None:
                value = self._read(name)
            view: NDArray[Any] = np.ascontiguousarray(value).view()
            view.flags.writeable = False
            self._arrays[name] = view
        return self._arrays[name]

    def _read(self, name: str) -> NDArray[Any]:
        if self._mesh is None:
            return empty_array(name)
        if name in ("face_scalars", "face_colors") and not getattr(self._mesh, f"has_{name[:-1]}")():
            raise MeshError(f"the mesh {self.label!r} has no {name.replace('_', ' ')}")
        if name.endswith("normals") and self.pending.vertices is not None and len(self.faces):
            self._settle()
        if name == "face_normals":
            with self._bench.matrix_aside(self._mesh):
                return read_array(self._mesh, name)
        return read_array(self._mesh, name)

    @property
    def label(self) -> str:
        return "" if self._mesh is None else str(self._mesh.label())

    @property
    def has_wedge_tex_coords(self) -> bool:
        return self._mesh is not None and bool(self._mesh.has_wedge_tex_coord())

    def has(self, name: str) -> bool:
        """Whether the mesh or the edits have an array, such as ``"vertex_scalars"``."""
        if getattr(self.pending, name) is not None:
            return True
        return self._mesh is not None and bool(getattr(self._mesh, f"has_{name[:-1]}")())

    def other(self, mesh_id: int) -> Layer:
        return self._other(mesh_id)

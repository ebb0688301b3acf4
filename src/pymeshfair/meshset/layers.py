"""The meshes of a pymeshlab mesh set as layers; results are written to MeshLab when something needs them."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import pymeshlab

from ..declaration import Edit, Filter, Layer
from ..mesh_data import adds, adds_or_removes
from ..meshlab.base import BASE
from ..meshlab.errors import UnknownLayerError
from ..write_back import MeshLayer, Workbench, write_edit


class Layers:
    """Reads and edits the layers of one mesh set.

    Attributes:
        meshset: the mesh set; any `pymeshlab.MeshSet` serves.
        bench: runs MeshLab's filters for the write-back.
    """

    def __init__(self, meshset: Any, *, verbose: bool = False) -> None:
        self.meshset = meshset
        self.bench = Workbench(meshset)
        self.bench.verbose = verbose
        self._deferring = False
        self._layer: MeshLayer | None = None

    @contextmanager
    def deferred(self) -> Iterator[None]:
        """Write results to MeshLab at the end of the context, or earlier when something of MeshLab's needs them."""
        outer, self._deferring = self._deferring, True
        try:
            yield
        finally:
            self._deferring = outer
            if not outer:
                self.settle()

    def settle(self) -> None:
        """Write to MeshLab what waits to be written."""
        layer, self._layer = self._layer, None
        if layer is not None and layer.has_pending:
            write_edit(self.bench, layer.pending)

    def forget(self) -> None:
        """Drop what was read of the current layer, because MeshLab is about to change it."""
        self._layer = None

    def clear(self) -> None:
        """Drop everything: the mesh set loses its layers."""
        self._layer = None
        self.bench.helper_ids.clear()

    def has_current(self) -> bool:
        """Whether the mesh set has a current layer."""
        try:
            BASE.current_mesh_id(self.meshset)
        except pymeshlab.PyMeshLabException:
            return False
        return True

    def current(self) -> MeshLayer:
        """The current layer, results that still wait included; an empty one if there is none."""
        if self._layer is not None:
            return self._layer
        layer = self._read(BASE.current_mesh(self.meshset) if self.has_current() else None)
        if self._deferring:
            self._layer = layer
        return layer

    def take(self, layer: MeshLayer, edit: Edit) -> tuple[str, ...]:
        """Make the current layer what the edit says, now or when something needs it.

        Returns:
            What could not be kept, in sentences.
        """
        if adds(edit):
            self.settle()
            return write_edit(self.bench, edit)
        after = layer.edited(edit)
        if self._deferring and not adds_or_removes(edit):
            self._layer = after
            return ()
        self._layer = None
        more = {name: getattr(edit, name) for name in ("delete_vertices", "delete_faces", "new_layers")}
        return write_edit(self.bench, replace(after.pending, **more))

    def check(self, mesh_id: int, where: str = "") -> None:
        """Raise `UnknownLayerError`, its message beginning with `where`, if there is no layer of that id."""
        if mesh_id >= 0 and BASE.mesh_id_exists(self.meshset, mesh_id):
            return
        there = ", ".join(f"{m.id()} {m.label()!r}" for m in BASE.__iter__(self.meshset)) or "none"
        gaps = "; ids skip numbers, see current_mesh_id() after a layer is made" if self.bench.helper_ids else ""
        raise UnknownLayerError(f"{where}there is no layer {mesh_id} in the mesh set (it has {there}{gaps})")

    def check_named(self, declared: Filter, values: dict[str, Any]) -> None:
        """Raise `UnknownLayerError` if a parameter of the filter names a layer that is not there."""
        for name, mesh_id in declared.layers(values).items():
            self.check(mesh_id, f"{declared.python_name}: parameter {name!r}: ")

    def _read(self, mesh: Any) -> MeshLayer:
        return MeshLayer(mesh, self.bench, other=self._other, settle=self.settle)

    def _other(self, mesh_id: int) -> Layer:
        self.check(mesh_id)
        if self.has_current() and mesh_id == BASE.current_mesh_id(self.meshset):
            return self.current()
        return self._read(BASE.mesh(self.meshset, mesh_id))

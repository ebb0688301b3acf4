"""A pymeshlab mesh set whose meshes are read as layers, and whose changes may wait until somebody needs them."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pymeshlab

from ..declaration import Edit, Layer
from ..write_back import MeshLayer, Workbench, after_failure, write_edit
from .errors import UnknownLayerError

_BASE = pymeshlab.MeshSet


class LayeredMeshSet(pymeshlab.MeshSet):  # type: ignore[misc]
    """The part of `MeshSet` that knows the meshes."""

    def __init__(self, verbose: bool = False) -> None:
        super().__init__(verbose)
        self._bench = Workbench(self)
        self._bench.verbose = verbose
        self._deferring = False
        self._layer: MeshLayer | None = None

    @contextmanager
    def deferred(self) -> Iterator[None]:
        """Put off telling MeshLab of results for as long as the context lasts, or until something of MeshLab's needs them.

        Telling takes longer than a fast filter. Filters of plugins see each other's results all the same, and so does everything
        that is asked of the mesh set; only a `pymeshlab.Mesh` that was fetched before stays behind until the end.
        """
        outer, self._deferring = self._deferring, True
        try:
            yield
        finally:
            self._deferring = outer
            if not outer:
                self._settle()

    def _settle(self) -> None:
        """Tell MeshLab what it has not been told yet."""
        layer, self._layer = self._layer, None
        if layer is not None and layer.pending != Edit():
            write_edit(self._bench, layer.pending)

    def _has_mesh(self) -> bool:
        try:
            _BASE.current_mesh_id(self)
        except pymeshlab.PyMeshLabException:
            return False
        return True

    def _current_layer(self) -> MeshLayer:
        if self._layer is not None:
            return self._layer
        layer = self._read_layer(_BASE.current_mesh(self) if self._has_mesh() else None)
        if self._deferring:
            self._layer = layer
        return layer

    def _read_layer(self, mesh: Any) -> MeshLayer:
        return MeshLayer(mesh, self._bench, other=self._other_layer, settle=self._settle)

    def _other_layer(self, mesh_id: int) -> Layer:
        self._check_layer(mesh_id)
        if self._has_mesh() and mesh_id == _BASE.current_mesh_id(self):
            return self._current_layer()
        return self._read_layer(_BASE.mesh(self, mesh_id))

    def _check_layer(self, mesh_id: int, where: str = "") -> None:
        if mesh_id >= 0 and _BASE.mesh_id_exists(self, mesh_id):
            return
        there = ", ".join(f"{m.id()} {m.label()!r}" for m in _BASE.__iter__(self)) or "none"
        gaps = "; ids skip numbers, see current_mesh_id() after a layer is made" if self._bench.helper_ids else ""
        raise UnknownLayerError(f"{where}there is no layer {mesh_id} in the mesh set (it has {there}{gaps})")

    def set_current_mesh(self, new_curr_id: int) -> None:
        """Make the layer of that id the current one.

        Raises:
            UnknownLayerError: there is none; pymeshlab would go on without a current mesh.
        """
        self._settle()
        self._check_layer(new_curr_id)
        super().set_current_mesh(new_curr_id)

    def clear(self) -> None:
        """Remove all layers; the filter script stays."""
        self._layer = None
        self._bench.helper_ids.clear()
        super().clear()

    def set_verbosity(self, verbosity: bool) -> None:
        """Whether filters tell on the screen what they do."""
        super().set_verbosity(verbosity)
        self._bench.verbose = verbosity

    def set_parameter_verbosity(self, verbosity: bool) -> None:
        """Whether the parameters of filters are printed."""
        super().set_parameter_verbosity(verbosity)
        self._bench.tells_parameters = verbosity


def _settling(name: str) -> Callable[..., Any]:
    """Pymeshlab's method of that name, after MeshLab has been told everything."""
    original = getattr(_BASE, name)

    @functools.wraps(original)
    def method(self: LayeredMeshSet, *args: Any, **kwargs: Any) -> Any:
        self._settle()
        try:
            return original(self, *args, **kwargs)
        except Exception:
            if self._bench.verbose:
                after_failure(self, verbose=True)
            raise

    return method


for _name in (
    "__getitem__",
    "__iter__",
    "add_mesh",
    "current_mesh",
    "load_new_mesh",
    "load_new_raster",
    "load_project",
    "mesh",
    "save_current_mesh",
    "save_project",
):
    setattr(LayeredMeshSet, _name, _settling(_name))

"""`MeshSet`: pymeshlab's mesh set with the filters of plugins beside MeshLab's own."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pymeshlab

from ..filters.libraries import ImportedWhenUsed
from ..meshlab.base import BASE, MESHLAB, after_failure
from .filter_methods import FilterMethods, LateMethods

if TYPE_CHECKING:
    from .. import recipe, write_back
    from ..scripts.script import Script, Step
    from . import exchange, filter_runner, methods
    from .pymeshlab_classes import _MeshSet as _Typed
else:  # importing them takes longer than importing pymeshlab
    _Typed = BASE
    recipe, write_back = ImportedWhenUsed("pymeshfair.recipe"), ImportedWhenUsed("pymeshfair.write_back")
    exchange, filter_runner, methods = (
        ImportedWhenUsed(f"pymeshfair.meshset.{name}") for name in ("exchange", "filter_runner", "methods")
    )


class _MeshSetType(LateMethods, type(BASE)):  # type: ignore[misc]
    """Both its own type and that of pymeshlab's class."""


class MeshSet(FilterMethods, _Typed, metaclass=_MeshSetType):
    """A set of meshes that filters are applied to, a drop-in for `pymeshlab.MeshSet`.

    Filters of plugins, pymeshfair's own among them, behave as MeshLab's do: each is a method, a name for `apply_filter`, and a
    step of filter scripts. They change the current mesh in place and keep everything else of it; a `pymeshlab.Mesh` fetched
    before shows the new state.

    A filter that moves the vertices of a mesh with faces uses up one of MeshLab's ids, and one that adds elements two, so those
    of layers made later skip numbers. Scripts do not count them.

    Attributes:
        on_progress: called with the share of the work that is done, from 0 to 1, while a plugin's filter works; it may raise to
            stop it.
        on_note: called with each sentence that a filter wants to be read; None sends them to the logger ``pymeshfair``.
    """

    on_progress: Callable[[float], None] | None = None
    on_note: Callable[[str], None] | None = None

    @staticmethod
    def filter_list() -> list[str]:
        """The Python names of all filters, MeshLab's and the plugins', sorted."""
        return methods.filter_list()

    def __init__(self, verbose: bool = False) -> None:
        BASE.__init__(self, verbose)
        self._bench = write_back.Workbench(self, verbose=verbose)
        self._filters = filter_runner.FilterRunner(self._bench)
        self._script = filter_runner.ScriptLog.of(None)

    def apply_filter(self, filter_name: str, **kwargs: Any) -> dict[str, Any]:
        """Apply a filter, MeshLab's or a plugin's, to the current mesh and add it to the filter script.

        Args:
            filter_name: its Python name, or its name in MeshLab's menus.
            **kwargs: parameters by Python name; the others take their defaults. Lengths are ``"1%"`` of the bounding box's
                diagonal, ``"0.5edge"`` mean edges, ``"0.3"`` mesh units, `pymeshlab.PercentageValue` or `pymeshlab.PureValue`.

        Returns:
            What the filter reports, by name.

        Raises:
            UnknownFilterError: no such filter or parameter; the message gives the nearest name.
            FilterParameterError: a value that the filter does not take.
            UnknownLayerError: the id of a layer that is not there.
            FilterFailedError: a plugin's filter could not do its work; the mesh is as it was.
            pymeshlab.PyMeshLabException: base of all these, and MeshLab's word for every failure of its own filters.
        """
        result, step = self._filters.apply(filter_name, kwargs)
        if step is not None:
            self._script.steps.append(step)
        return result

    def apply_step(self, step: Step) -> dict[str, Any]:
        """Apply a step of a script to the current mesh; it is not added to the filter script.

        Ids of layers in the step do not count the layers that pymeshfair itself made and removed on the way, so that a script
        means the same whenever it is applied.

        Raises:
            pymeshlab.PyMeshLabException: as `apply_filter`.
        """
        return self._filters.apply_step(step)[0]

    def filter_parameter_values(self, filter_name: str, /, **kwargs: Any) -> dict[str, Any]:
        """The values that a filter would run with on the current mesh, lengths in mesh units; `kwargs` are some of them.

        For an extension, those of saving such a file.
        """
        return self._filters.values(filter_name, kwargs)

    def load_filter_script(self, filter_script_name: str) -> None:
        """Read a filter script from an .mlx file in place of the current one.

        Raises:
            ScriptError: something in the script is wrong; lists every problem. The current script stays.
        """
        self._script = filter_runner.ScriptLog.of(filter_script_name)

    def apply_filter_script(self) -> None:
        """Apply the current filter script: the filters that were loaded, and those applied since.

        Raises:
            ScriptStepFailedError: a step failed; the message names it with file and line. The mesh is as the last complete step
                left it.
        """
        self._script.apply(self.apply_step)

    def save_filter_script(self, filter_script_name: str) -> None:
        """Write the current filter script to an .mlx file, every parameter with the value that it had.

        Raises:
            PymeshfairError: the file cannot be written.
        """
        self._script.save(filter_script_name, self._bench.current())

    def clear_filter_script(self) -> None:
        """Forget the current filter script."""
        self._script = filter_runner.ScriptLog.of(None)

    def print_filter_script(self) -> None:
        """Print the current filter script: each filter with the values of its parameters."""
        self._script.print()

    def apply_recipe(self, name_or_path: str | os.PathLike[str], **settings: object) -> list[dict[str, Any]]:
        """Apply a recipe to the current mesh, and add its steps to the filter script; what each of them reports.

        Limits of the recipe are not looked at: `pymeshfair.run` does that.

        Args:
            name_or_path: a shipped recipe, or the path of an .mlx script.
            **settings: values over the recipe's own, by the names of its settings.

        Raises:
            UnknownNameError: there is no such recipe or setting.
            ScriptError: something in the script is wrong; lists every problem.
            ScriptStepFailedError: a step failed; the mesh is as the last complete step left it.
        """
        loaded = recipe.load_recipe(name_or_path).override([f"{name}={value}" for name, value in settings.items()])
        return self.apply_script(loaded.script)

    def apply_script(self, script: Script) -> list[dict[str, Any]]:
        """Apply all steps of a script to the current mesh, and add them to the filter script; what each of them reports.

        Raises:
            ScriptStepFailedError: a step failed; the mesh and the filter script are as the last complete step left them.
        """
        results: list[dict[str, Any]] = []

        def apply(step: Step) -> None:
            result, done = self._filters.apply_step(step)
            results.append(result)
            self._script.steps.append(done)

        filter_runner.ScriptLog(script).apply(apply)
        return results

    def set_current_mesh(self, new_curr_id: int) -> None:
        """Make the layer of that id the current one.

        Raises:
            UnknownLayerError: there is none; pymeshlab would go on without a current mesh.
        """
        self._bench.check(new_curr_id)
        BASE.set_current_mesh(self, new_curr_id)

    def add_mesh(self, mesh: Any, mesh_name: str = "", set_as_current: bool = True) -> Any:
        """Add a mesh as a layer: pymeshlab's, or one of trimesh, Open3D or PyVista; see `to_trimesh` for the way back.

        What MeshLab does not take of another package's mesh is named by a warning of the logger ``pymeshfair``.

        Raises:
            ForeignMeshError: it is no mesh of these packages.
        """
        if isinstance(mesh, pymeshlab.Mesh):
            return _locked(self, BASE.add_mesh, mesh, mesh_name, set_as_current)
        arrays = exchange.taken(mesh)
        result = _locked(self, BASE.add_mesh, exchange.as_meshlab(arrays), mesh_name, set_as_current)
        exchange.add_values(max(BASE.__iter__(self), key=lambda layer: int(layer.id())), arrays)
        self._filters.note(arrays.lost)
        return result

    def to_trimesh(self) -> Any:
        """The current mesh as a `trimesh.Trimesh`, without faces as a `Path3D` or a `PointCloud`, with colours and values.

        What trimesh does not take is named by a warning of the logger ``pymeshfair``; so by the next two.
        """
        return self._given(exchange.to_trimesh)

    def to_open3d(self) -> Any:
        """The current mesh as an `open3d.geometry.TriangleMesh`, or a `PointCloud`, with vertex normals and colours."""
        return self._given(exchange.to_open3d)

    def to_pyvista(self) -> Any:
        """The current mesh as a `pyvista.PolyData` with normals, colours, texture coordinates and values of points and cells."""
        return self._given(exchange.to_pyvista)

    def _given(self, make: Callable[[exchange.Arrays], Any]) -> Any:
        arrays = exchange.of_meshlab(self.current_mesh(), self._bench)
        made = make(arrays)
        self._filters.note(arrays.lost)
        return made

    def save_current_mesh(self, file_name: str, *args: Any, **kwargs: Any) -> None:
        """Save the current mesh as pymeshlab does; a note says so if it has edges that are not in the file.

        MeshLab writes edges into .obj files alone. A run writes them into .ply files, too.
        """
        _locked(self, BASE.save_current_mesh, file_name, *args, **kwargs)
        edges = self.current_mesh().edge_number()
        if edges and not str(file_name).lower().endswith(".obj"):
            text = f"MeshLab does not write the {edges:,} edges of the mesh into {str(file_name)!r}; into an .obj file it does"
            self._filters.note([text])

    def clear(self) -> None:
        """Remove all layers; the filter script stays."""
        self._bench.helper_ids.clear()
        BASE.clear(self)

    def set_verbosity(self, verbosity: bool) -> None:
        """Whether filters report on the screen."""
        BASE.set_verbosity(self, verbosity)
        self._bench.verbose = verbosity

    def set_parameter_verbosity(self, verbosity: bool) -> None:
        """Whether the parameters of filters are printed."""
        BASE.set_parameter_verbosity(self, verbosity)
        self._bench.prints_parameters = verbosity

    def __repr__(self) -> str:
        """The layers, one a line with its number, name and size; the number of the current one ends with ``*``."""
        current = self.current_mesh_id() if self.mesh_number() else -1
        lines = []
        for mesh in self:
            counts = ((mesh.vertex_number(), "vertices"), (mesh.face_number(), "faces"), (mesh.edge_number(), "edges"))
            size = ", ".join(f"{count:,} {what}" for count, what in counts if count or what == "vertices")
            number = f"{mesh.id()}{'*' if mesh.id() == current else ''}"
            lines.append(f"  {number:<4} {mesh.label()}: {size}")
        return "\n".join([f"MeshSet of {len(lines)} {'layer' if len(lines) == 1 else 'layers'}", *lines])

    __str__ = __repr__  # pymeshlab's own gives None


def _locked(meshes: MeshSet, original: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    """Call a method of pymeshlab's that reads or writes files or makes layers, one thread at a time."""
    with MESHLAB:
        try:
            return original(meshes, *args, **kwargs)
        except Exception:
            if meshes._bench.verbose:
                after_failure(meshes, verbose=True)
            raise


def _locking(name: str) -> Callable[..., Any]:
    """Pymeshlab's method of that name, under the lock."""
    original = getattr(BASE, name)

    @functools.wraps(original)
    def method(self: MeshSet, *args: Any, **kwargs: Any) -> Any:
        return _locked(self, original, *args, **kwargs)

    return method


for _name in ("load_new_mesh", "load_new_raster", "load_project", "save_project"):
    setattr(MeshSet, _name, _locking(_name))

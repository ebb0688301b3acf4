"""`MeshSet`: the mesh set of pymeshlab, with the filters of MeshLab and of plugins."""

from __future__ import annotations

import functools
import locale
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
else:  # these imports take longer than the import of pymeshlab
    _Typed = BASE
    recipe, write_back = ImportedWhenUsed("pymeshfair.recipe"), ImportedWhenUsed("pymeshfair.write_back")
    exchange, filter_runner, methods = (
        ImportedWhenUsed(f"pymeshfair.meshset.{name}") for name in ("exchange", "filter_runner", "methods")
    )


class _MeshSetType(LateMethods, type(BASE)):  # type: ignore[misc]
    """Joins the metaclasses of `FilterMethods` and of pymeshlab's class."""


class MeshSet(FilterMethods, _Typed, metaclass=_MeshSetType):
    """A set of meshes that filters are applied to, a drop-in replacement for `pymeshlab.MeshSet`.

    Filters of plugins, also those of pymeshfair, behave like those of MeshLab: each is a method, a name for `apply_filter`, and
    a step of filter scripts. They change the current mesh in place and keep all its other data. A `pymeshlab.Mesh` that was
    fetched before shows the new state.

    Filters of plugins use up layer ids of MeshLab for helper layers, so that the ids of later layers skip numbers. Scripts
    number the layers without these gaps.

    Attributes:
        on_progress: called with the share of work done, from 0 to 1, while a plugin's filter works; may raise to stop the filter.
        on_note: called with each sentence that a filter or a conversion has for the user; None: the logger ``pymeshfair``.
    """

    on_progress: Callable[[float], None] | None = None
    on_note: Callable[[str], None] | None = None

    @staticmethod
    def filter_list() -> list[str]:
        """Returns the Python names of all filters, of MeshLab and of plugins, sorted."""
        return methods.filter_list()

    def __init__(self, verbose: bool = False) -> None:
        BASE.__init__(self, verbose)
        self._bench = write_back.Workbench(self, verbose=verbose)
        self._filters = filter_runner.FilterRunner(self._bench)
        self._script = filter_runner.ScriptLog.of(None)

    def apply_filter(self, filter_name: str, **kwargs: Any) -> dict[str, Any]:
        """Applies a filter of MeshLab or a plugin, and adds it to the filter script; returns the values that it reports, by name.

        Args:
            filter_name: its Python name, or its name in MeshLab's menus.
            **kwargs: parameters by Python name; all others have their defaults. Lengths are ``"1%"`` of the bounding box's
                diagonal, ``"0.5edge"`` mean edges, ``"0.3"`` mesh units, `pymeshlab.PercentageValue` or `pymeshlab.PureValue`.

        Raises:
            UnknownFilterError: there is no such filter or parameter; the message suggests the nearest name.
            FilterParameterError: a value is not allowed.
            UnknownLayerError: no layer has the given id.
            FilterFailedError: no mesh, or a plugin's filter failed; the mesh is unchanged unless writing the result failed.
            pymeshlab.PyMeshLabException: the base class of these errors; MeshLab's own filters raise it for every failure.
        """
        result, step = self._filters.apply(filter_name, kwargs)
        if step is not None:
            self._script.steps.append(step)
        return result

    def apply_step(self, step: Step) -> dict[str, Any]:
        """Applies a step of a script like `apply_filter`, and does not add it to the filter script.

        The step numbers layers without the gaps that helper layers leave, so that a script has the same meaning at any time.
        """
        return self._filters.apply_step(step)[0]

    def filter_parameter_values(self, filter_name: str, /, **kwargs: Any) -> dict[str, Any]:
        """Returns the values of all parameters with which a filter would run on the current mesh; `kwargs` sets some of them.

        Lengths are in mesh units. If `filter_name` is a file extension, these are the parameters for saving such a file.
        """
        return self._filters.values(filter_name, kwargs)

    def load_filter_script(self, filter_script_name: str) -> None:
        """Replaces the current filter script by that of an .mlx file; `ScriptError` names the problems of the file."""
        self._script = filter_runner.ScriptLog.of(filter_script_name)

    def apply_filter_script(self) -> None:
        """Applies the current filter script: the steps that were loaded, and the filters applied since.

        Raises `ScriptStepFailedError`, which names step, file and line, if a step fails; the steps before it stay applied.
        """
        list(self._script.apply(self._filters.apply_step))

    def save_filter_script(self, filter_script_name: str) -> None:
        """Writes the current filter script to an .mlx file, with all values, or raises `PymeshfairError` if it cannot."""
        self._script.save(filter_script_name, self._bench.current)

    def clear_filter_script(self) -> None:
        """Empties the current filter script."""
        self._script = filter_runner.ScriptLog.of(None)

    def print_filter_script(self) -> None:
        """Prints the current filter script: each filter with the values of its parameters."""
        self._script.print()

    def apply_recipe(self, name_or_path: str | os.PathLike[str], **settings: object) -> list[dict[str, Any]]:
        """Applies a recipe to the current mesh, and adds its steps to the filter script; returns the report of each step.

        The arguments are a shipped recipe or the path of an .mlx script, and new values for its settings. A recipe's limits are
        not checked here, but by `pymeshfair.run`. Errors are those of `Recipe.load` and `apply_script`, and `ParameterError`.
        """
        loaded = recipe.load_recipe(name_or_path).override([f"{name}={value}" for name, value in settings.items()])
        return self.apply_script(loaded.script)

    def apply_script(self, script: Script) -> list[dict[str, Any]]:
        """Applies all steps of a script, adds them to the filter script, and returns their reports.

        Raises `ScriptStepFailedError` if a step fails; the steps before it stay applied, and stay in the filter script.
        """
        results: list[dict[str, Any]] = []
        for result, done in filter_runner.ScriptLog(script).apply(self._filters.apply_step):
            results.append(result)
            self._script.steps.append(done)
        return results

    def set_current_mesh(self, new_curr_id: int) -> None:
        """Makes the layer with this id current, or raises `UnknownLayerError`: pymeshlab would go on without a current mesh."""
        self._bench.check(new_curr_id)
        BASE.set_current_mesh(self, new_curr_id)

    def add_mesh(self, mesh: Any, mesh_name: str = "", set_as_current: bool = True) -> Any:
        """Adds a mesh of pymeshlab, trimesh, Open3D or PyVista as a layer; see `to_trimesh` for the way back.

        A note, see `on_note`, names contents that MeshLab does not take. Raises `ForeignMeshError` if `mesh` is no mesh of these
        packages, a scene with no parts or parts of several kinds, or has values for more or fewer vertices or faces than it has.
        """
        if isinstance(mesh, pymeshlab.Mesh):
            return _locked(self, BASE.add_mesh, mesh, mesh_name, set_as_current)
        arrays = exchange.arrays_of(mesh)
        values = exchange.custom_values(arrays)
        result = _locked(self, BASE.add_mesh, exchange.as_meshlab(arrays), mesh_name, set_as_current)
        layer = max(BASE.__iter__(self), key=lambda layer: int(layer.id()))
        for (element, name), numbers in values.items():  # not before `add_mesh`: the attributes would refer to freed memory
            getattr(layer, f"add_{element}_custom_scalar_attribute")(numbers, name)
        self._filters.note(arrays.lost)
        return result

    def to_trimesh(self) -> Any:
        """Returns the current mesh as a `trimesh.Trimesh` with its attributes; without faces as a `Path3D` or a `PointCloud`.

        A note, see `on_note`, names contents that trimesh does not take; `to_open3d` and `to_pyvista` send such notes, too.
        All three count vertices that are all white as uncoloured, and vertex scalars that are all 0 as none.
        """
        return self._exported(exchange.to_trimesh)

    def to_open3d(self) -> Any:
        """Returns the current mesh as an `open3d.geometry.TriangleMesh`, or a `PointCloud`, with vertex normals and colours."""
        return self._exported(exchange.to_open3d)

    def to_pyvista(self) -> Any:
        """Returns the current mesh as a `pyvista.PolyData` with normals, colours, texture coordinates and other attributes."""
        return self._exported(exchange.to_pyvista)

    def _exported(self, make: Callable[[exchange.Arrays], Any]) -> Any:
        arrays = exchange.of_meshlab(self.current_mesh(), self._bench)
        made = make(arrays)
        self._filters.note(arrays.lost)
        return made

    def save_current_mesh(self, file_name: str, *args: Any, **kwargs: Any) -> None:
        """Saves the current mesh as pymeshlab does; a note warns of edges, which MeshLab writes into .obj files alone."""
        _locked(self, BASE.save_current_mesh, file_name, *args, **kwargs)
        if (edges := self.current_mesh().edge_number()) and not str(file_name).lower().endswith(".obj"):
            lost = f"MeshLab does not write the {edges:,} edges of the mesh into {str(file_name)!r}; an .obj file keeps them"
            self._filters.note([lost])

    def clear(self) -> None:
        """Removes all layers; keeps the filter script."""
        self._bench.helper_ids.clear()
        BASE.clear(self)

    def set_verbosity(self, verbosity: bool) -> None:
        """Sets whether filters print reports."""
        BASE.set_verbosity(self, verbosity)
        self._bench.verbose = verbosity

    def set_parameter_verbosity(self, verbosity: bool) -> None:
        """Sets whether the parameters of filters are printed."""
        BASE.set_parameter_verbosity(self, verbosity)
        self._bench.prints_parameters = verbosity

    def __repr__(self) -> str:
        """Returns the number of layers, and a line for each: its id, with ``*`` for the current layer, its name and its size."""
        from ..places import counted

        current = self.current_mesh_id() if self._bench.has_current() else -1
        lines = []
        for mesh in self:
            cells = ((mesh.face_number(), "face"), (mesh.edge_number(), "edge"))
            sizes = [counted(mesh.vertex_number(), "vertex", "vertices"), *(counted(*cell) for cell in cells if cell[0])]
            number = f"{mesh.id()}{'*' if mesh.id() == current else ''}"
            lines.append(f"  {number:<4} {mesh.label()}: {', '.join(sizes)}")
        return "\n".join([f"MeshSet of {counted(len(lines), 'layer')}", *lines])

    __str__ = __repr__  # the `__str__` of pymeshlab returns None


def _locked(meshes: MeshSet, original: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    """Calls a method of pymeshlab that reads or writes files or makes layers, in one thread at a time."""
    with MESHLAB:
        kept = locale.setlocale(locale.LC_ALL)  # MeshLab's library for .3mf files sets "C", so that Python opens texts as ASCII
        try:
            return original(meshes, *args, **kwargs)
        except Exception:
            if meshes._bench.verbose:
                after_failure(meshes, verbose=True)
            raise
        finally:
            locale.setlocale(locale.LC_ALL, kept)


def _locking(name: str) -> Callable[..., Any]:
    original = getattr(BASE, name)

    @functools.wraps(original)
    def method(self: MeshSet, *args: Any, **kwargs: Any) -> Any:
        return _locked(self, original, *args, **kwargs)

    return method


for _name in ("load_new_mesh", "load_new_raster", "load_project", "save_project"):
    setattr(MeshSet, _name, _locking(_name))

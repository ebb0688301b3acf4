"""A mesh set that applies filters of both kinds, MeshLab's own and those of plugins."""

from __future__ import annotations

import inspect
import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import pymeshlab

from ..declaration import Arity, Edit, Filter, Percentage
from ..declaration import Mesh as MeshParameter
from ..errors import ParameterError, PymeshfairError, UnknownNameError
from ..filters.checks import ConvergenceError, FilterInputError
from ..scripts.script import Step
from ..write_back import MeshLayer, adds, adds_or_removes, after_failure, checked_edit, write_edit
from ..write_back.attributes import without_helpers
from .errors import FilterFailedError, FilterParameterError, UnknownFilterError
from .layers import LayeredMeshSet
from .listing import known_filter
from .meshlab_values import declared, for_meshlab, from_meshlab, resolved
from .preconditions import missing

_BASE = pymeshlab.MeshSet
_LOG = logging.getLogger("pymeshfair")


class FilteringMeshSet(LayeredMeshSet):
    """The part of `MeshSet` that applies filters."""

    #: Called with the share of the work that is done, from 0 to 1, while a filter of a plugin works; it may raise to stop it.
    on_progress: Callable[[float], None] | None = None
    #: Called with each sentence that a filter wants to be read; None sends them to the logger ``pymeshfair`` as warnings.
    on_note: Callable[[str], None] | None = None

    def apply_step(self, step: Step) -> dict[str, Any]:
        """Apply a step of a script to the current mesh; it is not added to the filter script.

        Ids of layers in the step are those of a mesh set in which only filters have made layers; see `effective_parameters`.

        Raises:
            pymeshlab.PyMeshLabException: as `apply_filter`.
        """
        return self._run(step.filter, self._from_script(step))[0]

    def save_current_mesh(self, file_name: str, *args: Any, **kwargs: Any) -> None:
        """Save the current mesh as pymeshlab does; a note says so if it has edges that are not in the file.

        MeshLab writes edges into .obj files alone. A run writes them into .ply files, too.
        """
        super().save_current_mesh(file_name, *args, **kwargs)
        edges = self.current_mesh().edge_number()
        if edges and not str(file_name).lower().endswith(".obj"):
            self._tell(
                f"MeshLab does not write the {edges:,} edges of the mesh into {str(file_name)!r}; into an .obj file it does"
            )

    def effective_parameters(self, step: Step) -> dict[str, Any]:
        """All values that the step would run with on the current mesh, by name, as a script says them.

        Lengths that were given or declared as relative stay so. Ids of layers do not count the layers that pymeshfair itself made
        and removed on the way, so that they mean the same whenever the script is applied again.
        """
        known, values = step.filter, self._from_script(step)
        if known.is_builtin:
            self._settle()
            return self._effective_of_meshlab(known, values)
        return self._to_script(known, known.with_defaults(self._declared(known, values)))

    def filter_parameter_values(self, filter_name: str, **kwargs: Any) -> dict[str, Any]:
        """The values that a filter would run with on the current mesh, lengths in mesh units, given some of them.

        Also those of saving a file, given its extension.
        """
        self._settle()
        try:
            known = known_filter(filter_name)
        except UnknownFilterError as unknown:
            try:  # perhaps a file format
                return without_helpers(_BASE.filter_parameter_values(self, filter_name, **kwargs))
            except pymeshlab.PyMeshLabException:
                raise unknown from None
        if known is not None and not known.is_builtin:
            return resolved(known, known.with_defaults(self._declared(known, kwargs)), self._current_layer())
        values = kwargs if known is None else self._for_meshlab(known, kwargs)
        return dict(self._ask_meshlab(filter_name if known is None else known.python_name, **values))

    def _run(self, known: Filter, given: Mapping[str, Any]) -> tuple[dict[str, Any], Step]:
        """Apply the filter; what it reports, and the step that says what it ran with."""
        if known.arity is not Arity.NONE and not self._has_mesh():
            raise FilterFailedError(f"{known.python_name} needs a mesh, and the mesh set has no current one: load one first")
        return self._run_builtin(known, given) if known.is_builtin else self._run_custom(known, given)

    # -------------------------------------------------------------------------------------------------------- MeshLab's

    def _run_builtin(self, known: Filter, given: Mapping[str, Any]) -> tuple[dict[str, Any], Step]:
        self._settle()
        self._check_layers(known, given)
        values = self._for_meshlab(known, given)
        effective = self._effective_of_meshlab(known, given)
        try:
            result = self._call_meshlab(known.python_name, values)
        except pymeshlab.PyMeshLabException:
            for name in given:
                self._check_name(known, name)
            raise
        return result, Step(known, effective)

    def _call_meshlab(self, name: str, values: Mapping[str, Any]) -> dict[str, Any]:
        self._layer = None  # whatever has been read of it until now
        try:
            result: dict[str, Any] = _BASE.apply_filter(self, name, **values)
        except Exception:
            after_failure(self, verbose=self._bench.verbose)
            raise
        _BASE.clear_filter_script(self)  # MeshLab's own list of filters; ours is kept here
        return result

    def _ask_meshlab(self, name: str, **values: Any) -> Mapping[str, Any]:
        told: Mapping[str, Any] = _BASE.filter_parameter_values(self, name, **values)
        return told

    def _for_meshlab(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        try:
            return for_meshlab(known, given, self._ask_meshlab, self._current_layer())
        except ParameterError as error:
            raise FilterParameterError(f"{known.python_name}: {error}") from None

    def _effective_of_meshlab(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        try:
            told = self._ask_meshlab(known.python_name, **self._for_meshlab(known, given))
            effective = from_meshlab(known, told, given, self._ask_meshlab, self._current_layer())
        except (pymeshlab.PyMeshLabException, RuntimeError, TypeError):
            return {}  # MeshLab will say why when the filter is applied
        return self._to_script(known, effective)

    def _check_name(self, known: Filter, name: str) -> None:
        try:
            known.parameter(name)
        except UnknownNameError as error:
            raise UnknownFilterError(str(error), suggestion=error.suggestion) from None

    # --------------------------------------------------------------------------------------------------------- plugins'

    def _run_custom(self, known: Filter, given: Mapping[str, Any]) -> tuple[dict[str, Any], Step]:
        values = known.with_defaults(self._declared(known, given))
        self._check_layers(known, values)
        layer = self._current_layer()
        if lacking := missing(known, layer):
            raise FilterFailedError(f"{known.python_name} cannot be applied: {layer.label!r} has no {' and no '.join(lacking)}")
        edit = self._compute(known, values, layer)
        for note in edit.notes:
            self._tell(note)
        return dict(edit.values), Step(known, self._to_script(known, values))

    def _compute(self, known: Filter, values: Mapping[str, Any], layer: MeshLayer) -> Edit:
        assert known.function is not None
        progress = _Progress(self.on_progress)
        try:
            inputs = resolved(known, values, layer)
            self._say_what_runs(known, inputs)
            if "progress" in inspect.signature(known.function).parameters:
                inputs["progress"] = progress
            edit = checked_edit(known.function(layer, **inputs), layer)
            notes = self._take(layer, edit)
        except Exception as error:
            if progress.stopped is error or isinstance(error, MemoryError):
                raise
            raise FilterFailedError(f"{known.python_name}: {reason(error)}") from error
        return replace(edit, notes=(*edit.notes, *notes))

    def _take(self, layer: MeshLayer, edit: Edit) -> tuple[str, ...]:
        """Make the mesh what the edit says, now or when somebody needs it; what could not be kept, in sentences."""
        if adds(edit):
            self._settle()
            return write_edit(self._bench, edit)
        after = layer.edited(edit)
        if self._deferring and not adds_or_removes(edit):
            self._layer = after
            return ()
        self._layer = None
        more = {name: getattr(edit, name) for name in ("delete_vertices", "delete_faces", "new_layers")}
        return write_edit(self._bench, replace(after.pending, **more))

    def _declared(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        try:
            return declared(known, given)
        except UnknownNameError as error:
            raise UnknownFilterError(str(error), suggestion=error.suggestion) from None
        except ParameterError as error:
            raise FilterParameterError(f"{known.python_name}: {error}") from None

    def _say_what_runs(self, known: Filter, inputs: Mapping[str, Any]) -> None:
        if self._bench.verbose or self._bench.tells_parameters:
            print(f"\nApplying filter {known.python_name} with the following parameters:\n{inputs}\n")

    def _tell(self, note: str) -> None:
        if self.on_note is not None:
            self.on_note(note)
        else:
            _LOG.warning("%s", note)

    # --------------------------------------------------------------------------------------------------- ids of layers

    def _check_layers(self, known: Filter, values: Mapping[str, Any]) -> None:
        for parameter in known.parameters:
            mesh_id = values.get(parameter.name)
            if isinstance(parameter, MeshParameter) and isinstance(mesh_id, int):
                self._check_layer(mesh_id, f"{known.python_name}: parameter {parameter.name!r}: ")

    def _from_script(self, step: Step) -> dict[str, Any]:
        values = _with_ids(step.filter, step.values, self._bench.with_helpers)
        return {**_constant_defaults(step.filter), **values} if step.filter.is_builtin else values

    def _to_script(self, known: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
        return _with_ids(known, values, self._bench.without_helpers)


def _constant_defaults(known: Filter) -> dict[str, Any]:
    """The defaults that are the same on every mesh.

    Some filters of MeshLab, such as isotropic remeshing, take the values of their last use in the process as defaults; a script
    must not depend on what ran before it.
    """
    return {p.name: p.default for p in known.parameters if p.default is not None and not isinstance(p, Percentage)}


def _with_ids(known: Filter, values: Mapping[str, Any], change: Callable[[int], int]) -> dict[str, Any]:
    ids = {p.name for p in known.parameters if isinstance(p, MeshParameter)}
    return {name: change(value) if name in ids and isinstance(value, int) else value for name, value in values.items()}


def reason(error: Exception) -> str:
    """What went wrong, as the end of a sentence; an error that nobody foresaw is named."""
    foreseen = isinstance(error, PymeshfairError | FilterInputError | ConvergenceError | pymeshlab.PyMeshLabException)
    return str(error) if foreseen else f"{type(error).__name__}: {error}"


class _Progress:
    """Hands progress on, and remembers the exception by which the receiver stopped the work."""

    def __init__(self, receiver: Callable[[float], None] | None) -> None:
        self._receiver = receiver
        self.stopped: BaseException | None = None

    def __call__(self, done: float) -> None:
        if self._receiver is None:
            return
        try:
            self._receiver(done)
        except BaseException as error:
            self.stopped = error
            raise

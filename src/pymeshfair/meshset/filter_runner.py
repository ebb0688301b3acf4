"""Applies filters of MeshLab and of plugins to the layers of a mesh set, from calls or scripts, and keeps the steps."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pymeshlab

from ..calling import StoppedError, call, check_needs, reason, resolved
from ..declaration import Arity, Filter, Layer, Length
from ..errors import MeshError, Place
from ..meshlab.base import FilterFailedError, ScriptStepFailedError, apply_filter
from ..meshlab.builtin_filters import BuiltinFilters, checked, constant_defaults
from ..registry import is_known
from ..scripts import Script, Step, format_script, read_script, write_script
from ..scripts.write import NOMINAL_EDGE
from ..write_back import Workbench, without_helpers, write_edit
from .methods import known_filter, length_text

_LOG = logging.getLogger("pymeshfair")


class FilterRunner:
    """Applies filters of MeshLab and of plugins; layer ids in its steps count no helper layers (`Workbench.without_helpers`)."""

    def __init__(self, bench: Workbench) -> None:
        self._bench = bench
        self._builtins = BuiltinFilters(bench.meshset, bench.current)

    def apply(self, filter_name: str, values: Mapping[str, Any]) -> tuple[dict[str, Any], Step | None]:
        """Applies a filter with unchecked values; returns its report, and the step with all values used.

        There is no step for a filter of a C++ plugin that the user loaded into MeshLab, since scripts cannot name it.
        """
        declared = known_filter(filter_name)
        if declared is None:
            return apply_filter(self._bench.meshset, filter_name, values, verbose=self._builtins.verbose), None
        return self._apply(declared, dict(values) if declared.is_builtin else checked(declared, values))

    def apply_step(self, step: Step) -> tuple[dict[str, Any], Step]:
        """Like `apply`, for a step of a script, whose values are already checked."""
        values = _with_changed_ids(step.filter, step.values, self._bench.with_helpers)
        return self._apply(step.filter, {**constant_defaults(step.filter), **values} if step.filter.is_builtin else values)

    def values(self, filter_name: str, values: Mapping[str, Any]) -> dict[str, Any]:
        """Returns the values of `pymeshlab.MeshSet.filter_parameter_values`, also for filters of plugins."""
        if not is_known(filter_name):  # the name may be a file extension; `known_filter` would search for similar names
            with contextlib.suppress(pymeshlab.PyMeshLabException):
                return without_helpers(self._builtins.ask(filter_name, **values))
        declared = known_filter(filter_name)
        if declared is None:
            return self._builtins.ask(filter_name, **values)
        if declared.is_builtin:
            return self._builtins.values(declared, values)
        return resolved(declared, {**declared.defaults, **checked(declared, values)}, self._bench.current())

    def note(self, sentences: Iterable[str], level: int = logging.WARNING) -> None:
        on_note = getattr(self._bench.meshset, "on_note", None)
        tell = partial(_LOG.log, level, "%s") if on_note is None else on_note
        for text in sentences:
            tell(text)

    def _apply(self, declared: Filter, values: dict[str, Any]) -> tuple[dict[str, Any], Step]:
        if declared.arity is not Arity.NONE and not self._bench.has_current():
            raise FilterFailedError(f"{declared.python_name} needs a mesh, but the mesh set has no current mesh: load one first")
        if not declared.is_builtin:
            values = {**declared.defaults, **values}
        for name, mesh_id in declared.layers(values).items():
            self._bench.check(mesh_id, f"{declared.python_name}: parameter {name!r}: ")
        self._builtins.verbose = self._bench.verbose
        ran_with = self._builtins.effective(declared, values) if declared.is_builtin else values
        step = _sized(Step(declared, _with_changed_ids(declared, ran_with, self._bench.without_helpers)), self._bench.current)
        if not declared.is_builtin:
            return self._apply_plugin(declared, values), step
        return self._builtins.apply(declared, values, lambda: format_script(Script((replace(step, values=ran_with),)))), step

    def _apply_plugin(self, declared: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
        layer, bench = self._bench.current(), self._bench
        try:
            check_needs(declared, layer)
        except MeshError as error:
            raise FilterFailedError(str(error)) from None
        try:
            inputs = resolved(declared, values, layer)
            if bench.verbose or bench.prints_parameters:
                print(f"\nApplying filter {declared.python_name} with the following parameters:\n{inputs}\n")
            edit = call(declared, inputs, layer, getattr(bench.meshset, "on_progress", None))
            losses = write_edit(bench, edit, None if declared.arity is Arity.NONE else layer.matrix)
        except StoppedError as error:
            raise error.__cause__ or error from None
        except MemoryError:
            raise
        except Exception as error:
            raise FilterFailedError(f"{declared.python_name}: {reason(error)}") from error
        self.note(edit.notes, logging.INFO)
        self.note(losses)
        return dict(edit.values)


def _with_changed_ids(declared: Filter, values: Mapping[str, Any], change: Callable[[int], int]) -> dict[str, Any]:
    return {**values, **{name: change(number) for name, number in declared.layers(values).items()}}


def _sized(step: Step, current: Callable[[], Layer]) -> Step:
    units = {length.unit for length in step.relative_lengths.values()}
    if not units or step.size is not None:
        return step
    layer = current()
    mean_edge = layer.mean_edge if "edge" in units else NOMINAL_EDGE
    return replace(step, size=(layer.diagonal, mean_edge) if layer.diagonal > 0.0 else None)


class ScriptLog:
    """A filter script: its steps are read from a file or added when filters are applied; it can be applied, printed and saved."""

    def __init__(self, script: Script) -> None:
        self.steps, self._script = list(script.steps), script

    @classmethod
    def of(cls, file: str | None) -> ScriptLog:
        return cls(Script(()) if file is None else read_script(file))

    def apply(self, apply_step: Callable[[Step], tuple[Any, Step]]) -> Iterator[tuple[Any, Step]]:
        """Applies each step, sets its `size`, yields its result and the step as applied, or raises `ScriptStepFailedError`."""
        for number, step in enumerate(list(self.steps), 1):
            try:
                result, done = apply_step(step)
            except Exception as error:
                file = self._script.path if step.line is not None else None
                place = Place.of_step(number, len(self.steps), step.filter.name, file=file, line=step.line)
                raise ScriptStepFailedError(place, reason(error)) from error
            self.steps[number - 1] = replace(step, size=done.size)
            yield result, done

    def save(self, file: str, current: Callable[[], Layer]) -> None:
        """Writes an .mlx file; relative lengths of steps that were not applied get absolute values for the current layer."""
        write_script(self._script.with_steps(_sized(step, current) for step in self.steps), Path(file), overwrite=True)

    def print(self) -> None:
        print(f"Filter Script Size : {len(self.steps)}\n")
        for number, step in enumerate(self.steps):
            print(f"{number}: {step.filter.python_name}")
            for name, value in step.values.items():
                print(f"\t{name} : {type(value).__name__} = {length_text(value) if isinstance(value, Length) else value}")
            print()

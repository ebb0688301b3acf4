"""Applies filters of both kinds, from calls and from steps of scripts."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from typing import Any

import pymeshlab

from ..declaration import Arity, Filter
from ..declaration import Mesh as MeshParameter
from ..meshlab.builtin_filters import BuiltinFilters, constant_defaults
from ..meshlab.errors import FilterFailedError
from ..registry import is_known
from ..scripts.script import Step
from ..write_back import without_helpers
from .layers import Layers
from .listing import known_filter
from .plugin_filters import PluginFilters


class FilterRunner:
    """Finds a filter, sends it to those of its kind, and says what it ran with.

    Ids of layers in a step do not count the layers that the write-back makes and removes, so that a script means the same
    whenever it is applied; see `Workbench.without_helpers`.

    Attributes:
        plugins: the filters of plugins.
        builtins: MeshLab's own.
    """

    def __init__(self, layers: Layers) -> None:
        self._layers = layers
        self.plugins = PluginFilters(layers)
        self.builtins = BuiltinFilters(layers.meshset, layers.current, layers.forget)

    def apply(self, filter_name: str, given: Mapping[str, Any]) -> tuple[dict[str, Any], Step | None]:
        """Apply a filter with values as a caller gives them.

        Returns:
            What it reports, and the step that says what it ran with; None for a filter of a plugin of MeshLab's own kind, which
            no script of ours can name.
        """
        declared = known_filter(filter_name)
        if declared is None:
            self._layers.settle()
            return self.builtins.call(filter_name, given), None
        self._check_mesh(declared)
        result, values = self._of_kind(declared, dict(given) if declared.is_builtin else self.plugins.check(declared, given))
        return result, Step(declared, _with_ids(declared, values, self._layers.bench.without_helpers))

    def apply_step(self, step: Step) -> tuple[dict[str, Any], Step]:
        """Apply a step of a script, whose values are checked; what the filter reports, and the step as it was applied."""
        declared = step.filter
        self._check_mesh(declared)
        result, values = self._of_kind(declared, self._values_here(step))
        return result, Step(declared, _with_ids(declared, values, self._layers.bench.without_helpers))

    def effective(self, step: Step) -> dict[str, Any]:
        """All values that a step would run with, as a script says them: relative lengths stay relative."""
        declared, values = step.filter, self._values_here(step)
        self._layers.settle()
        effective = self.builtins.effective(declared, values) if declared.is_builtin else {**declared.defaults, **values}
        return _with_ids(declared, effective, self._layers.bench.without_helpers)

    def on_mesh(self, step: Step) -> dict[str, Any]:
        """As `effective`, with lengths in mesh units of the current layer."""
        declared, values = step.filter, self._values_here(step)
        self._layers.settle()
        effective = (self.builtins if declared.is_builtin else self.plugins).on_mesh(declared, values)
        return _with_ids(declared, effective, self._layers.bench.without_helpers)

    def values(self, filter_name: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """What `pymeshlab.MeshSet.filter_parameter_values` tells, for filters of both kinds and for file formats."""
        self._layers.settle()
        if not is_known(filter_name):  # perhaps a file format, for which every file that is written asks many times
            with contextlib.suppress(pymeshlab.PyMeshLabException):
                return without_helpers(dict(self.builtins.ask(filter_name, **given)))
        declared = known_filter(filter_name)
        if declared is None:
            return dict(self.builtins.ask(filter_name, **given))
        if declared.is_builtin:
            return self.builtins.values(declared, given)
        return self.plugins.on_mesh(declared, self.plugins.check(declared, given))

    def _of_kind(self, declared: Filter, values: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        if not declared.is_builtin:
            return self.plugins.apply(declared, values)
        self._layers.settle()
        self._layers.check_named(declared, values)
        self.builtins.verbose = self._layers.bench.verbose
        return self.builtins.apply(declared, values)

    def _check_mesh(self, declared: Filter) -> None:
        if declared.arity is not Arity.NONE and not self._layers.has_current():
            raise FilterFailedError(f"{declared.python_name} needs a mesh, and the mesh set has no current one: load one first")

    def _values_here(self, step: Step) -> dict[str, Any]:
        values = _with_ids(step.filter, step.values, self._layers.bench.with_helpers)
        return {**constant_defaults(step.filter), **values} if step.filter.is_builtin else values


def _with_ids(declared: Filter, values: Mapping[str, Any], change: Callable[[int], int]) -> dict[str, Any]:
    ids = {p.name for p in declared.parameters if isinstance(p, MeshParameter)}
    return {name: change(value) if name in ids and isinstance(value, int) else value for name, value in values.items()}

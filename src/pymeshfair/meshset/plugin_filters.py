"""Applies filters of plugins to a mesh set."""

from __future__ import annotations

import inspect
import logging
from collections.abc import Callable, Mapping
from typing import Any

from ..declaration import Edit, Filter, Layer, Length, Percentage
from ..errors import ParameterError, UnknownNameError
from ..write_back import MeshLayer, checked_edit
from .errors import FilterFailedError, FilterParameterError, UnknownFilterError, reason
from .layers import Layers
from .meshlab_values import as_length
from .preconditions import missing

_LOG = logging.getLogger("pymeshfair")


class PluginFilters:
    """Filters of plugins on the current layer of a mesh set.

    Attributes:
        on_progress: called with the share of the work that is done, from 0 to 1; it may raise to stop the filter.
        on_note: called with each sentence that a filter wants to be read; None sends them to the logger ``pymeshfair``.
    """

    def __init__(self, layers: Layers) -> None:
        self._layers = layers
        self.on_progress: Callable[[float], None] | None = None
        self.on_note: Callable[[str], None] | None = None

    def check(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        """The given values, checked as declared; the only check between a caller and the filter's function.

        Raises:
            UnknownFilterError: no such parameter.
            FilterParameterError: a value that the parameter does not take.
        """
        lengths = {p.name for p in known.parameters if isinstance(p, Percentage)}
        try:
            return known.check({name: as_length(value) if name in lengths else value for name, value in given.items()})
        except UnknownNameError as error:
            raise UnknownFilterError(str(error), suggestion=error.suggestion) from None
        except ParameterError as error:
            raise FilterParameterError(f"{known.python_name}: {error}") from None

    def apply(self, known: Filter, checked: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Apply the filter with checked values; what it reports, and the values that it ran with."""
        values = {**known.defaults, **checked}
        self._layers.check_named(known, values)
        layer = self._layers.current()
        if lacking := missing(known, layer):
            raise FilterFailedError(f"{known.python_name} cannot be applied: {layer.label!r} has no {' and no '.join(lacking)}")
        edit, notes = self._compute(known, values, layer)
        for note in (*edit.notes, *notes):
            self.tell(note)
        return dict(edit.values), values

    def on_mesh(self, known: Filter, checked: Mapping[str, Any]) -> dict[str, Any]:
        """The values that the filter would run with, lengths in mesh units."""
        return _resolved(known, {**known.defaults, **checked}, self._layers.current())

    def tell(self, note: str) -> None:
        """Pass on a sentence that the user should read."""
        if self.on_note is not None:
            self.on_note(note)
        else:
            _LOG.warning("%s", note)

    def _compute(self, known: Filter, values: Mapping[str, Any], layer: MeshLayer) -> tuple[Edit, tuple[str, ...]]:
        assert known.function is not None
        progress = _Progress(self.on_progress)
        try:
            inputs = _resolved(known, values, layer)
            if self._layers.bench.verbose or self._layers.bench.tells_parameters:
                print(f"\nApplying filter {known.python_name} with the following parameters:\n{inputs}\n")
            if "progress" in inspect.signature(known.function).parameters:
                inputs["progress"] = progress
            edit = checked_edit(known.function(layer, **inputs), layer)
            return edit, self._layers.take(layer, edit)
        except Exception as error:
            if progress.stopped is error or isinstance(error, MemoryError):
                raise
            raise FilterFailedError(f"{known.python_name}: {reason(error)}") from error


def _resolved(known: Filter, values: Mapping[str, Any], layer: Layer) -> dict[str, Any]:
    """Declared values as a filter's function takes them: lengths in mesh units on this layer."""
    of_edges = {p.name for p in known.parameters if isinstance(p, Percentage) and p.of_edges}

    def mesh_units(name: str, length: Length) -> float:
        measure = _mean_polyline_edge if name in of_edges else _mean_edge
        return length.resolve(diagonal=layer.diagonal, mean_edge=lambda: measure(layer))

    return {name: mesh_units(name, value) if isinstance(value, Length) else value for name, value in values.items()}


def _mean_edge(layer: Layer) -> float:
    return layer.mean_edge


def _mean_polyline_edge(layer: Layer) -> float:
    from ..filters.geometry import mean_edge_length  # compiled code, which not every use of a mesh set needs

    return mean_edge_length(layer.vertices, layer.edges) if len(layer.edges) else layer.mean_edge


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

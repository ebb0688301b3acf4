"""Applies filters of plugins to a mesh set."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from ..calling import StoppedError, call, check_needs, resolved
from ..declaration import Edit, Filter, Percentage
from ..errors import MeshError, ParameterError, UnknownNameError
from ..meshlab.errors import FilterFailedError, FilterParameterError, UnknownFilterError, reason
from ..meshlab.values import as_length
from ..write_back import MeshLayer
from .layers import Layers

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

    def check(self, declared: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        """The given values, checked as declared; the only check between a caller and the filter's function.

        Raises:
            UnknownFilterError: no such parameter.
            FilterParameterError: a value that the parameter does not take.
        """
        lengths = {p.name for p in declared.parameters if isinstance(p, Percentage)}
        try:
            return declared.check({name: as_length(value) if name in lengths else value for name, value in given.items()})
        except UnknownNameError as error:
            raise UnknownFilterError(str(error), suggestion=error.suggestion) from None
        except ParameterError as error:
            raise FilterParameterError(f"{declared.python_name}: {error}") from None

    def apply(self, declared: Filter, checked: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Apply the filter with checked values; what it reports, and the values that it ran with."""
        values = {**declared.defaults, **checked}
        self._layers.check_named(declared, values)
        layer = self._layers.current()
        try:
            check_needs(declared, layer)
        except MeshError as error:
            raise FilterFailedError(str(error)) from None
        edit, losses = self._compute(declared, values, layer)
        for note in edit.notes:
            self.tell(note)
        self.tell_losses(losses)
        return dict(edit.values), values

    def on_mesh(self, declared: Filter, checked: Mapping[str, Any]) -> dict[str, Any]:
        """The values that the filter would run with, lengths in mesh units."""
        return resolved(declared, {**declared.defaults, **checked}, self._layers.current())

    def tell(self, note: str) -> None:
        """Pass on a sentence of a filter."""
        if self.on_note is not None:
            self.on_note(note)
        else:
            _LOG.info("%s", note)

    def tell_losses(self, losses: Iterable[str]) -> None:
        """Pass on what is not kept."""
        for text in losses:
            if self.on_note is not None:
                self.on_note(text)
            else:
                _LOG.warning("%s", text)

    def _compute(self, declared: Filter, values: Mapping[str, Any], layer: MeshLayer) -> tuple[Edit, tuple[str, ...]]:
        try:
            inputs = resolved(declared, values, layer)
            if self._layers.bench.verbose or self._layers.bench.tells_parameters:
                print(f"\nApplying filter {declared.python_name} with the following parameters:\n{inputs}\n")
            edit = call(declared, inputs, layer, self.on_progress)
            return edit, self._layers.take(layer, edit)
        except StoppedError as error:
            raise error.__cause__ or error from None
        except MemoryError:
            raise
        except Exception as error:
            raise FilterFailedError(f"{declared.python_name}: {reason(error)}") from error

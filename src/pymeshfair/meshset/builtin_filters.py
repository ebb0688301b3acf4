"""Applies MeshLab's own filters to a mesh set."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pymeshlab

from ..declaration import Filter, Length
from ..errors import ParameterError, UnknownNameError
from ..write_back import after_failure
from .errors import FilterParameterError, UnknownFilterError
from .layers import Layers
from .meshlab_values import for_meshlab, from_meshlab

_BASE = pymeshlab.MeshSet


class BuiltinFilters:
    """MeshLab's filters on the current layer of a mesh set."""

    def __init__(self, layers: Layers) -> None:
        self._layers = layers

    def apply(self, known: Filter, given: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Apply the filter.

        Args:
            known: the filter.
            given: values in pymeshlab's classes, as `Length` or as text; MeshLab takes its defaults for the others.

        Returns:
            What the filter reports, and the values that it ran with.
        """
        self._layers.settle()
        self._layers.check_named(known, given)
        values = self._for_meshlab(known, given)
        effective = self.effective(known, given)
        try:
            result = self.call(known.python_name, values)
        except pymeshlab.PyMeshLabException:
            for name in given:
                _check_name(known, name)
            raise
        return result, effective

    def call(self, name: str, values: Mapping[str, Any]) -> dict[str, Any]:
        """Call pymeshlab's filter of that name; what it reports."""
        self._layers.settle()
        self._layers.forget()
        try:
            result: dict[str, Any] = _BASE.apply_filter(self._layers.meshset, name, **values)
        except Exception:
            after_failure(self._layers.meshset, verbose=self._layers.bench.verbose)
            raise
        _BASE.clear_filter_script(self._layers.meshset)  # MeshLab's own list of filters; `ScriptLog` keeps ours
        return result

    def ask(self, name: str, **values: Any) -> Mapping[str, Any]:
        """All values that pymeshlab's filter of that name would run with on the current layer."""
        told: Mapping[str, Any] = _BASE.filter_parameter_values(self._layers.meshset, name, **values)
        return told

    def effective(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        """The values that the filter would run with, as declared; relative lengths stay relative."""
        self._layers.settle()
        try:
            told = self.ask(known.python_name, **self._for_meshlab(known, given))
            return from_meshlab(known, told, given, self.ask, self._layers.current())
        except (pymeshlab.PyMeshLabException, RuntimeError, TypeError):
            return {}  # MeshLab will say why when the filter is applied

    def values(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        """The values that the filter would run with, as pymeshlab tells them: lengths in mesh units."""
        self._layers.settle()
        return dict(self.ask(known.python_name, **self._for_meshlab(known, given)))

    def on_mesh(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        """As `effective`, with lengths in mesh units."""
        effective = self.effective(known, given)
        lengths = {name: value for name, value in effective.items() if isinstance(value, Length)}
        resolved = self.values(known, lengths) if lengths else {}
        return {name: resolved[name] if name in lengths else value for name, value in effective.items()}

    def _for_meshlab(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        try:
            return for_meshlab(known, given, self.ask, self._layers.current())
        except ParameterError as error:
            raise FilterParameterError(f"{known.python_name}: {error}") from None


def _check_name(known: Filter, name: str) -> None:
    try:
        known.parameter(name)
    except UnknownNameError as error:
        raise UnknownFilterError(str(error), suggestion=error.suggestion) from None

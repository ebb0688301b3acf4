"""Applies MeshLab's own filters to the current layer of a pymeshlab mesh set."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pymeshlab

from ..declaration import Filter, Layer, Length, Percentage
from ..errors import ParameterError, UnknownNameError
from .aftermath import after_failure
from .base import BASE, MESHLAB
from .errors import FilterParameterError, UnknownFilterError
from .values import for_meshlab, from_meshlab


class BuiltinFilters:
    """MeshLab's filters on one mesh set.

    Attributes:
        verbose: whether the mesh set tells on stderr what it does.
    """

    def __init__(self, meshset: Any, current: Callable[[], Layer], changing: Callable[[], None] = lambda: None) -> None:
        """See the class.

        Args:
            meshset: any `pymeshlab.MeshSet`.
            current: gives its current layer.
            changing: called before a filter changes the mesh set.
        """
        self._meshset = meshset
        self._current = current
        self._changing = changing
        self.verbose = False

    def apply(self, known: Filter, given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Apply the filter.

        Args:
            known: the filter.
            given: values in pymeshlab's classes, as `Length` or as text; MeshLab takes its defaults for the others.

        Returns:
            What the filter reports, and the values that it ran with.
        """
        values = self._for_meshlab(known, given)
        effective = self.effective(known, given)
        try:
            result = self.call(known.python_name, values)
        except pymeshlab.PyMeshLabException:
            for name in given:
                _check_name(known, name)
            raise
        except RuntimeError:
            self._check_types(known, given, values)
            raise
        return result, effective

    def _check_types(self, known: Filter, given: Mapping[str, Any], values: Mapping[str, Any]) -> None:
        """Raise the error that names the parameter of which pymeshlab cannot read the value; its own says a C++ type '?'."""
        for name, value in values.items():
            try:
                self.ask(known.python_name, **{name: value})
            except RuntimeError:  # noqa: PERF203
                allowed = known.parameter(name).describe_allowed()
                text = f"{known.python_name}: parameter {name!r} takes {allowed}, got {given[name]!r}"
                raise FilterParameterError(text) from None

    def call(self, name: str, values: Mapping[str, Any]) -> dict[str, Any]:
        """Call pymeshlab's filter of that name; what it reports."""
        self._changing()
        with MESHLAB:
            try:
                result: dict[str, Any] = BASE.apply_filter(self._meshset, name, **values)
            except Exception:
                after_failure(self._meshset, verbose=self.verbose)
                raise
            BASE.clear_filter_script(self._meshset)  # MeshLab's own list of filters
        return result

    def ask(self, name: str, **values: Any) -> Mapping[str, Any]:
        """All values that pymeshlab's filter of that name would run with on the current layer."""
        with MESHLAB:
            told: Mapping[str, Any] = BASE.filter_parameter_values(self._meshset, name, **values)
        return told

    def effective(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        """The values that the filter would run with, as declared; relative lengths stay relative."""
        try:
            told = self.ask(known.python_name, **self._for_meshlab(known, given))
            return from_meshlab(known, told, given, self.ask, self._current())
        except (pymeshlab.PyMeshLabException, RuntimeError, TypeError):
            return {}  # MeshLab will say why when the filter is applied

    def values(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        """The values that the filter would run with, as pymeshlab tells them: lengths in mesh units."""
        return dict(self.ask(known.python_name, **self._for_meshlab(known, given)))

    def on_mesh(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        """As `effective`, with lengths in mesh units."""
        effective = self.effective(known, given)
        lengths = {name: value for name, value in effective.items() if isinstance(value, Length)}
        resolved = self.values(known, lengths) if lengths else {}
        return {name: resolved[name] if name in lengths else value for name, value in effective.items()}

    def _for_meshlab(self, known: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        try:
            return for_meshlab(known, given, self.ask, self._current())
        except ParameterError as error:
            raise FilterParameterError(f"{known.python_name}: {error}") from None


def constant_defaults(known: Filter) -> dict[str, Any]:
    """The defaults of a filter of MeshLab's that are the same on every mesh.

    Some filters, such as isotropic remeshing, take the values of their last use in the process as defaults; a script must not
    depend on what ran before it.
    """
    return {p.name: p.default for p in known.parameters if p.default is not None and not isinstance(p, Percentage)}


def _check_name(known: Filter, name: str) -> None:
    try:
        known.parameter(name)
    except UnknownNameError as error:
        raise UnknownFilterError(str(error), suggestion=error.suggestion) from None

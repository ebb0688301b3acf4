"""Applies MeshLab's own filters to the current layer of a pymeshlab mesh set."""

from collections.abc import Callable, Mapping
from typing import Any

import pymeshlab

from ..declaration import Filter, Layer, Length, Percentage
from ..errors import ParameterError, UnknownNameError
from .base import BASE, MESHLAB, apply_filter
from .errors import FilterParameterError, UnknownFilterError
from .values import for_meshlab, from_meshlab


class BuiltinFilters:
    """MeshLab's filters on one mesh set.

    Attributes:
        verbose: whether the mesh set tells on stderr what it does.
    """

    def __init__(self, meshset: Any, current: Callable[[], Layer], changing: Callable[[], None] = lambda: None) -> None:
        """See the class; `current` gives the current layer, and `changing` is called before a filter changes the mesh set."""
        self._meshset = meshset
        self._current = current
        self._changing = changing
        self.verbose = False

    def apply(self, declared: Filter, given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Apply the filter; its report, and the values that it ran with. MeshLab takes its defaults for those not given."""
        values = self._for_meshlab(declared, given)
        effective = self.effective(declared, given)
        try:
            result = self.call(declared.python_name, values)
        except pymeshlab.PyMeshLabException:
            for name in given:
                _check_name(declared, name)
            raise
        except RuntimeError:
            self._check_types(declared, given, values)
            raise
        return result, effective

    def _check_types(self, declared: Filter, given: Mapping[str, Any], values: Mapping[str, Any]) -> None:
        """Raise the error that names the parameter of which pymeshlab cannot read the value; its own says a C++ type '?'."""
        for name, value in values.items():
            try:
                self.ask(declared.python_name, **{name: value})
            except RuntimeError:  # noqa: PERF203
                allowed = declared.parameter(name).describe_allowed()
                text = f"{declared.python_name}: parameter {name!r} takes {allowed}, got {given[name]!r}"
                raise FilterParameterError(text) from None

    def call(self, name: str, values: Mapping[str, Any]) -> dict[str, Any]:
        """Call pymeshlab's filter of that name; what it reports."""
        self._changing()
        return apply_filter(self._meshset, name, values, verbose=self.verbose)

    def ask(self, name: str, **values: Any) -> Mapping[str, Any]:
        """All values that pymeshlab's filter of that name would run with on the current layer."""
        with MESHLAB:
            values_of_meshlab: Mapping[str, Any] = BASE.filter_parameter_values(self._meshset, name, **values)
        return values_of_meshlab

    def effective(self, declared: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        """The values that the filter would run with, as declared; relative lengths stay relative."""
        try:
            told = self.ask(declared.python_name, **self._for_meshlab(declared, given))
            return from_meshlab(declared, told, given, self.ask, self._current())
        except (pymeshlab.PyMeshLabException, RuntimeError, TypeError):
            return {}  # MeshLab will say why when the filter is applied

    def values(self, declared: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        """The values that the filter would run with, as pymeshlab tells them: lengths in mesh units."""
        return dict(self.ask(declared.python_name, **self._for_meshlab(declared, given)))

    def on_mesh(self, declared: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        """As `effective`, with lengths in mesh units."""
        effective = self.effective(declared, given)
        lengths = {name: value for name, value in effective.items() if isinstance(value, Length)}
        resolved = self.values(declared, lengths) if lengths else {}
        return {name: resolved[name] if name in lengths else value for name, value in effective.items()}

    def _for_meshlab(self, declared: Filter, given: Mapping[str, Any]) -> dict[str, Any]:
        try:
            return for_meshlab(declared, given, self.ask, self._current())
        except ParameterError as error:
            raise FilterParameterError(f"{declared.python_name}: {error}") from None


def constant_defaults(declared: Filter) -> dict[str, Any]:
    """The defaults of a filter of MeshLab's that are the same on every mesh.

    Some filters, such as isotropic remeshing, take the values of their last use in the process as defaults; a script must not
    depend on what ran before it.
    """
    return {p.name: p.default for p in declared.parameters if p.default is not None and not isinstance(p, Percentage)}


def _check_name(declared: Filter, name: str) -> None:
    try:
        declared.parameter(name)
    except UnknownNameError as error:
        raise UnknownFilterError(str(error), suggestion=error.suggestion) from None

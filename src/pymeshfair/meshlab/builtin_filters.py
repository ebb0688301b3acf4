"""Applies MeshLab's own filters to the current layer of a pymeshlab mesh set; converts values from and to declared ones."""

import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, TypeAlias

import numpy as np
import pymeshlab

from ..declaration import Color, Enum, Filter, Float, Layer, Length, Matrix, Parameter, Percentage, Point
from ..errors import ParameterError, UnknownNameError
from .base import BASE, MESHLAB, FilterParameterError, UnknownFilterError, apply_filter

#: gives the current layer
_Current: TypeAlias = Callable[[], Layer]


class BuiltinFilters:
    """MeshLab's filters on one mesh set, of which `current` gives the current layer; `verbose` if it reports on stderr."""

    def __init__(self, meshset: Any, current: _Current, *, verbose: bool = False) -> None:
        self._meshset, self._current, self.verbose = meshset, current, verbose

    def apply(self, declared: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
        """Apply the filter; its report. Absent values are MeshLab's defaults."""
        converted = self._for_meshlab(declared, values)
        try:
            return self.call(declared.python_name, converted)
        except pymeshlab.PyMeshLabException:
            checked(declared, dict.fromkeys(values.keys() - declared.defaults.keys()))  # a wrong name gets a suggestion
            raise
        except RuntimeError:
            checked(declared, values)  # pymeshlab's own error does not name the parameter whose value it cannot read
            raise

    def call(self, name: str, values: Mapping[str, Any]) -> dict[str, Any]:
        """Call pymeshlab's filter of that name; its report."""
        return apply_filter(self._meshset, name, values, verbose=self.verbose)

    def ask(self, name: str, **values: Any) -> dict[str, Any]:
        """All values that pymeshlab's filter of that name would run with on the current layer."""
        with MESHLAB:
            return dict(BASE.filter_parameter_values(self._meshset, name, **values))

    def effective(self, declared: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
        """The values that the filter would run with, as declared; relative lengths stay so, the caller's numbers keep digits.

        Values that no script can have (a camera, a number that is not finite) are absent.
        """
        try:
            used = self.values(declared, values)
        except (pymeshlab.PyMeshLabException, RuntimeError, TypeError):
            return {}  # MeshLab gives the reason when the filter is applied
        layer, effective = cache(self._current), {}
        for p in declared.parameters:
            if p.name in used:
                try:
                    effective[p.name] = self._from_meshlab(declared, p, used[p.name], values.get(p.name), layer)
                except (ParameterError, IndexError):
                    continue
        return effective

    def values(self, declared: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
        """The values that the filter would run with, as pymeshlab has them: lengths in mesh units."""
        return self.ask(declared.python_name, **self._for_meshlab(declared, values))

    def on_mesh(self, declared: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
        """As `effective`, with lengths in mesh units."""
        effective = self.effective(declared, values)
        lengths = {name: value for name, value in effective.items() if isinstance(value, Length)}
        resolved = self.values(declared, lengths) if lengths else {}
        return {name: resolved[name] if name in lengths else value for name, value in effective.items()}

    def _for_meshlab(self, declared: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
        """The values as pymeshlab takes them: lengths, and colours, points and matrices as tuples, in its classes."""
        layer, converted = cache(self._current), dict(values)
        try:
            for p in declared.parameters:
                if p.name in values:
                    converted[p.name] = self._converted(declared, p, values[p.name], layer)
        except ParameterError as error:
            raise FilterParameterError(f"{declared.python_name}: {error}") from None
        return converted

    def _converted(self, declared: Filter, parameter: Parameter, value: Any, layer: _Current) -> Any:
        if isinstance(parameter, Percentage) and not isinstance(value, pymeshlab.PercentageValue | pymeshlab.PureValue):
            length = value if isinstance(value, Length) else parameter.check(value)
            if length.unit == "percent" and 0.0 <= length.amount <= 100.0 and self._is_of_diagonal(declared, parameter, layer):
                return pymeshlab.PercentageValue(length.amount)
            return pymeshlab.PureValue(length.resolve(diagonal=layer().diagonal, mean_edge=lambda: layer().mean_edge))
        if isinstance(parameter, Color) and isinstance(value, tuple):
            return pymeshlab.Color(*value)
        if isinstance(parameter, Point | Matrix) and isinstance(value, tuple):
            return np.array(value, dtype=np.float64)
        return value

    def _is_of_diagonal(self, declared: Filter, parameter: Parameter, layer: _Current) -> bool:
        """Whether MeshLab's percentages of this parameter are of the diagonal; those of a few are of something else."""
        zero, hundred = (
            self.ask(declared.python_name, **{parameter.name: pymeshlab.PercentageValue(p)})[parameter.name] for p in (0, 100)
        )
        return zero == 0.0 and math.isclose(hundred, layer().diagonal, rel_tol=1e-6)

    def _from_meshlab(self, declared: Filter, parameter: Parameter, used: Any, typed: Any, layer: _Current) -> Any:
        """A value that MeshLab used, as declared; `typed` is that of the caller, or None."""
        if isinstance(parameter, Percentage):
            return parameter.check(self._length(declared, parameter, used, typed, layer))
        if isinstance(parameter, Enum):
            return parameter.check(parameter.choices[used])
        if isinstance(parameter, Color):
            return parameter.check((used.red(), used.green(), used.blue(), used.alpha()))
        if isinstance(parameter, Float):
            is_typed = isinstance(typed, float | int) and np.float32(typed) == np.float32(used)
            number = float(typed) if is_typed else _shortest(used)
            # MeshLab clamps numbers of sliders, and its own defaults may lie a rounding outside.
            low, high = (number if bound is None else bound for bound in (parameter.minimum, parameter.maximum))
            return parameter.check(min(max(number, low), high))
        return parameter.check(used)

    def _length(self, declared: Filter, parameter: Percentage, used: float, typed: Any, layer: _Current) -> Any:
        """The length that a filter used: relative where the caller typed it so, or typed none and the default is relative."""
        length = as_length(typed)
        if isinstance(typed, str | Length) or (isinstance(length, Length) and length.unit != "percent"):
            return length
        if isinstance(length, Length) and self._is_of_diagonal(declared, parameter, layer):
            return length
        default = parameter.default
        scales = isinstance(default, Length) and (default.unit == "percent" or default.amount == 0.0)
        if length is not None and scales and layer().diagonal > 0.0:  # percent of a range that is a part of the diagonal
            return Length(_shortest(100.0 * used / layer().diagonal), "percent")
        if length is None and isinstance(default, Length) and default.unit == "percent":
            usual = default.resolve(diagonal=layer().diagonal, mean_edge=lambda: layer().mean_edge)
            if math.isclose(used, usual, rel_tol=1e-4):  # the table gives parts of the diagonal with five digits
                return default
        return Length(_shortest(used))


def checked(declared: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
    """The values, checked as declared: of a plugin's filter the only check before its function."""
    lengths = {p.name for p in declared.parameters if isinstance(p, Percentage)}
    try:
        return declared.check({name: as_length(value) if name in lengths else value for name, value in values.items()})
    except UnknownNameError as error:
        raise UnknownFilterError(str(error), suggestion=error.suggestion) from None
    except ParameterError as error:
        raise FilterParameterError(f"{declared.python_name}: {error}") from None


def as_length(value: Any) -> Any:
    """A length in pymeshlab's classes, which have single precision, or as text as a `Length`; all else, and "auto", as it is."""
    if isinstance(value, pymeshlab.PercentageValue):
        return Length(_shortest(value.value()), "percent")
    if isinstance(value, pymeshlab.PureValue):
        return Length(_shortest(value.value()))
    return Length.parse(value) if isinstance(value, str) and value != "auto" else value


def _shortest(single: float) -> float:
    """The number with the fewest digits that is the same one in single precision."""
    return float(str(np.float32(single)))


def constant_defaults(declared: Filter) -> dict[str, Any]:
    """The defaults of MeshLab's filter that are the same on every mesh; some filters would take the values of their last use."""
    return {p.name: p.default for p in declared.parameters if p.default is not None and not isinstance(p, Percentage)}

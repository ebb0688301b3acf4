"""Applies MeshLab's own filters to the current layer; converts values to pymeshlab's classes and back."""

import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, TypeAlias

import numpy as np
import pymeshlab

from ..declaration import Color, Enum, Filter, Float, Layer, Length, Matrix, Parameter, Percentage, Point, as_float
from ..errors import ParameterError, UnknownNameError
from .base import BASE, MESHLAB, FilterParameterError, UnknownFilterError, apply_filter

_Current: TypeAlias = Callable[[], Layer]


class BuiltinFilters:
    """MeshLab's filters on one mesh set; `current` returns its current layer, `verbose` says whether they report on stderr."""

    def __init__(self, meshset: Any, current: _Current, *, verbose: bool = False) -> None:
        self._meshset, self._current, self.verbose = meshset, current, verbose

    def apply(self, declared: Filter, values: Mapping[str, Any], script: Callable[[], str]) -> dict[str, Any]:
        """Applies a filter; if a number is beyond its bounds it applies `script`, the step as a script, which has no bounds."""
        converted = self._for_meshlab(declared, values)
        try:
            if is_beyond := self._is_beyond_bounds(declared, converted):
                checked(declared, values)  # raises an error for values that the script would leave out
            text = script() if is_beyond else ""
            return apply_filter(self._meshset, declared.python_name, converted, verbose=self.verbose, script=text)
        except pymeshlab.PyMeshLabException:
            checked(declared, dict.fromkeys(values.keys() - declared.defaults.keys()))  # a wrong name gets a suggestion
            raise
        except RuntimeError:
            checked(declared, values)  # pymeshlab's own error does not name the parameter whose value it cannot read
            raise

    def _is_beyond_bounds(self, declared: Filter, values: Mapping[str, Any]) -> bool:
        """Whether a number is beyond bounds that MeshLab computes from the mesh; a call of pymeshlab would use the bound."""
        free = [p.name for p in declared.parameters if isinstance(p, Float) and p.minimum is None]
        given = {name: values[name] for name in free if isinstance(values.get(name), float) and math.isfinite(values[name])}
        used = self.ask(declared.python_name, **values) if given else {}
        return any(not math.isclose(number, used[name], rel_tol=1e-7, abs_tol=1e-37) for name, number in given.items())

    def ask(self, name: str, **values: Any) -> dict[str, Any]:
        """Returns all values that pymeshlab's filter of that name would run with on the current layer."""
        with MESHLAB:
            return dict(BASE.filter_parameter_values(self._meshset, name, **values))

    def effective(self, declared: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
        """Returns the values that the filter would run with, as in a script: relative lengths and the caller's digits are kept.

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
        """Returns the values that the filter would run with, in pymeshlab's form: lengths in mesh units."""
        return self.ask(declared.python_name, **self._for_meshlab(declared, values))

    def on_mesh(self, declared: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
        """Returns the values of `effective`, with lengths in mesh units."""
        effective = self.effective(declared, values)
        lengths = {name: value for name, value in effective.items() if isinstance(value, Length)}
        resolved = self.values(declared, lengths) if lengths else {}
        return {name: resolved[name] if name in lengths else value for name, value in effective.items()}

    def _for_meshlab(self, declared: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
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
        return (as_float(value) or value) if isinstance(parameter, Float) else value

    def _is_of_diagonal(self, declared: Filter, parameter: Parameter, layer: _Current) -> bool:
        """Whether MeshLab's percentages of this parameter refer to the diagonal; a few refer to another length."""
        zero, hundred = (
            self.ask(declared.python_name, **{parameter.name: pymeshlab.PercentageValue(p)})[parameter.name] for p in (0, 100)
        )
        return zero == 0.0 and math.isclose(hundred, layer().diagonal, rel_tol=1e-6)

    def _from_meshlab(self, declared: Filter, parameter: Parameter, used: Any, typed: Any, layer: _Current) -> Any:
        """Converts `used`, a value from MeshLab; `typed` is the caller's value, or None."""
        if isinstance(parameter, Percentage):
            return parameter.check(self._length(declared, parameter, used, typed, layer))
        if isinstance(parameter, Enum):
            return parameter.check(parameter.choices[used])
        if isinstance(parameter, Color):
            return parameter.check((used.red(), used.green(), used.blue(), used.alpha()))
        if isinstance(parameter, Float):
            number = as_float(typed)
            number = _shortest(used) if number is None else number
            # MeshLab's own defaults may be out of range by a rounding error.
            low, high = (number if bound is None else bound for bound in (parameter.minimum, parameter.maximum))
            return parameter.check(min(max(number, low), high))
        return parameter.check(used)

    def _length(self, declared: Filter, parameter: Percentage, used: float, typed: Any, layer: _Current) -> Any:
        length = as_length(typed)
        is_kept = isinstance(typed, str | Length) or (isinstance(length, Length) and length.unit != "percent")
        if is_kept or (isinstance(length, Length) and self._is_of_diagonal(declared, parameter, layer)):
            return length
        default = parameter.default
        scales = isinstance(default, Length) and (default.unit == "percent" or default.amount == 0.0)
        if length is not None and scales and layer().diagonal > 0.0:
            return Length(_shortest(100.0 * used / layer().diagonal), "percent")
        if length is None and isinstance(default, Length) and default.unit == "percent":
            usual = default.resolve(diagonal=layer().diagonal, mean_edge=lambda: layer().mean_edge)
            if math.isclose(used, usual, rel_tol=1e-4):  # declared percentages of the diagonal have five digits
                return default
        return Length(_shortest(used))


def checked(declared: Filter, values: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the values after the checks of the declaration."""
    lengths = {p.name for p in declared.parameters if isinstance(p, Percentage)}
    try:
        return declared.check({name: as_length(value) if name in lengths else value for name, value in values.items()})
    except UnknownNameError as error:
        raise UnknownFilterError(str(error), suggestion=error.suggestion) from None
    except ParameterError as error:
        raise FilterParameterError(f"{declared.python_name}: {error}") from None


def as_length(value: Any) -> Any:
    """Converts text, or a length of pymeshlab (single precision), to a `Length`; returns "auto" and all else unchanged."""
    if isinstance(value, pymeshlab.PercentageValue):
        return Length(_shortest(value.value()), "percent")
    if isinstance(value, pymeshlab.PureValue):
        return Length(_shortest(value.value()))
    return Length.parse(value) if isinstance(value, str) and value != "auto" else value


def _shortest(single: float) -> float:
    """Returns the number with the fewest digits that is equal in single precision."""
    return float(str(np.float32(single)))


def constant_defaults(declared: Filter) -> dict[str, Any]:
    """Returns the mesh-independent defaults, except lengths. Without them some filters reuse values of their previous call."""
    return {p.name: p.default for p in declared.parameters if p.default is not None and not isinstance(p, Percentage)}

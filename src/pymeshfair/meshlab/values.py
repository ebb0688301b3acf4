"""Converts values of parameters between declarations and pymeshlab."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pymeshlab

from ..declaration import Color, Enum, Filter, Float, Layer, Length, Matrix, Parameter, Percentage, Point
from ..errors import ParameterError

#: Asks MeshLab for all values of one filter, from those given.
AskMeshLab = Callable[..., Mapping[str, Any]]


def as_length(value: Any) -> Any:
    """A length in pymeshlab's classes or as text as a `Length`; anything else, and "auto", as it is.

    pymeshlab keeps numbers in single precision; ``PercentageValue(0.1)`` becomes 0.1 %, not 0.10000000149011612 %.
    """
    if isinstance(value, pymeshlab.PercentageValue):
        return Length(shortest(value.value()), "percent")
    if isinstance(value, pymeshlab.PureValue):
        return Length(shortest(value.value()))
    return Length.parse(value) if isinstance(value, str) and value != "auto" else value


def shortest(single: float) -> float:
    """The number with the fewest digits that is the same one in single precision."""
    return float(str(np.float32(single)))


def for_meshlab(declared: Filter, values: Mapping[str, Any], ask: AskMeshLab, layer: Layer) -> dict[str, Any]:
    """The values of a built-in filter as pymeshlab takes them.

    Values that pymeshlab takes anyway stay what they are; `Length`, lengths as text, and colours, points and matrices as tuples
    are put in its classes.

    Raises:
        ParameterError: a length is a bare number or no length.
    """
    parameters = {p.name: p for p in declared.parameters}
    return {
        name: _for_meshlab(declared, parameters[name], value, ask, layer) if name in parameters else value
        for name, value in values.items()
    }


def _for_meshlab(declared: Filter, parameter: Parameter, value: Any, ask: AskMeshLab, layer: Layer) -> Any:
    if isinstance(parameter, Percentage) and not isinstance(value, pymeshlab.PercentageValue | pymeshlab.PureValue):
        length = value if isinstance(value, Length) else parameter.check(value)
        if length.unit == "percent" and 0.0 <= length.amount <= 100.0 and _is_of_diagonal(declared, parameter, ask, layer):
            return pymeshlab.PercentageValue(length.amount)
        return pymeshlab.PureValue(length.resolve(diagonal=layer.diagonal, mean_edge=lambda: layer.mean_edge))
    if isinstance(parameter, Color) and isinstance(value, tuple):
        return pymeshlab.Color(*value)
    if isinstance(parameter, Point | Matrix) and isinstance(value, tuple):
        return np.array(value, dtype=np.float64)
    return value


def _is_of_diagonal(declared: Filter, parameter: Parameter, ask: AskMeshLab, layer: Layer) -> bool:
    """Whether MeshLab's percentages of this parameter are of the bounding box's diagonal; of a few they are of something else."""
    zero, hundred = (
        ask(declared.python_name, **{parameter.name: pymeshlab.PercentageValue(p)})[parameter.name] for p in (0, 100)
    )
    return zero == 0.0 and math.isclose(hundred, layer.diagonal, rel_tol=1e-6)


def from_meshlab(
    declared: Filter, told: Mapping[str, Any], given: Mapping[str, Any], ask: AskMeshLab, layer: Layer
) -> dict[str, Any]:
    """The values that a built-in filter ran with, as declared values.

    Args:
        declared: the filter.
        told: the values that MeshLab ran with, as it tells them.
        given: the values of the user, as written; relative lengths stay relative, and numbers keep their digits. A default
            that is a part of the diagonal is relative, too, unless MeshLab remembers another one.
        ask: see `AskMeshLab`.
        layer: the mesh that the filter met.

    Returns:
        The values by name; one that no script can say (a camera, a number that is not finite) is absent.
    """
    values = {}
    for parameter in declared.parameters:
        if parameter.name not in told:
            continue
        try:
            values[parameter.name] = _from_meshlab(
                declared, parameter, told[parameter.name], given.get(parameter.name), ask, layer
            )
        except (ParameterError, IndexError):
            continue
    return values


def _from_meshlab(declared: Filter, parameter: Parameter, told: Any, given: Any, ask: AskMeshLab, layer: Layer) -> Any:
    if isinstance(parameter, Percentage):
        return parameter.check(_length_from_meshlab(declared, parameter, told, given, ask, layer))
    if isinstance(parameter, Enum):
        return parameter.check(parameter.choices[told])
    if isinstance(parameter, Color):
        return parameter.check((told.red(), told.green(), told.blue(), told.alpha()))
    if isinstance(parameter, Float):
        as_given = isinstance(given, float | int) and np.float32(given) == np.float32(told)
        # MeshLab clamps what has a slider, and its own defaults may lie a rounding outside.
        number = float(given) if as_given else shortest(told)
        return parameter.check(min(max(number, _or(parameter.minimum, number)), _or(parameter.maximum, number)))
    return parameter.check(told)


def _length_from_meshlab(declared: Filter, parameter: Percentage, told: float, given: Any, ask: AskMeshLab, layer: Layer) -> Any:
    """The length that a filter ran with, relative where the user said it so, or said nothing and the default is relative."""
    length = as_length(given)
    if isinstance(given, str | Length) or (isinstance(length, Length) and length.unit != "percent"):
        return length
    if isinstance(length, Length) and _is_of_diagonal(declared, parameter, ask, layer):
        return length
    default = parameter.default
    scales = isinstance(default, Length) and (default.unit == "percent" or default.amount == 0.0)
    if length is not None and scales and layer.diagonal > 0.0:  # percent of a range that is a part of the diagonal
        return Length(shortest(100.0 * told / layer.diagonal), "percent")
    if length is None and isinstance(default, Length) and default.unit == "percent":
        usual = default.resolve(diagonal=layer.diagonal, mean_edge=lambda: layer.mean_edge)
        if math.isclose(told, usual, rel_tol=1e-4):  # the table gives parts of the diagonal with five digits
            return default
    return Length(shortest(told))


def _or(bound: float | None, otherwise: float) -> float:
    return otherwise if bound is None else bound

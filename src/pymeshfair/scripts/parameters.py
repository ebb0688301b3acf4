"""The ``<Param>`` element: one parameter's value as MeshLab writes it, read strictly.

MeshLab drops a ``<Param>`` without a word when an attribute is missing or does not parse, and takes 0 when the type is of
another kind than the parameter. Here each of these is a problem.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .. import declaration
from ..declaration import Enum, Length, Parameter, String
from ..errors import ParameterError
from .expressions import expression_error, is_expression
from .param_types import WHOLE, Attributes, Complaint, is_number, parsed, type_complaints
from .problems import shortened


class _RefusedError(Exception):
    """The value cannot be read; carries the complaint."""

    def __init__(self, message: str, suggestion: str | None = None) -> None:
        super().__init__(message)
        self.complaint: Complaint = (message, suggestion)


def read_value(parameter: Parameter, attributes: Attributes, *, filter_name: str) -> tuple[Any, list[Complaint]]:
    """The value that the attributes of a ``<Param>`` give to the parameter, and everything that is wrong with them."""
    complaints = list(type_complaints(parameter, attributes))
    try:
        value = _reader(parameter)(parameter, attributes)
        if (
            isinstance(parameter, String)
            and is_expression(filter_name, parameter.xml_name)
            and (error := expression_error(value))
        ):
            raise _RefusedError(f"{shortened(value)!r} is no expression that MeshLab can evaluate: {error}")
    except _RefusedError as wrong:
        return None, [*complaints, wrong.complaint]
    return value, complaints


def _checked(parameter: Parameter, value: Any) -> Any:
    try:
        return parameter.check(parameter.from_number(value))
    except ParameterError as error:
        raise _RefusedError(str(error).removeprefix(f"parameter {parameter.name!r} ")) from None


def _text(attributes: Attributes, name: str = "value") -> str:
    try:
        return attributes[name]
    except KeyError:
        raise _RefusedError(f"the attribute {name} is missing") from None


def _whole(parameter: Parameter, text: str) -> int:
    if WHOLE.fullmatch(text) is None:
        number = parsed(text)
        suggestion = None if number is None or not number.is_integer() or abs(number) >= 2**31 else str(int(number))
        raise _RefusedError(f"takes {parameter.describe_allowed()}, got {shortened(text)!r}", suggestion)
    return int(text)


def _number(parameter: Parameter, text: str) -> float:
    number = parsed(text)
    if number is None:
        pointed = text.replace(",", ".")
        suggestion = pointed if pointed != text and is_number(pointed) else None
        raise _RefusedError(f"takes {parameter.describe_allowed()}, got {shortened(text)!r}", suggestion)
    return number


def _read_bool(parameter: Parameter, attributes: Attributes) -> bool:
    text = _text(attributes)
    if text not in ("true", "false"):
        meant = {"true": "true", "yes": "true", "1": "true", "false": "false", "no": "false", "0": "false"}
        note = "; MeshLab would read it as true" if text.lower() == "false" else ""
        raise _RefusedError(
            f"takes true or false in small letters, got {shortened(text)!r}{note}", meant.get(text.strip().lower())
        )
    return text == "true"


def _read_whole(parameter: Parameter, attributes: Attributes) -> Any:
    return _checked(parameter, _whole(parameter, _text(attributes)))


def _read_float(parameter: Parameter, attributes: Attributes) -> Any:
    text = _text(attributes)
    if "relative" in attributes:
        raise _RefusedError("relative= belongs to lengths alone, and this parameter is a plain number")
    return _checked(parameter, _number(parameter, text))


def _read_length(parameter: Parameter, attributes: Attributes) -> Any:
    length = Length(_number(parameter, _text(attributes)))
    if "relative" in attributes:
        text = attributes["relative"]
        try:
            length = Length.parse(text)
        except ParameterError:
            raise _RefusedError(f"relative= takes a length such as 1% or 0.5edge, got {shortened(text)!r}") from None
        if length.unit == "absolute":
            raise _RefusedError(f"relative= takes a length with a unit, got {shortened(text)!r}", f"{text}%")
    return _checked(parameter, length)


def _read_enum(parameter: Parameter, attributes: Attributes) -> Any:
    assert isinstance(parameter, Enum)
    text = _text(attributes)
    allowed = "; ".join(f"{i}: {shortened(word)}" for i, word in enumerate(parameter.choices))
    if WHOLE.fullmatch(text) is None:
        suggestion = str(parameter.choices.index(text)) if text in parameter.choices else None
        raise _RefusedError(f"takes the number of a choice ({allowed}), got {shortened(text)!r}", suggestion)
    index = int(text)
    if not 0 <= index < len(parameter.choices):
        raise _RefusedError(f"takes the number of a choice ({allowed}), got {shortened(text)!r}")
    word = attributes.get(f"enum_val{index}", parameter.choices[index])
    if word != parameter.choices[index] and word in parameter.choices:
        raise _RefusedError(
            f"says that {index} means {word!r}, but here it means {parameter.choices[index]!r}: "
            f"the script was written for other choices ({allowed})",
            str(parameter.choices.index(word)),
        )
    return parameter.choices[index]


def _read_point(parameter: Parameter, attributes: Attributes) -> Any:
    texts = [_text(attributes, name) for name in ("x", "y", "z")]
    return _checked(parameter, [_number(parameter, text) for text in texts])


def _read_color(parameter: Parameter, attributes: Attributes) -> Any:
    texts = [_text(attributes, name) for name in ("r", "g", "b", "a")]
    return _checked(parameter, [_whole(parameter, text) for text in texts])


def _read_matrix(parameter: Parameter, attributes: Attributes) -> Any:
    texts = [_text(attributes, f"val{i}") for i in range(16)]
    numbers = [_number(parameter, text) for text in texts]
    return _checked(parameter, [numbers[i : i + 4] for i in range(0, 16, 4)])


def _read_text(parameter: Parameter, attributes: Attributes) -> Any:
    return _checked(parameter, _text(attributes))


def _read_nothing(parameter: Parameter, attributes: Attributes) -> Any:
    raise _RefusedError("cannot be given in a script: MeshLab reads and writes no cameras there; leave the parameter out")


_READERS: Mapping[type[Parameter], Callable[[Parameter, Attributes], Any]] = {
    declaration.Bool: _read_bool,
    declaration.Int: _read_whole,
    declaration.Mesh: _read_whole,
    declaration.Float: _read_float,
    declaration.Percentage: _read_length,
    declaration.Enum: _read_enum,
    declaration.Point: _read_point,
    declaration.Direction: _read_point,
    declaration.Color: _read_color,
    declaration.Matrix: _read_matrix,
    declaration.String: _read_text,
    declaration.FileOpen: _read_text,
    declaration.FileSave: _read_text,
}


def _reader(parameter: Parameter) -> Callable[[Parameter, Attributes], Any]:
    return _READERS.get(type(parameter), _read_nothing)

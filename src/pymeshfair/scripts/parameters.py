"""The ``<Param>`` element: one parameter's value as MeshLab writes it, read strictly.

MeshLab drops a ``<Param>`` without a word when an attribute is missing or does not parse, and takes 0 when the type is of
another kind than the parameter. Here each of these is a problem.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from ..declaration import (
    Bool,
    Color,
    Direction,
    Enum,
    FileOpen,
    FileSave,
    Float,
    Int,
    Length,
    Matrix,
    Mesh,
    Parameter,
    Percentage,
    Point,
    String,
)
from ..errors import ParameterError
from .expressions import expression_error, is_expression
from .problems import shortened

Attributes = Mapping[str, str]
#: what is wrong, and what to write instead
Complaint = tuple[str, "str | None"]

_NUMBERS = frozenset({"RichFloat", "RichDynamicFloat", "RichAbsPerc"})
_POINTS = frozenset({"RichPosition", "RichDirection"})
#: the types that MeshLab reads into the same kind of value, by the parameter's own type
_ACCEPTED: Mapping[str, frozenset[str]] = {
    "RichFloat": _NUMBERS,
    "RichDynamicFloat": _NUMBERS,
    "RichAbsPerc": _NUMBERS,
    "RichEnum": frozenset({"RichEnum", "RichInt"}),
    "RichMesh": frozenset({"RichMesh", "RichInt"}),
    "RichPosition": _POINTS,
    "RichDirection": _POINTS,
    "RichOpenFile": frozenset({"RichOpenFile", "RichString"}),
    "RichSaveFile": frozenset({"RichSaveFile", "RichString"}),
}
#: the attributes that MeshLab needs to keep a parameter of that type, and whether each is a whole number
_REQUIRED: Mapping[str, Mapping[str, bool]] = {
    "RichDynamicFloat": {"min": False, "max": False},
    "RichAbsPerc": {"min": False, "max": False},
    "RichEnum": {"enum_cardinality": True},
    "RichOpenFile": {"exts_cardinality": True},
}
_OLD_TYPES = frozenset({"RichPoint3f"})
#: MeshLab allocates as many words as a script announces
_MOST_CHOICES = 1000

_WHOLE = re.compile(r"\s*[+-]?[0-9]{1,20}\s*")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_MOST_DIGITS = 400


class _RefusedError(Exception):
    """A complaint on its way out of a reader of values."""

    def __init__(self, message: str, suggestion: str | None = None) -> None:
        super().__init__(message)
        self.complaint: Complaint = (message, suggestion)


def read_value(parameter: Parameter, attributes: Attributes, *, filter_name: str) -> tuple[Any, list[Complaint]]:
    """The value that the attributes of a ``<Param>`` give to the parameter, and everything that is wrong with them."""
    complaints = list(_type_complaints(parameter, attributes))
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


def _type_complaints(parameter: Parameter, attributes: Attributes) -> Iterator[Complaint]:
    written = attributes.get("type")
    if written is None:
        yield "the attribute type is missing; MeshLab would drop the parameter and take its default", parameter.xml_type
        return
    if written not in _ACCEPTED.get(parameter.xml_type, {parameter.xml_type}):
        if written in _OLD_TYPES:
            yield f"type {written!r} is an old name", parameter.xml_type
        else:
            yield (
                f"has the type {parameter.xml_type}, not {shortened(written)!r}; MeshLab would take 0 or the default",
                parameter.xml_type,
            )
        return
    for name, whole in _REQUIRED.get(written, {}).items():
        text = attributes.get(name)
        if text is None:
            yield f"the attribute {name} is missing; MeshLab would drop the parameter and take its default", None
        elif not (_is_count(text) if whole else _is_number(text)):
            needed = f"a whole number from 0 to {_MOST_CHOICES}" if whole else "a number"
            yield f"the attribute {name} must be {needed}, got {shortened(text)!r}", None


def _is_count(text: str) -> bool:
    return _WHOLE.fullmatch(text) is not None and 0 <= int(text) <= _MOST_CHOICES


def _is_number(text: str) -> bool:
    return _parsed(text) is not None


def _parsed(text: str) -> float | None:
    """The finite number that the text spells as MeshLab reads it, with blanks around it; None if it spells none."""
    if len(text) > _MOST_DIGITS or _NUMBER.fullmatch(text.strip()) is None:
        return None
    number = float(text)
    return number if math.isfinite(number) else None


def _checked(parameter: Parameter, value: Any) -> Any:
    try:
        return parameter.check(value)
    except ParameterError as error:
        raise _RefusedError(str(error).removeprefix(f"parameter {parameter.name!r} ")) from None


def _text(attributes: Attributes, name: str = "value") -> str:
    try:
        return attributes[name]
    except KeyError:
        raise _RefusedError(f"the attribute {name} is missing") from None


def _whole(parameter: Parameter, text: str) -> int:
    if _WHOLE.fullmatch(text) is None:
        number = _parsed(text)
        suggestion = None if number is None or not number.is_integer() or abs(number) >= 2**31 else str(int(number))
        raise _RefusedError(f"takes {parameter.describe_allowed()}, got {shortened(text)!r}", suggestion)
    return int(text)


def _number(parameter: Parameter, text: str) -> float:
    number = _parsed(text)
    if number is None:
        pointed = text.replace(",", ".")
        suggestion = pointed if pointed != text and _is_number(pointed) else None
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
    if _WHOLE.fullmatch(text) is None:
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
    Bool: _read_bool,
    Int: _read_whole,
    Mesh: _read_whole,
    Float: _read_float,
    Percentage: _read_length,
    Enum: _read_enum,
    Point: _read_point,
    Direction: _read_point,
    Color: _read_color,
    Matrix: _read_matrix,
    String: _read_text,
    FileOpen: _read_text,
    FileSave: _read_text,
}


def _reader(parameter: Parameter) -> Callable[[Parameter, Attributes], Any]:
    return _READERS.get(type(parameter), _read_nothing)

"""One documented method of `MeshSet` for every filter that a plugin declares."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeAlias

import pymeshlab

from .. import declaration
from ..declaration import Bool, Enum, Filter, Length, Parameter

#: What may be said for a length: ``"1%"`` of the diagonal, ``"0.5edge"``, ``"0.3"`` in mesh units, or an object that says so.
LengthLike: TypeAlias = str | Length | pymeshlab.PercentageValue | pymeshlab.PureValue

_WIDTH = 120


def filter_method(known: Filter) -> Callable[..., dict[str, Any] | None]:
    """The method that applies the filter, with its signature and its documentation."""

    def method(self: Any, **parameters: Any) -> dict[str, Any] | None:
        # pymeshlab's own methods give nothing rather than an empty dictionary
        return self.apply_filter(known.python_name, **parameters) or None

    method.__name__ = known.python_name
    method.__qualname__ = f"MeshSet.{known.python_name}"
    method.__module__ = "pymeshfair.meshset"
    method.__doc__ = method_docstring(known)
    method.__signature__ = _signature(known)  # type: ignore[attr-defined]
    return method


def _signature(known: Filter) -> inspect.Signature:
    this = inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)
    others = [
        inspect.Parameter(p.name, inspect.Parameter.KEYWORD_ONLY, default=shown_default(p), annotation=_annotation(p))
        for p in known.parameters
    ]
    return inspect.Signature([this, *others], return_annotation=dict[str, Any] | None)


def _annotation(parameter: Parameter) -> Any:
    if isinstance(parameter, Enum):
        return Literal[parameter.choices]
    return next(kind for of, (kind, _) in _TYPES.items() if isinstance(parameter, of))


#: the type of each kind of parameter, and how it is written in a stub; the first kind that fits counts
_TYPES: dict[type[Parameter], tuple[Any, str]] = {
    declaration.Bool: (bool, "bool"),
    declaration.Int: (int, "int"),
    declaration.Float: (float, "float"),
    declaration.Percentage: (LengthLike, "LengthLike"),
    declaration.FileOpen: (str, "str"),
    declaration.FileSave: (str, "str"),
    declaration.String: (str, "str"),
    declaration.Mesh: (int, "int"),
    declaration.Point: (Sequence[float], "Sequence[float]"),
    declaration.Color: (Sequence[int], "Sequence[int]"),
    declaration.Matrix: (Sequence[Sequence[float]], "Sequence[Sequence[float]]"),
    Parameter: (Any, "Any"),
}


def annotation_text(parameter: Parameter) -> str:
    """The type of a parameter as a stub says it."""
    if isinstance(parameter, Enum):
        return f"Literal[{', '.join(map(repr, parameter.choices))}]"
    return next(text for of, (_, text) in _TYPES.items() if isinstance(parameter, of))


def shown_default(parameter: Parameter) -> Any:
    """The default as a user would say it: a length as text."""
    if isinstance(parameter.default, Length):
        return length_text(parameter.default)
    return parameter.default


def length_text(length: Length) -> str:
    """A length in its shortest form: ``1%``, ``0.5edge``, ``0.3``."""
    amount = repr(length.amount)
    return amount.removesuffix(".0") + str(length).removeprefix(amount)


def method_docstring(known: Filter) -> str:
    """The description, every parameter with what it takes, and the references, in Google style."""
    parts = [_rewrapped(paragraph) for paragraph in known.info.strip().split("\n\n")]
    if known.parameters:
        parts.append("Args:\n" + "\n".join(_described(p) for p in known.parameters))
    parts.append(f"Returns:\n{_indented('What the filter reports, by name; None if it reports nothing.', 4)}")
    if known.references:
        parts.append(f"References:\n{_indented(', '.join(f'[{key}]' for key in known.references), 4)}")
    parts.append(f"In scripts: {known.name!r}.")
    return "\n\n".join(parts)


def _rewrapped(paragraph: str) -> str:
    """The paragraph with lines short enough for an indented docstring; one that is laid out by hand stays as it is."""
    lines = paragraph.splitlines()
    by_hand = any(not line[:1].isalpha() for line in lines)
    return paragraph if by_hand or max(map(len, lines), default=0) <= _WIDTH else _indented(paragraph, 0)


def _described(parameter: Parameter) -> str:
    takes = "" if isinstance(parameter, Bool | Enum) else f" Takes {parameter.describe_allowed()}."  # their type says it all
    return _indented(f"{parameter.name}: {parameter.help}{takes}", 4, 8)


def _indented(text: str, first: int, rest: int | None = None) -> str:
    return textwrap.fill(
        " ".join(text.split()),
        width=_WIDTH,
        initial_indent=" " * first,
        subsequent_indent=" " * (first if rest is None else rest),
        break_long_words=False,
        break_on_hyphens=False,
    )

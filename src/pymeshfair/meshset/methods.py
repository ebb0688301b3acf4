"""Finds, lists and prints filters by functions with the same names as in pymeshlab; makes documented methods for `MeshSet`."""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import AUTO, Bool, Color, Enum, Filter, Length, Matrix, Parameter, Percentage, Point, Shot
from ..errors import UnknownNameError
from ..meshlab.base import UnknownFilterError
from ..registry import all_filters, custom_filters, find_filter

if TYPE_CHECKING:
    from . import pymeshlab_classes as classes
else:
    import pymeshlab as classes

#: A length: ``"1%"`` of the diagonal, ``"0.5edge"``, ``"0.3"`` in mesh units, or an object of these classes.
LengthLike: TypeAlias = str | Length | classes.PercentageValue | classes.PureValue

PointLike: TypeAlias = Sequence[float] | NDArray[np.float64]
MatrixLike: TypeAlias = Sequence[Sequence[float]] | NDArray[np.float64]
ColorLike: TypeAlias = Sequence[int] | classes.Color

#: by parameter type, the types that a method takes; the function of a filter receives `Parameter.python_type`
_LIKE: dict[type[Parameter], Any] = {Percentage: LengthLike, Point: PointLike, Color: ColorLike, Matrix: MatrixLike, Shot: Any}
_WIDTH = 120
_FILTER_LIST = "https://pymeshlab.readthedocs.io/en/latest/filter_list.html"


def filter_list() -> list[str]:
    """Returns the Python names of all filters, of MeshLab and of plugins, sorted."""
    return sorted({*pymeshlab.filter_list(), *(declared.python_name for declared in custom_filters())})


def print_filter_list() -> None:
    """Prints the Python names of all filters."""
    print("MeshSet class - list of filter names:")
    for name in filter_list():
        print(f"\t{name}")


def print_filter_parameter_list(filter_name: str) -> None:
    """Prints the parameters of a filter with allowed values and defaults; raises `UnknownFilterError` for an unknown name."""
    declared = known_filter(filter_name)
    if declared is None:
        pymeshlab.print_filter_parameter_list(filter_name)
        return
    print(f"{declared.python_name} filter - list of parameter names:")
    for parameter in declared.parameters:
        default = "depends on the mesh" if parameter.default is None else repr(shown_default(parameter))
        print(f"\t{parameter.name} : {parameter.describe_allowed()} = {default}")
    if not declared.parameters:
        print("\tNone.")


def search(words: str) -> None:
    """Prints the filters with all words in their name or description; filters with more of them in the name come first."""
    searched = re.findall(r"[a-z0-9]+", words.lower())

    def text(declared: Filter) -> str:
        return f"{declared.python_name} {declared.name} {declared.info}".lower()

    matches = [declared for declared in all_filters() if searched and all(word in text(declared) for word in searched)]
    matches.sort(key=lambda declared: -sum(word in f"{declared.python_name} {declared.name}".lower() for word in searched))
    for declared in matches:
        print(f"{declared.python_name} : {declared.summary or declared.name}")


def known_filter(name: str) -> Filter | None:
    """Finds a filter by Python or menu name, or raises `UnknownFilterError`; None for a filter that only pymeshlab has."""
    try:
        return find_filter(name)
    except UnknownNameError as error:
        if name in pymeshlab.filter_list():
            return None
        raise UnknownFilterError(str(error), suggestion=error.suggestion, cause=error.cause) from None


def filter_method(declared: Filter) -> Callable[..., dict[str, Any] | None]:
    """Makes the method that applies a filter."""

    def method(self: Any, **parameters: Any) -> dict[str, Any] | None:
        return self.apply_filter(declared.python_name, **parameters) or None  # as methods of pymeshlab do for no report

    method.__name__ = declared.python_name
    method.__qualname__ = f"MeshSet.{declared.python_name}"
    method.__module__ = "pymeshfair.meshset"
    method.__doc__ = method_docstring(declared)
    method.__signature__ = _signature(declared)  # type: ignore[attr-defined]
    return method


def _signature(declared: Filter) -> inspect.Signature:
    this = inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)
    kind = inspect.Parameter.KEYWORD_ONLY
    others = [  # the default is an Ellipsis if MeshLab computes it from the mesh
        inspect.Parameter(p.name, kind, default=... if p.default is None else shown_default(p), annotation=_annotation(p))
        for p in declared.parameters
    ]
    return inspect.Signature([this, *others], return_annotation=dict[str, Any] | None)


def _annotation(parameter: Parameter) -> Any:
    if isinstance(parameter, Enum):
        return Literal[parameter.choices]
    kind = next((like for of, like in _LIKE.items() if isinstance(parameter, of)), parameter.python_type)
    return kind if parameter.automatic is None or kind is LengthLike else kind | Literal[AUTO]


def shown_default(parameter: Parameter) -> Any:
    """Returns the default as a user writes it: a length is a text."""
    return length_text(parameter.default) if isinstance(parameter.default, Length) else parameter.default


def length_text(length: Length) -> str:
    """Returns the shortest text of a length: ``1%``, ``0.5edge``, ``0.3``."""
    amount = repr(length.amount)
    return amount.removesuffix(".0") + str(length).removeprefix(amount)


def method_docstring(declared: Filter) -> str:
    """Returns a docstring in Google style: the description, the parameters with allowed values, and the references."""
    where = f"Menus: {declared.menus}. What it does: {_FILTER_LIST}#{declared.python_name}"
    info = declared.info.strip() or f"MeshLab's filter {declared.name!r}.\n\n{where}"
    parts = [_rewrapped(paragraph) for paragraph in info.split("\n\n")]
    if declared.parameters:
        parts.append("Args:\n" + "\n".join(_described(p) for p in declared.parameters))
    parts.append(f"Returns:\n{_indented('What the filter reports, by name; None if it reports nothing.', 4)}")
    if declared.references:
        parts.append(f"References:\n{_indented(', '.join(f'[{key}]' for key in declared.references), 4)}")
    if not declared.is_builtin:
        parts.append(f"In scripts: {declared.name!r}.")
    return "\n\n".join(parts)


def _rewrapped(paragraph: str) -> str:
    """Wraps a paragraph with lines over `_WIDTH`, unless one of its lines does not begin with a letter, as in lists."""
    lines = paragraph.splitlines()
    by_hand = any(not line[:1].isalpha() for line in lines)
    return paragraph if by_hand or max(map(len, lines), default=0) <= _WIDTH else _indented(paragraph, 0)


def _described(parameter: Parameter) -> str:
    sentences = [parameter.help or f"{parameter.xml_name!r} in scripts."]
    if not isinstance(parameter, Bool | Enum):  # their type shows the allowed values
        sentences.append(f"Takes {parameter.describe_allowed()}.")
    if parameter.default is None and not parameter.help:
        sentences.append("By default MeshLab chooses it for the mesh.")
    return _indented(f"{parameter.name}: {' '.join(sentences)}", 4, 8)


def _indented(text: str, first: int, rest: int | None = None) -> str:
    return textwrap.fill(
        " ".join(text.split()),
        width=_WIDTH,
        initial_indent=" " * first,
        subsequent_indent=" " * (first if rest is None else rest),
        break_long_words=False,
        break_on_hyphens=False,
    )

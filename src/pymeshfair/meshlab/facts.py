"""Facts about MeshLab's built-in filters, kept in ``filters.json``: names, kinds, defaults, bounds, choices.

The table is generated from an installed pymeshlab (``tools/meshlab_table.py``), holds no help texts and names its version.
`differences_from_installed` says where the pymeshlab that is installed here differs.
"""

from __future__ import annotations

import functools
import importlib.resources
import json
import keyword
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from .. import declaration
from ..declaration import Arity, Enum, Filter, FilterClass, Length, MeshElement, Parameter, Percentage

if TYPE_CHECKING:
    from .survey import InstalledParameter

#: by its name in the table, the class of a parameter and the kinds that pymeshlab's own list calls it
_KINDS: Mapping[str, tuple[type[Parameter], tuple[str, ...]]] = {
    "Bool": (declaration.Bool, ("bool",)),
    "Color": (declaration.Color, ("Color",)),
    "Direction": (declaration.Direction, ("numpy.ndarray[numpy.float64[3]]",)),
    "Enum": (declaration.Enum, ("str",)),
    "FileOpen": (declaration.FileOpen, ("str",)),
    "FileSave": (declaration.FileSave, ("str",)),
    "Float": (declaration.Float, ("float", "float (bounded)")),
    "Int": (declaration.Int, ("int",)),
    "Matrix": (declaration.Matrix, ("numpy.ndarray[numpy.float64[4, 4]]",)),
    "Mesh": (declaration.Mesh, ("int",)),
    "Percentage": (declaration.Percentage, ("PercentageValue",)),
    "Point": (declaration.Point, ("numpy.ndarray[numpy.float64[3]]",)),
    "Shot": (declaration.Shot, ("Shotf [still unsupported]",)),
    "String": (declaration.String, ("str",)),
}


@functools.cache
def meshlab_filters() -> tuple[Filter, ...]:
    """MeshLab's filters, in the order of their Python names.

    A default is None where MeshLab computes it for the mesh at hand, as is a bound. Bounds of whole numbers are ours: MeshLab
    has none, and hangs or dies on a negative count.
    """
    return tuple(_filter(*row) for row in table("filters")["filters"])


def table_version() -> str:
    """The version of pymeshlab that the table describes."""
    return str(table("filters")["version"])


def differences_from_installed() -> list[str]:
    """The differences of the installed pymeshlab from the table, one sentence each; empty if there are none.

    It takes about half a second, in a process of its own.

    Raises:
        SurveyError: pymeshlab cannot be asked, for example because a system library is missing.
    """
    from .survey import survey_installed

    installed = survey_installed()
    differences = []
    if installed.version != table_version():
        differences.append(f"pymeshlab {installed.version} is installed; the table of its filters is of {table_version()}")
    expected = {row[0]: row[-1] for row in table("filters")["filters"]}
    differences += [f"filter {name!r} is not in the table" for name in sorted(installed.filters.keys() - expected.keys())]
    for name, rows in expected.items():
        if name not in installed.filters:
            differences.append(f"filter {name!r} is not installed")
        else:
            differences += [f"filter {name!r}: {text}" for text in _parameter_differences(rows, installed.filters[name])]
    return differences


@functools.cache
def table(name: str) -> dict[str, Any]:
    """The facts of that name in this folder."""
    facts: dict[str, Any] = json.loads(importlib.resources.files(__package__).joinpath(f"{name}.json").read_text("utf-8"))
    return facts


def _filter(
    python_name: str, name: str, classes: int, requires: int, changes: int, arity: int, parameters: list[list[Any]]
) -> Filter:
    return Filter(
        python_name=python_name,
        name=name,
        classes=FilterClass(classes),
        requires=MeshElement(requires),
        changes=MeshElement(changes),
        arity=Arity(arity),
        parameters=tuple(_parameter(*row) for row in parameters),
    )


def _parameter(xml_name: str, kind: str, default: Any, *more: Any) -> Parameter:
    names: dict[str, Any] = {"name": python_name(xml_name), "label": xml_name, "xml_name": xml_name}
    if kind == "Enum":
        choices = tuple(more[0])
        return Enum(**names, default=None if default is None else choices[default], choices=choices)
    if kind == "Percentage":
        return Percentage(**names, default=None if default is None else Length.parse(default), minimum=None)
    if isinstance(default, list):
        default = tuple(tuple(x) if isinstance(x, list) else x for x in default)
    if more:
        names |= {"minimum": more[0], "maximum": more[1]}
    return _KINDS[kind][0](**names, default=default)


def python_name(xml_name: str) -> str:
    """The Python name that pymeshlab derives from MeshLab's name of a parameter: ``lambda`` gives ``lambda_``."""
    name = re.sub(r"[ /-]", "_", re.sub(r"[().,'\":+]", "", xml_name)).lower()
    return f"{name}_" if keyword.iskeyword(name) else name


def _parameter_differences(rows: list[list[Any]], installed: Sequence[InstalledParameter]) -> Iterator[str]:
    names, installed_names = [python_name(row[0]) for row in rows], [p.name for p in installed]
    if names != installed_names:
        yield f"has the parameters {', '.join(installed_names)}; in the table {', '.join(names)}"
        return
    for (_, kind, default, *more), parameter in zip(rows, installed, strict=True):
        say = f"parameter {parameter.name!r} has the"
        if parameter.kind not in _KINDS[kind][1] or (kind == "Float" and bool(more) != (parameter.bounds is not None)):
            yield f"{say} kind {parameter.kind!r}; in the table it is {kind}"
        elif not _same_default(kind, default, parameter.default):
            yield f"{say} default {parameter.default!r}; in the table {default!r}"
        elif kind == "Enum" and more[0] != list(parameter.choices):
            yield f"{say} choices {', '.join(parameter.choices)}; in the table {', '.join(more[0])}"
        elif kind == "Float" and more and None not in more and more != list(parameter.bounds or ()):
            yield f"{say} bounds {parameter.bounds}; in the table {more}"


def _same_default(kind: str, default: Any, installed: Any) -> bool:
    if default is None:
        return True  # it depends on the mesh or on the machine
    if kind != "Percentage":
        return bool(default == installed)
    from .survey import CUBE_DIAGONAL

    length = Length.parse(default).resolve(diagonal=CUBE_DIAGONAL, mean_edge=lambda: math.nan)
    return math.isclose(length, installed, rel_tol=1e-4)  # the table gives parts of the diagonal with five digits

"""Facts about MeshLab's built-in filters, kept in ``meshlab_filters.json``: names, types, defaults, bounds, choices."""

from __future__ import annotations

import functools
import importlib.resources
import json
import keyword
import re
from collections.abc import Mapping
from typing import Any

from .declaration import (
    Arity,
    Bool,
    Color,
    Direction,
    Enum,
    FileOpen,
    FileSave,
    Filter,
    FilterClass,
    Float,
    Int,
    Length,
    Matrix,
    Mesh,
    MeshElement,
    Parameter,
    Percentage,
    Point,
    Shot,
    String,
)

_KINDS: Mapping[str, type[Parameter]] = {
    kind.__name__: kind
    for kind in (Bool, Color, Direction, Enum, FileOpen, FileSave, Float, Int, Matrix, Mesh, Percentage, Point, Shot, String)
}


@functools.cache
def meshlab_filters() -> tuple[Filter, ...]:
    """MeshLab's filters, in the order of their Python names."""
    table = json.loads(importlib.resources.files(__package__).joinpath("meshlab_filters.json").read_text("utf-8"))
    return tuple(_filter(*row) for row in table["filters"])


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
    if kind == "Float" and more:
        return Float(**names, default=default, minimum=more[0], maximum=more[1])
    if kind == "Enum":
        choices = tuple(more[0])
        return Enum(**names, default=None if default is None else choices[default], choices=choices)
    if kind == "Percentage":
        return Percentage(**names, default=None if default is None else Length.parse(default), minimum=None)
    if isinstance(default, list):
        default = tuple(tuple(x) if isinstance(x, list) else x for x in default)
    return _KINDS[kind](**names, default=default)


def python_name(xml_name: str) -> str:
    """The Python name that PyMeshLab derives from MeshLab's name of a parameter: ``lambda`` gives ``lambda_``."""
    name = re.sub(r"[ /-]", "_", re.sub(r"[().,'\":+]", "", xml_name)).lower()
    return f"{name}_" if keyword.iskeyword(name) else name

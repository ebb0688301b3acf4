"""Facts about MeshLab's built-in filters, kept in ``filters.json``: names, kinds, defaults, bounds, choices.

The table is generated from an installed pymeshlab (``tools/meshlab_table.py``), holds no help texts and names its version.
"""

from __future__ import annotations

import functools
import importlib.resources
import json
import keyword
import re
from typing import Any

from .. import declaration
from ..declaration import Arity, Enum, Filter, FilterClass, Length, MeshElement, Parameter, Percentage


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
    """One sentence for each name of a filter that pymeshlab or the table lacks, and for each filter whose parameters differ."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.create_cube()
    meshes.compute_scalar_by_function_per_face(q="0")  # three filters list no parameters without it
    installed = {name: set(meshes.filter_parameter_values(name)) for name in pymeshlab.filter_list()}
    expected = {declared.python_name: {p.name for p in declared.parameters} for declared in meshlab_filters()}
    differences = [f"filter {name!r} is not in the table" for name in sorted(installed.keys() - expected.keys())]
    differences += [f"filter {name!r} is not installed" for name in sorted(expected.keys() - installed.keys())]
    for name in sorted(expected.keys() & installed.keys()):
        for others, where in ((installed[name] - expected[name], "the table"), (expected[name] - installed[name], "pymeshlab")):
            if others:
                differences.append(f"filter {name!r} has parameters that {where} lacks: {', '.join(sorted(others))}")
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
    of_kind: type[Parameter] = getattr(declaration, kind)
    return of_kind(**names, default=default)


def python_name(xml_name: str) -> str:
    """The Python name that pymeshlab derives from MeshLab's name of a parameter: ``lambda`` gives ``lambda_``."""
    name = re.sub(r"[ /-]", "_", re.sub(r"[().,'\":+]", "", xml_name)).lower()
    return f"{name}_" if keyword.iskeyword(name) else name

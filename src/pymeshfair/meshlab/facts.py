"""Facts about MeshLab's filters, from JSON files: today's, those of older versions, and those with another result in each run.

``tools/meshlab_table.py`` generates ``filters.json``: names, kinds, defaults, bounds and choices, and the version of pymeshlab.
"""

from __future__ import annotations

import functools
import importlib.resources
import json
import keyword
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from .. import declaration
from ..declaration import Arity, Enum, Filter, FilterClass, Length, MeshElement, Parameter, Percentage
from ..errors import plain_name


@functools.cache
def meshlab_filters() -> tuple[Filter, ...]:
    """Returns MeshLab's filters. Defaults and bounds are None if MeshLab computes them from the mesh.

    The bounds of whole numbers are ours: MeshLab has none, and hangs or crashes on a negative count.
    """
    return tuple(_filter(*row) for row in table("filters")["filters"])


def table_version() -> str:
    """Returns the version of pymeshlab that the table describes."""
    return str(table("filters")["version"])


def differences_from_installed() -> list[str]:
    """Returns a sentence for each filter that pymeshlab or the table lacks, and for each filter whose parameters differ."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.create_cube()
    meshes.compute_scalar_by_function_per_face(q="0")  # without face scalars three filters raise an error
    installed = {name: set(meshes.filter_parameter_values(name)) for name in pymeshlab.filter_list()}
    expected = {declared.python_name: {p.name for p in declared.parameters} for declared in meshlab_filters()}
    differences = differing_names(installed, expected)
    for name in sorted(expected.keys() & installed.keys()):
        for others, where in ((installed[name] - expected[name], "the table"), (expected[name] - installed[name], "pymeshlab")):
            if others:
                differences.append(f"filter {name!r} has parameters that {where} lacks: {', '.join(sorted(others))}")
    return differences


def differing_names(installed: Mapping[str, Any], expected: Mapping[str, Any]) -> list[str]:
    """Returns a sentence for each filter name that is a key of only one of the mappings."""
    differences = [f"filter {name!r} is not in the table" for name in sorted(installed.keys() - expected.keys())]
    return differences + [f"filter {name!r} is not installed" for name in sorted(expected.keys() - installed.keys())]


@functools.cache
def table(name: str) -> dict[str, Any]:
    """Reads the JSON file with this name in the folder of this module."""
    facts: dict[str, Any] = json.loads(importlib.resources.files(__package__).joinpath(f"{name}.json").read_text("utf-8"))
    return facts


def _filter(method: str, name: str, classes: int, requires: int, changes: int, arity: int, parameters: list[list[Any]]) -> Filter:
    kinds: dict[str, Any] = {"classes": FilterClass(classes), "requires": MeshElement(requires), "changes": MeshElement(changes)}
    return Filter(
        python_name=method, name=name, **kinds, arity=Arity(arity), parameters=tuple(_parameter(*row) for row in parameters)
    )


def _parameter(xml_name: str, kind: str, default: Any, *choices_or_bounds: Any) -> Parameter:
    names: dict[str, Any] = {"name": python_name(xml_name), "label": xml_name, "xml_name": xml_name}
    if kind == "Enum":
        choices = tuple(choices_or_bounds[0])
        return Enum(**names, default=None if default is None else choices[default], choices=choices)
    if kind == "Percentage":
        return Percentage(**names, default=None if default is None else Length.parse(default), minimum=None)
    if isinstance(default, list):
        default = tuple(tuple(x) if isinstance(x, list) else x for x in default)
    if choices_or_bounds:
        names |= {"minimum": choices_or_bounds[0], "maximum": choices_or_bounds[1]}
    of_kind: type[Parameter] = getattr(declaration, kind)
    return of_kind(**names, default=default)


def python_name(xml_name: str) -> str:
    """Returns the Python name that pymeshlab derives from MeshLab's name of a parameter: ``lambda`` gives ``lambda_``."""
    name = re.sub(r"[ /-]", "_", re.sub(r"[().,'\":+]", "", xml_name)).lower()
    return f"{name}_" if keyword.iskeyword(name) else name


@dataclass(frozen=True)
class Former:
    """Today's form of an old filter, or of the old parameters of a filter that kept its name. Values are texts, as in scripts."""

    now: str | None  # MeshLab's name of the filter today; None if it is gone or became several filters
    #: for a filter that became several: today's name, by the old parameter and its value; a missing value counts as 0
    splits: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    idle: bool = False  # the old filter never changed a mesh, so its steps can be left out
    invented: bool = False  # the name was never MeshLab's; `now` is the filter that scripts with this name mean
    sets: Mapping[str, str] = field(default_factory=dict)  # values by parameter, for parameters that the script does not give
    renames: Mapping[str, str] = field(default_factory=dict)  # new names of parameters, by old name
    #: by old parameter and old value (``*`` for any), the equivalent values by today's parameters, in which ``*`` stands for
    #: the old value and ``-*`` for its negative
    turns: Mapping[str, Mapping[str, Mapping[str, str]]] = field(default_factory=dict)
    #: removed parameters, each with the old value whose effect MeshLab has today; None if the value never mattered
    drops: Mapping[str, str | None] = field(default_factory=dict)
    #: removed parameters without an equivalent today, each with the change that this causes
    loses: Mapping[str, str] = field(default_factory=dict)
    #: parameters that older versions lacked, whose default today does something else. By name: the ``value`` with the old effect,
    #: a sentence on the difference (``meaning``), and in ``if`` the ``PARAMETER=VALUE`` without which there is no difference
    newer: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    relabelled: Sequence[str] = ()  # parameters whose choices have new labels and the same numbers
    #: which layer is current after the filter: ``"left"``: in old versions the layer that was current before, today the result;
    #: ``"current"``: the result in every version
    layers: Literal["left", "current", ""] = ""
    note: str = ""  # the change of the result, or advice when the filter is gone; empty if the meaning is the same

    def today(self, values: Mapping[str, str]) -> str | None:
        """Returns the filter's name in MeshLab today, which may depend on the values of old parameters; None if it is gone."""
        for parameter, names in self.splits.items():
            return names.get(values.get(parameter, "0").strip())
        return self.now

    def turned(self, parameter: str, value: str) -> Mapping[str, str] | None:
        """Returns today's equivalent of a value of an old parameter, as values by parameter; None if `turns` has no entry."""
        cases = self.turns.get(parameter, {})
        equivalents = cases.get(value.strip().lower(), cases.get("*"))
        stands_for = {"*": value, "-*": f"-{value.strip()}".removeprefix("--")}
        return None if equivalents is None else {name: stands_for.get(text, text) for name, text in equivalents.items()}


def former_filter(old: str) -> Former | None:
    """Returns today's form of the filter with an old name, compared by `plain_name`; None if it is not in the table."""
    return former_filters().get(old) or _by_plain_name().get(plain_name(old))


def former_parameters(name: str) -> Former:
    """Returns today's form of the old parameters of a filter, given its name today."""
    return parameter_facts().get(name, Former(now=name))


@functools.cache
def parameter_facts() -> Mapping[str, Former]:
    """Reads today's form of old parameters, by today's name of the filter."""
    return {name: Former(now=name, **entry) for name, entry in table("former_filters")["parameters"].items()}


@functools.cache
def former_filters() -> Mapping[str, Former]:
    """Reads today's form of filters, by old name."""
    return {name: Former(**entry) for name, entry in table("former_filters")["filters"].items()}


@functools.cache
def _by_plain_name() -> Mapping[str, Former]:
    """Maps old names in plain form to entries, without those whose plain form is still today's: these are not old."""
    plain = {name: plain_name(name) for name in former_filters()}
    return {plain[name]: former for name, former in former_filters().items() if plain[name] != plain_name(former.now or "")}

"""Facts about filters and parameters of older MeshLab versions and today's, kept in ``former_filters.json``."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from .facts import table


@dataclass(frozen=True)
class Former:
    """Today's form of an old filter, or of the parameters of one that kept its name. Values are texts as scripts have them."""

    now: str | None  # MeshLab's name of the filter today; None if it is gone, or became several
    #: by one of its parameters and its value, the names of the filters that it became; the value 0 is the default
    splits: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    idle: bool = False  # it never changed a mesh, so that a step can be left out
    invented: bool = False  # the name was never MeshLab's; `now` is what such scripts mean
    sets: Mapping[str, str] = field(default_factory=dict)  # values to give, by parameter, unless the script gives one
    renames: Mapping[str, str] = field(default_factory=dict)  # new names of parameters, by the old
    #: by old parameter and value (``*`` for any), the values that mean the same today; ``*`` stands for the old value and ``-*``
    #: for minus the old value
    turns: Mapping[str, Mapping[str, Mapping[str, str]]] = field(default_factory=dict)
    #: parameters that are gone, with the value that does what MeshLab does today; None if no value matters
    drops: Mapping[str, str | None] = field(default_factory=dict)
    #: parameters that are gone and whose work no value does today, with what changes
    loses: Mapping[str, str] = field(default_factory=dict)
    relabelled: Sequence[str] = ()  # parameters whose choices have other words today, while their numbers do what they did
    #: ``"left"`` if the filter once left the current layer alone and its result is current today; ``"current"`` if its result was
    #: current in every version
    layers: Literal["left", "current", ""] = ""
    note: str = ""  # the change of the result, or advice when the filter is gone; empty if the meaning is the same

    def today(self, values: Mapping[str, str]) -> str | None:
        """MeshLab's name today of a filter with these values, by old parameter; None if it is gone."""
        for parameter, names in self.splits.items():
            return names.get(values.get(parameter, "0").strip())
        return self.now

    def turned(self, parameter: str, value: str) -> Mapping[str, str] | None:
        """The values that mean today the same as a value of an old parameter; None of a parameter without such a table."""
        cases = self.turns.get(parameter)
        if cases is None:
            return None
        meant = cases.get(value.strip().lower(), cases.get("*"))
        stands_for = {"*": value, "-*": f"-{value.strip()}".removeprefix("--")}
        return None if meant is None else {name: stands_for.get(text, text) for name, text in meant.items()}


def former_filter(old: str) -> Former | None:
    """Today's form of the filter of that old name; None if it is in no table.

    Capital letters and blanks do not count: MeshLab changed those of many names on the way.
    """
    return former_filters().get(old) or _by_plain_name().get(_plain(old))


def former_parameters(name: str) -> Former:
    """Today's form of the parameters of a filter, by its name today."""
    return parameter_facts().get(name, Former(now=name))


@functools.cache
def parameter_facts() -> Mapping[str, Former]:
    """Today's form of parameters, by today's name of their filter."""
    return {name: Former(now=name, **entry) for name, entry in table("former_filters")["parameters"].items()}


@functools.cache
def former_filters() -> Mapping[str, Former]:
    """Today's form of filters, by their old name."""
    return {name: Former(**entry) for name, entry in table("former_filters")["filters"].items()}


@functools.cache
def _by_plain_name() -> Mapping[str, Former]:
    """Those that changed more than capital letters and blanks, so that no name of today is among them."""
    return {_plain(name): former for name, former in former_filters().items() if _plain(name) != _plain(former.now or "")}


def _plain(name: str) -> str:
    return " ".join(name.casefold().split())

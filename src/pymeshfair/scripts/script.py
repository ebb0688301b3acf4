"""A filter script in memory: its elements as written, and filters with checked values, in the order in which they run.

Settings are values of a recipe that have a name, which one place sets for all the steps that use them. A
``<setting name="detail_size" default="6edge" unit="length" description="..."/>`` stands under ``<FilterScript>``, and each
``<Param ... setting="detail_size">`` that takes its value says so. MeshLab looks at neither: it runs the values of the steps,
which are those of the defaults.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..declaration import Filter, Length, nearest
from ..registry import find_filter
from .guards import NO_GUARDS, Guards
from .problems import Problem, shortened

#: the attributes of a ``<setting>``, in the order in which they are written
SETTING_ATTRIBUTES = ("name", "default", "unit", "description")
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,79}")


@dataclass(frozen=True)
class Setting:
    """A value of a recipe that has a name."""

    name: str  # by which it is set, ``--set NAME=VALUE``
    default: str  # the value as a command line would give it, such as ``6edge``
    unit: str = ""  # in which it is, or what kind of value it is, for readers; may be empty
    description: str = ""  # its effect; may be empty
    #: where it stands in its file, counted from 1; None if it came from no file. It does not count in a comparison.
    line: int | None = field(default=None, compare=False)


def is_name(text: str) -> bool:
    """Whether the text can name a setting or tag a step: letters, digits and underscores, a letter first."""
    return _NAME.fullmatch(text) is not None


def read_setting(attributes: Mapping[str, str], line: int) -> tuple[Setting | None, str | None, str | None]:
    """The setting that the attributes of a ``<setting>`` say, or what is wrong with them and what to write instead."""
    if missing := next((name for name in SETTING_ATTRIBUTES[:2] if name not in attributes), None):
        return None, f"<setting> has no {missing}; it takes {', '.join(SETTING_ATTRIBUTES)}", None
    if (unknown := next((name for name in attributes if name not in SETTING_ATTRIBUTES), None)) is not None:
        message = f"<setting> has no attribute {shortened(unknown)!r}; it takes {', '.join(SETTING_ATTRIBUTES)}"
        return None, message, nearest(unknown, SETTING_ATTRIBUTES)
    if not is_name(attributes["name"]):
        return None, f"<setting> has the name {shortened(attributes['name'])!r}; it takes letters, digits and underscores", None
    return Setting(**attributes, line=line), None, None


@dataclass(frozen=True)
class ParamElement:
    """A ``<Param>`` or ``<xmlparam>``."""

    attributes: Mapping[str, str]  # as written
    line: int  # where it begins, counted from 1


@dataclass(frozen=True)
class FilterElement:
    """A ``<filter>`` or ``<xmlfilter>``."""

    kind: str  # ``"filter"`` or ``"xmlfilter"``
    name: str | None  # the attribute of that name, or None
    line: int  # where it begins, counted from 1
    params: tuple[ParamElement, ...] = ()  # its parameters, in the order of the file
    tag: str = ""  # the attribute of that name; empty if there is none


@dataclass(frozen=True)
class Document:
    """The contents of a file."""

    name: str  # of the file, for messages
    filters: tuple[FilterElement, ...] = ()  # in the order of the file
    comment: str = ""  # the words at its head
    problems: tuple[Problem, ...] = ()  # mistakes in its structure
    guards: Guards = NO_GUARDS  # limits of the result
    settings: tuple[Setting, ...] = ()  # values that have a name
    unit: str = ""  # of the scans that the script is for; empty if it says none


#: the words with which a paragraph of a head comment may begin, each followed by a colon
KEYWORDS = ("Task", "For", "Fits", "Judged", "Does", "Tune", "Superseded")


@dataclass(frozen=True)
class Step:
    """One filter of a script with the values that the script gives."""

    filter: Filter  # the filter that runs
    #: by Python parameter name, as `Filter.check` returns them: lengths as `Length`, choices as words. Parameters that are absent
    #: take their default on the mesh that the step meets.
    values: Mapping[str, Any] = field(default_factory=dict)
    #: where the step begins in its file, counted from 1; None if it came from no file. Two steps that differ in their line alone
    #: are equal.
    line: int | None = field(default=None, compare=False)
    tag: str = ""  # a name that the recipe gives to the step, or to several; empty if it gives none
    #: by Python parameter name, the settings of the recipe that the values come from
    settings: Mapping[str, str] = field(default_factory=dict)

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.filter.python_name, self.values, self.line, self.tag, self.settings)

    def with_values(self, values: Mapping[str, Any]) -> Step:
        """The step with these values checked and put over its own."""
        return self.with_checked(self.filter.check(values))

    def with_checked(self, values: Mapping[str, Any]) -> Step:
        """The step with these values, which have been checked, put over its own; one that changes leaves its setting."""
        unset = {name for name, value in values.items() if self.values.get(name) != value}
        settings = {name: setting for name, setting in self.settings.items() if name not in unset}
        return replace(self, values=self.filter.in_order({**self.values, **values}), settings=settings)

    @property
    def relative_lengths(self) -> dict[str, Length]:
        """By Python parameter name, the lengths that depend on the size of the mesh."""
        values = self.values.items()
        return {name: v for name, v in values if isinstance(v, Length) and v.unit != "absolute" and v.amount}

    def in_mesh_units(self, *, diagonal: float, mean_edge: float) -> Step:
        """The step with its lengths in mesh units, on a mesh of this size."""
        lengths = {
            name: Length(value.resolve(diagonal=diagonal, mean_edge=lambda: mean_edge))
            for name, value in self.values.items()
            if isinstance(value, Length)
        }
        return self.with_checked(lengths)

    def with_defaults(self, *, lengths: bool = True) -> Step:
        """The step with every value said that is known without a mesh; without `lengths`, those that depend on its size are not.

        A built-in filter leaves some to the mesh, such as the number of triangles to decimate to; those stay absent.
        """
        defaults = {
            name: default
            for name, default in self.filter.defaults.items()
            if default is not None and (lengths or not isinstance(default, Length) or default.unit == "absolute")
        }
        return replace(self, values=self.filter.in_order({**defaults, **self.values}))


def _restored(filter: str, *rest: Any) -> Step:
    """A step in another process, where its filter is that of the same name."""
    return Step(find_filter(filter), *rest)


@dataclass(frozen=True)
class Script:
    """A chain of steps."""

    steps: tuple[Step, ...]  # in the order in which they run
    comment: str = ""  # the words at the head of the file, without the marks of a comment
    #: the file that it was read from; it does not count when scripts are compared
    path: Path | None = field(default=None, compare=False)
    guards: Guards = NO_GUARDS  # limits of the result
    settings: tuple[Setting, ...] = ()  # values that have a name, which one place sets for all steps that use them
    unit: str = ""  # of the scans that it is for, of `pymeshfair.declaration.units.METRES`; empty if it says none

    def problem(self, step: Step, message: str, *, parameter: str | None = None) -> Problem:
        """The problem with a step, or with its parameter of that name in scripts."""
        file = "script" if self.path is None else str(self.path)
        return Problem(file=file, line=step.line, filter=step.filter.name, parameter=parameter, message=message)

    def with_steps(self, steps: Iterable[Step]) -> Script:
        """The script with these steps in place of its own; settings that none of them uses are left out."""
        chosen = tuple(steps)
        used = {name for step in chosen for name in step.settings.values()}
        return replace(self, steps=chosen, settings=tuple(s for s in self.settings if s.name in used))

    def with_defaults(self, *, lengths: bool = True) -> Script:
        """The script with every value said that is known without a mesh; `lengths` as in `Step.with_defaults`."""
        return replace(self, steps=tuple(step.with_defaults(lengths=lengths) for step in self.steps))


def clean_comment(text: str) -> str:
    """A comment's text without its common indentation and without empty lines at its ends."""
    return inspect.cleandoc("\n".join(line.rstrip() for line in text.expandtabs().splitlines())).strip()


def paragraphs(text: str) -> dict[str, str]:
    """Of a head comment without its title, by keyword the first paragraph that begins with that one of `KEYWORDS`."""
    by_keyword: dict[str, str] = {}
    for paragraph in re.split(r"\n[ \t]*\n", text.strip()):
        keyword, colon, words = " ".join(paragraph.split()).partition(":")
        if colon and keyword in KEYWORDS:
            by_keyword.setdefault(keyword, words.strip())
    return by_keyword

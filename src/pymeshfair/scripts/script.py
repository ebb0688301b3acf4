"""A filter script in memory: filters with checked values, in the order in which they run; and what is wrong with one.

Settings are values with a name, which one place sets for all steps that use them: a ``<setting name= default= unit=
description=/>`` stands under ``<FilterScript>``, and each ``<Param ... setting="NAME">`` that takes its value says so. MeshLab
looks at neither: it runs the values of the steps, which are those of the defaults.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..declaration import Filter, Length
from ..errors import ParameterError, PymeshfairError
from ..registry import find_filter
from .guards import NO_GUARDS, Guards

#: the words with which a paragraph of a head comment may begin, each followed by a colon
KEYWORDS = ("Task", "For", "Fits", "Judged", "Does", "Tune", "Superseded")
#: the attributes of a ``<setting>``, in the order in which they are written
SETTING_ATTRIBUTES = ("name", "default", "unit", "description")


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One thing that is wrong with a script."""

    message: str  # the mistake, the written text and the allowed one
    file: str  # the path or name of the script
    line: int | None = None  # counted from 1; None if the whole file is meant
    filter: str | None = None  # the name of the filter as written there
    parameter: str | None = None  # the name of the parameter as written there
    suggestion: str | None = None  # the text to write instead, where one is likely

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        step = "" if self.filter is None else f": filter {shortened(self.filter)!r}"
        hint = "" if self.suggestion is None else f" (did you mean {self.suggestion!r}?)"
        return f"{place}{step}{_of_parameter(self.parameter)}: {self.message}{hint}"


class ScriptError(PymeshfairError):
    """A script cannot be read, or something in it is wrong; the message has one line for each problem."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)  # all of them, in the order of the file
        super().__init__("\n".join(map(str, self.problems)))


@dataclass(frozen=True, kw_only=True)
class Change:
    """One thing that an upgrade changed."""

    line: int  # of the old script, counted from 1
    filter: str  # its name in the old script
    what: str  # the change
    parameter: str | None = None  # its name in the old script; None if the change is not about one
    meaning: str = ""  # how the result differs from what the script once did, or does in MeshLab today; empty if it does not

    @property
    def same_meaning(self) -> bool:
        """Whether the script still does what it did."""
        return not self.meaning

    def __str__(self) -> str:
        grade = "same meaning" if self.same_meaning else f"meaning changes: {self.meaning}"
        return f"line {self.line}: filter {shortened(self.filter)!r}{_of_parameter(self.parameter)}: {self.what} ({grade})"


def _of_parameter(name: str | None) -> str:
    return "" if name is None else f": parameter {shortened(name)!r}"


def shortened(text: str) -> str:
    """The text, cut to a length that a message can hold."""
    return text if len(text) <= 80 else f"{text[:77]}..."


def checked_name(name: str, of_what: str) -> str:
    """The name of a setting or the tag of a step: letters, digits and underscores, a letter first."""
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]{0,79}", name):
        raise ParameterError(f"the {of_what} {shortened(name)!r} takes letters, digits and underscores")
    return name


@dataclass(frozen=True)
class Setting:
    """A value of a recipe that has a name."""

    name: str  # by which it is set, ``--set NAME=VALUE``
    default: str  # the value as a command line would give it, such as ``6edge``
    unit: str = ""  # in which it is, or what kind of value it is, for readers; may be empty
    description: str = ""  # its effect; may be empty
    line: int | None = field(default=None, compare=False)  # where it stands in its file, counted from 1; None without a file

    def __post_init__(self) -> None:
        checked_name(self.name, "setting")


@dataclass(frozen=True)
class Step:
    """One filter of a script with the values that the script gives."""

    filter: Filter  # the filter that runs
    #: by Python parameter name, as `Filter.check` returns them; absent ones take their default on the mesh that the step meets
    values: Mapping[str, Any] = field(default_factory=dict)
    line: int | None = field(default=None, compare=False)  # where it begins in its file, counted from 1; None without a file
    tag: str = ""  # a name that the recipe gives to the step, or to several; empty if it gives none
    settings: Mapping[str, str] = field(default_factory=dict)  # those that values come from, by Python parameter name

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.filter.python_name, self.values, self.line, self.tag, self.settings)

    def with_values(self, values: Mapping[str, Any]) -> Step:
        """The step with these values checked and put over its own."""
        return self.with_checked(self.filter.check(values))

    def with_checked(self, values: Mapping[str, Any]) -> Step:
        """The step with these values, which have been checked, put over its own; one that changes leaves its setting."""
        settings = {n: s for n, s in self.settings.items() if n not in values or self.values.get(n) == values[n]}
        return replace(self, values=self.filter.in_order({**self.values, **values}), settings=settings)

    @property
    def relative_lengths(self) -> dict[str, Length]:
        """By Python parameter name, the lengths that depend on the size of the mesh."""
        values = self.values.items()
        return {name: v for name, v in values if isinstance(v, Length) and v.unit != "absolute" and v.amount}

    def in_mesh_units(self, *, diagonal: float, mean_edge: float) -> Step:
        """The step with its lengths in mesh units, on a mesh of this size."""
        lengths = {name: value for name, value in self.values.items() if isinstance(value, Length)}
        return self.with_checked(
            {n: Length(v.resolve(diagonal=diagonal, mean_edge=lambda: mean_edge)) for n, v in lengths.items()}
        )

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
    path: Path | None = field(default=None, compare=False)  # the file that it was read from
    guards: Guards = NO_GUARDS  # limits of the result
    settings: tuple[Setting, ...] = ()  # values that have a name, which one place sets for all steps that use them
    unit: str = ""  # of the scans that it is for, of `pymeshfair.declaration.parameters.METRES`; empty if it says none

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

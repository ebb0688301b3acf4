"""A filter script in memory: its steps, which are filters with checked values, its settings, and its problems.

A setting is a named value that steps share. In the file it is a ``<setting name= default= unit= description=/>`` under
``<FilterScript>``, and each ``<Param ... setting="NAME">`` takes its value from it. MeshLab ignores settings: it takes the values
in the steps, which equal the defaults of the settings.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..declaration import Filter, Length
from ..errors import ParameterError, PymeshfairError, shortened
from ..registry import find_filter
from .guards import NO_GUARDS, Guards

#: the words before a colon that may begin a paragraph of a head comment
KEYWORDS = ("Task", "For", "Fits", "Judged", "Does", "Tune", "Superseded")
#: the attributes of a ``<setting>``, in the order in which they are written
SETTING_ATTRIBUTES = ("name", "default", "unit", "description")


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One problem of a script."""

    message: str
    file: str  # the path or name of the script
    line: int | None = None  # counted from 1; None if the problem is with the whole file
    filter: str | None = None  # its name, as the script writes it
    parameter: str | None = None  # its name, as the script writes it
    suggestion: str | None = None  # the text to write instead

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        step = "" if self.filter is None else f": filter {shortened(self.filter)!r}"
        is_said = self.suggestion is None or repr(self.suggestion) in self.message
        hint = "" if is_said else f" (did you mean {self.suggestion!r}?)"
        return f"{place}{step}{_of_parameter(self.parameter)}: {self.message}{hint}"


class ScriptError(PymeshfairError):
    """A script cannot be read, or has problems; the message has one line for each problem."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)  # in the order of the file
        super().__init__("\n".join(map(str, self.problems)))


@dataclass(frozen=True, kw_only=True)
class Change:
    """One change by an upgrade."""

    line: int  # of the old script, counted from 1
    filter: str  # its name in the old script; may be empty
    what: str  # the change
    parameter: str | None = None  # its name in the old script
    meaning: str = ""  # how the new script's result differs from the old script's

    @property
    def same_meaning(self) -> bool:
        return not self.meaning

    def __str__(self) -> str:
        grade = "same meaning" if self.same_meaning else f"meaning changes: {self.meaning}"
        step = self.filter and f"filter {shortened(self.filter)!r}{_of_parameter(self.parameter)}: "
        return f"line {self.line}: {step}{self.what} ({grade})"


def _of_parameter(name: str | None) -> str:
    return "" if name is None else f": parameter {shortened(name)!r}"


def checked_name(name: str, of_what: str) -> str:
    """Returns a setting's name or a step's tag: up to 80 ASCII letters, digits and underscores, no digit first."""
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]{0,79}", name):
        rule = "must consist of letters, digits and underscores (ASCII, at most 80), no digit first"
        raise ParameterError(f"the {of_what} {shortened(name)!r} {rule}")
    return name


@dataclass(frozen=True)
class Setting:
    """A named value of a recipe."""

    name: str  # the name in ``--set NAME=VALUE``
    default: str  # the value as on a command line, such as ``6edge``
    unit: str = ""  # the unit or the kind of the value, for readers
    description: str = ""  # its effect
    line: int | None = field(default=None, compare=False)  # in the file, counted from 1

    def __post_init__(self) -> None:
        checked_name(self.name, "setting")


@dataclass(frozen=True)
class Step:
    """One filter of a script with the values that the script gives."""

    filter: Filter
    #: by Python parameter name, as `Filter.check` returns them; a parameter without a value takes its default on the step's mesh
    values: Mapping[str, Any] = field(default_factory=dict)
    line: int | None = field(default=None, compare=False)  # its first line in the file, counted from 1
    tag: str = ""  # a name, which several steps of a recipe may share
    settings: Mapping[str, str] = field(default_factory=dict)  # by Python parameter name, the setting that gives the value
    #: diagonal and mean edge of the mesh that it ran on, to write relative lengths in mesh units; None if unknown
    size: tuple[float, float] | None = field(default=None, compare=False)

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.filter.python_name, self.values, self.line, self.tag, self.settings, self.size)

    def with_values(self, values: Mapping[str, Any]) -> Step:
        """The step with these values, after a check; its other values stay."""
        return self.with_checked(self.filter.check(values))

    def with_checked(self, values: Mapping[str, Any]) -> Step:
        """As `with_values`, for checked values. A changed value no longer comes from a setting."""
        settings = {n: s for n, s in self.settings.items() if n not in values or self.values.get(n) == values[n]}
        return replace(self, values=self.filter.in_order({**self.values, **values}), settings=settings)

    @property
    def relative_lengths(self) -> dict[str, Length]:
        """The lengths that depend on the size of the mesh, by Python parameter name."""
        return {name: v for name, v in self.values.items() if isinstance(v, Length) and v.unit != "absolute" and v.amount}

    def in_mesh_units(self, *, diagonal: float, mean_edge: float) -> Step:
        lengths = {name: value for name, value in self.values.items() if isinstance(value, Length)}
        resolved = {n: Length(v.resolve(diagonal=diagonal, mean_edge=lambda: mean_edge)) for n, v in lengths.items()}
        return self.with_checked(resolved)

    def with_defaults(self, *, lengths: bool = True) -> Step:
        """The step with defaults for parameters without a value; relative lengths get no default if `lengths` is False.

        Some defaults depend on the mesh, such as MeshLab's number of triangles to decimate to: these parameters get no value.
        """
        defaults = {
            name: default
            for name, default in self.filter.defaults.items()
            if default is not None and (lengths or not isinstance(default, Length) or default.unit == "absolute")
        }
        return replace(self, values=self.filter.in_order({**defaults, **self.values}))


def _restored(filter: str, *fields: Any) -> Step:
    return Step(find_filter(filter), *fields)


@dataclass(frozen=True)
class Script:
    """A sequence of steps."""

    steps: tuple[Step, ...]  # in the order in which they run
    comment: str = ""  # the text of the head comment
    path: Path | None = field(default=None, compare=False)
    guards: Guards = NO_GUARDS  # the limits on the result
    settings: tuple[Setting, ...] = ()
    unit: str = ""  # of the scans the script is for, one of `pymeshfair.declaration.parameters.METRES`; may be empty

    def problem(self, step: Step, message: str, *, parameter: str | None = None) -> Problem:
        file = "script" if self.path is None else str(self.path)
        return Problem(file=file, line=step.line, filter=step.filter.name, parameter=parameter, message=message)

    def with_steps(self, steps: Iterable[Step]) -> Script:
        """The script with these steps in place of its own; settings that no step uses are left out."""
        chosen = tuple(steps)
        used = {name for step in chosen for name in step.settings.values()}
        return replace(self, steps=chosen, settings=tuple(s for s in self.settings if s.name in used))

    def with_defaults(self, *, lengths: bool = True) -> Script:
        return replace(self, steps=tuple(step.with_defaults(lengths=lengths) for step in self.steps))


def clean_comment(text: str) -> str:
    """A comment's text without its common indentation and without empty lines at its ends."""
    return inspect.cleandoc("\n".join(line.rstrip() for line in text.expandtabs().splitlines())).strip()


def paragraphs(comment: str) -> dict[str, str]:
    """By keyword of `KEYWORDS`, the first paragraph of a head comment that begins with it; the title line is skipped."""
    by_keyword: dict[str, str] = {}
    for paragraph in re.split(r"\n[ \t]*\n", comment.partition("\n")[2].strip()):
        keyword, colon, words = " ".join(paragraph.split()).partition(":")
        if colon and keyword in KEYWORDS:
            by_keyword.setdefault(keyword, words.strip())
    return by_keyword

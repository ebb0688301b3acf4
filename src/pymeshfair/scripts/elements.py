"""The elements of a script as written, before they are checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .guards import NO_GUARDS, Guards
from .problems import Problem
from .settings import Setting


@dataclass(frozen=True)
class ParamElement:
    """A ``<Param>`` or ``<xmlparam>``.

    Attributes:
        attributes: as written.
        line: where it begins, counted from 1.
    """

    attributes: Mapping[str, str]
    line: int


@dataclass(frozen=True)
class FilterElement:
    """A ``<filter>`` or ``<xmlfilter>``.

    Attributes:
        kind: ``"filter"`` or ``"xmlfilter"``.
        name: the attribute of that name, or None.
        line: where it begins, counted from 1.
        params: its parameters, in the order of the file.
        tag: the attribute of that name; empty if there is none.
    """

    kind: str
    name: str | None
    line: int
    params: tuple[ParamElement, ...] = ()
    tag: str = ""


@dataclass(frozen=True)
class Document:
    """The contents of a file.

    Attributes:
        name: of the file, for messages.
        filters: in the order of the file.
        comment: the words at its head.
        problems: mistakes in its structure.
        guards: limits of the result.
        settings: values that have a name.
        unit: of the scans that the script is for; empty if it says none.
    """

    name: str
    filters: tuple[FilterElement, ...] = ()
    comment: str = ""
    problems: tuple[Problem, ...] = ()
    guards: Guards = NO_GUARDS
    settings: tuple[Setting, ...] = ()
    unit: str = ""

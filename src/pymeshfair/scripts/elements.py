"""The elements of a script as written, before they are checked."""

from collections.abc import Mapping
from dataclasses import dataclass

from .guards import NO_GUARDS, Guards
from .problems import Problem
from .settings import Setting


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

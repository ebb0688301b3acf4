"""The exceptions that pymeshfair and its filters raise; every message names what was wrong, where, and what to do next."""

from __future__ import annotations

import importlib.util
import re
import signal
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .filters.checks import ConvergenceError as ConvergenceError
from .filters.checks import FilterInputError as FilterInputError
from .filters.checks import PymeshfairError as PymeshfairError


def plain_name(name: str) -> str:
    """A name without upper case, spaces and underscores, as names are compared."""
    return re.sub(r"[\s_-]+", "", name.casefold())


def nearest(name: str, names: Iterable[str], *, cutoff: float = 0.6) -> str | None:
    """The one of `names` that `name` was most likely meant to be; None if none is like it by the share `cutoff`."""
    import difflib

    plain = {plain_name(n): n for n in names}
    near = difflib.get_close_matches(plain_name(name), plain, n=1, cutoff=cutoff)
    return plain[near[0]] if near else None


def hint(name: str, names: Collection[str], otherwise: str = "") -> str:
    """The end of a sentence about a wrong name: the one that was meant, or else all that there are."""
    near = nearest(name, names)
    return f"did you mean {near!r}?" if near else otherwise or f"there are {', '.join(names)}"


class UnknownNameError(PymeshfairError, LookupError):
    """A filter, parameter, choice or recipe of that name does not exist."""

    def __init__(self, message: str, *, suggestion: str | None = None, cause: str | None = None) -> None:
        super().__init__(message)
        self.suggestion = suggestion  # the nearest name that does exist, or None
        self.cause = cause  # why a filter of that name is not there, if a plugin that declares it cannot be used; else None


class ParameterError(PymeshfairError, ValueError):
    """A parameter's value has the wrong type or lies outside its bounds."""


class MissingExtraError(PymeshfairError, ImportError):
    """A package is not installed that belongs to an extra of pymeshfair."""


def missing_package(package: str, extra: str) -> str:
    """The message where a package is not installed that belongs to an extra of pymeshfair."""
    return f"it needs the package {package}; install pymeshfair with its extra: python -m pip install 'pymeshfair[{extra}]'"


def require_extra(extra: str, *packages: str) -> None:
    """Check that the packages of an extra are installed, before any work is done."""
    for package in packages:
        if importlib.util.find_spec(package) is None:
            raise MissingExtraError(missing_package(package, extra))


class DeclarationError(PymeshfairError, TypeError):
    """A plugin declares a filter that contradicts itself; raised where the filter is defined, never while it runs."""


class MeshError(PymeshfairError):
    """The current mesh lacks what a filter needs, or a filter's result does not fit the mesh."""


class RunError(PymeshfairError):
    """A run did not come to its end; no output was written, and what was there before is untouched."""


@dataclass(frozen=True)
class Place:
    """A place in a run: a step of the recipe, or before or after the steps."""

    doing: str  # the work in words: ``"reading scan.ply"``, ``"step 2 of 5, 'Close Holes'"``
    step: int | None = None  # the number of the step from 1, or None outside the steps
    total: int | None = None  # how many steps the recipe has
    filter: str | None = None  # MeshLab's name of the step's filter
    file: Path | None = None  # the recipe's file, if it has one
    line: int | None = None  # where in that file the step begins

    @classmethod
    def of_step(cls, step: int, total: int, filter: str, *, file: Path | None = None, line: int | None = None) -> Place:
        """The place of a step."""
        return cls(f"step {step} of {total}, {filter!r}", step, total, filter, file, line)

    def __str__(self) -> str:
        if self.file is None or self.step is None:
            return self.doing
        return f"{self.doing} ({self.file.name if self.line is None else f'{self.file.name}:{self.line}'})"


class PlacedError(RunError):
    """A failure with its place, the work that the run was doing, and the reason."""

    def __init__(self, place: Place, reason: str) -> None:
        super().__init__(f"{place}: {reason}")
        self.place, self.reason = place, reason


class StepFailedError(PlacedError):
    """A step failed: its filter refused the mesh or its parameters, or gave a result that no file may hold."""


class WorkerDied(PlacedError):  # noqa: N818 - says what happened
    """The worker process ended without a report; some of MeshLab's filters crash on awkward meshes."""

    def __init__(
        self, place: Place, status: int, details: str = "", *, memory_limit: int | None = None, advice: str = ""
    ) -> None:
        self.status = status  # its exit status, minus the signal's number if a signal ended it
        self.details = details  # the end of what it wrote to stderr
        if self.signal is None:
            cause = f"ended with exit status {status}, which it never does by itself"
        elif self.signal == "SIGKILL":
            cause = "was killed (SIGKILL): by hand, or by the system because memory ran out"
        else:
            limit = "" if memory_limit is None else f", perhaps for want of memory (the limit is {memory_limit / 1e6:.0f} MB)"
            cause = f"crashed ({self.signal}){limit}"
        super().__init__(place, f"the worker process {cause}{advice and f'; {advice}'}")

    @property
    def signal(self) -> str | None:
        """The name of the signal that ended the worker, such as ``"SIGSEGV"``, or None."""
        if self.status >= 0:
            return None
        try:
            return signal.Signals(-self.status).name
        except ValueError:
            return f"signal {-self.status}"


class GuardBroken(RunError):  # noqa: N818 - says what happened
    """The result does not keep within the limits that the recipe or the command set; it was not written."""

    def __init__(self, breaches: Sequence[Mapping[str, Any]], maps: Sequence[Path]) -> None:
        sentences = "; ".join(f"{breach['guard']}: {breach['message']}" for breach in breaches)
        shown = f"; {maps[0].name} shows where" if maps else "; --map OUT.ply shows where"
        super().__init__(f"{sentences}{shown}. No output was written; --keep-broken writes it all the same")
        self.breaches = tuple(breaches)  # each a `pymeshfair.running.guarding.Breach` by name
        self.maps = tuple(maps)  # the files of the intervention map, which show where


class RunTimeout(PlacedError):  # noqa: N818 - says what happened
    """The run took longer than it was given, `seconds`, or without `is_given` than reading any file takes, and was stopped."""

    def __init__(self, place: Place, seconds: float, *, is_given: bool = True) -> None:
        given = f"the {seconds:g} s that the run was given; give it more, or a smaller mesh"
        unusual = f"{seconds:g} s, ten times as long as files of its size take to read; it is probably damaged"
        super().__init__(place, f"stopped after {given if is_given else unusual}")
        self.seconds = seconds


class OutOfMemory(PlacedError):  # noqa: N818 - says what happened
    """The run needed more memory than there is, or than the `limit` in bytes that it was given."""

    def __init__(self, place: Place, limit: int | None) -> None:
        most = "there is" if limit is None else f"the {limit / 1e6:.0f} MB that the run was given"
        super().__init__(place, f"needed more memory than {most}; give it more, or a smaller mesh")
        self.limit = limit


class WorkerError(PlacedError):
    """The worker raised an exception that is none of ours, a defect; `details` has its traceback and the end of its stderr."""

    def __init__(self, place: Place, reason: str, details: str) -> None:
        super().__init__(place, f"{reason}; this is a defect of pymeshfair, please report it")
        self.details = details

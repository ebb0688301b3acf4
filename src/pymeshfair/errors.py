"""The exceptions of pymeshfair and its filters."""

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
    """A name in lower case without spaces, underscores and hyphens, for comparison."""
    return re.sub(r"[\s_-]+", "", name.casefold())


def nearest(name: str, names: Iterable[str], *, cutoff: float = 0.6) -> str | None:
    """The most similar of `names`; None if no similarity, from 0 to 1, reaches `cutoff`."""
    import difflib

    plain = {plain_name(n): n for n in names}
    near = difflib.get_close_matches(plain_name(name), plain, n=1, cutoff=cutoff)
    return plain[near[0]] if near else None


def hint(name: str, names: Collection[str], otherwise: str = "") -> str:
    """The end of a message about a wrong name: the most similar name, else `otherwise` if given, else all names."""
    near = nearest(name, names)
    return f"did you mean {near!r}?" if near else otherwise or f"there are {', '.join(names)}"


def shortened(text: str) -> str:
    """The text, cut to 80 characters for a message."""
    return text if len(text) <= 80 else f"{text[:77]}..."


class UnknownNameError(PymeshfairError, LookupError):
    """A filter, parameter, setting, step, recipe or layer of the given name does not exist."""

    def __init__(self, message: str, *, suggestion: str | None = None, cause: str | None = None) -> None:
        super().__init__(message)
        self.suggestion = suggestion  # the most similar existing name
        self.cause = cause  # the plugins that failed to load, one of which may declare the filter; None if there are none


class ParameterError(PymeshfairError, ValueError):
    """A parameter or an option has a value that is not allowed."""


class MissingExtraError(PymeshfairError, ImportError):
    """A package of an extra is not installed."""


def missing_package(package: str, extra: str) -> str:
    """The message about a package that is not installed."""
    return f"the package {package} is missing: install it by python -m pip install 'pymeshfair[{extra}]'"


def require_extra(extra: str, *packages: str) -> None:
    """Raises `MissingExtraError` if a package of an extra is not installed; call it before any work."""
    for package in packages:
        if importlib.util.find_spec(package) is None:
            raise MissingExtraError(missing_package(package, extra))


class DeclarationError(PymeshfairError, TypeError):
    """The declaration of a filter is wrong; raised at the definition of the filter, never in a run."""


class MeshError(PymeshfairError):
    """The current mesh lacks what a filter needs, or a filter's result does not fit the mesh."""


class RunError(PymeshfairError):
    """A run failed and wrote no output; existing files are untouched, but `GuardBroken` may change maps."""


@dataclass(frozen=True)
class Place:
    """A place in a run: a step of the recipe, or the work before or after the steps."""

    doing: str  # the work: ``"reading scan.ply"``, ``"step 2 of 5, 'Close Holes'"``
    step: int | None = None  # the number of the step from 1, or None outside the steps
    total: int | None = None  # the number of steps
    filter: str | None = None  # the MeshLab name
    file: Path | None = None  # the recipe's file, if it has one
    line: int | None = None  # the line of that file at which the step begins

    @classmethod
    def of_step(cls, step: int, total: int, filter: str, *, file: Path | None = None, line: int | None = None) -> Place:
        return cls(f"step {step} of {total}, {filter!r}", step, total, filter, file, line)

    def __str__(self) -> str:
        if self.file is None or self.step is None:
            return self.doing
        return f"{self.doing} ({self.file.name if self.line is None else f'{self.file.name}:{self.line}'})"


class PlacedError(RunError):
    """A failed run, with the place of the failure and the reason."""

    def __init__(self, place: Place, reason: str) -> None:
        super().__init__(f"{place}: {reason}")
        self.place, self.reason = place, reason


class StepFailedError(PlacedError):
    """A step failed: its filter refused the mesh or its parameters, or gave a result that cannot be written."""


class WorkerDied(PlacedError):  # noqa: N818 - says what happened
    """The worker process ended without a report; some MeshLab filters crash on unusual meshes."""

    def __init__(
        self, place: Place, status: int, details: str = "", *, memory_limit: int | None = None, advice: str = ""
    ) -> None:
        self.status = status  # the exit status; -n if signal n ended the process
        self.details = details  # the end of the worker's stderr
        if self.signal is None:
            cause = f"ended with exit status {status}, without a report"
        elif self.signal == "SIGKILL":
            cause = "was killed (SIGKILL): by hand, or by the system because memory ran out"
        else:
            limit = "" if memory_limit is None else f", perhaps because memory ran out (the limit is {memory_limit / 1e6:.0f} MB)"
            cause = f"crashed ({self.signal}){limit}"
        super().__init__(place, f"the worker process {cause}{advice and f'; {advice}'}")

    @property
    def signal(self) -> str | None:
        """The signal that ended the worker, such as ``"SIGSEGV"``, or None."""
        if self.status >= 0:
            return None
        try:
            return signal.Signals(-self.status).name
        except ValueError:
            return f"signal {-self.status}"


class GuardBroken(RunError):  # noqa: N818 - says what happened
    """The result breaks limits of the recipe or the command; it was not written."""

    def __init__(self, breaches: Sequence[Mapping[str, Any]], maps: Sequence[Path]) -> None:
        sentences = "; ".join(f"{breach['guard']}: {breach['message']}" for breach in breaches)
        shown = f"; {maps[0].name} shows where" if maps else ""
        super().__init__(f"{sentences}{shown}. No output was written; change the limit or the recipe")
        self.breaches = tuple(breaches)  # the fields of each `pymeshfair.running.guarding.Breach` by name
        self.maps = tuple(maps)  # the files of the intervention map


class RunTimeout(PlacedError):  # noqa: N818 - says what happened
    """The run was stopped after `seconds`: the limit of the run if `is_given`, else the limit for reading its input file."""

    def __init__(self, place: Place, seconds: float, *, is_given: bool = True) -> None:
        given = f"the {seconds:g} s that the run was given; give it more, or a smaller mesh"
        unusual = f"{seconds:g} s, ten times as long as files of its size may take to read; it is probably damaged"
        super().__init__(place, f"stopped after {given if is_given else unusual}")
        self.seconds = seconds


class OutOfMemory(PlacedError):  # noqa: N818 - says what happened
    """The run needed more memory than the machine has, or more than its `limit` in bytes."""

    def __init__(self, place: Place, limit: int | None) -> None:
        most = "there is" if limit is None else f"the {limit / 1e6:.0f} MB that the run was given"
        super().__init__(place, f"needed more memory than {most}; give it more, or a smaller mesh")
        self.limit = limit


class WorkerError(PlacedError):
    """The worker raised an unexpected exception, which is a defect; `details` has the traceback and the end of stderr."""

    def __init__(self, place: Place, reason: str, details: str) -> None:
        super().__init__(place, f"{reason}; this is a defect of pymeshfair, please report it")
        self.details = details

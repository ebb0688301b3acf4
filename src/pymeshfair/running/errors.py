"""The ways in which a run can fail."""

import signal
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import Place, RunError


class WorkerDied(RunError):  # noqa: N818 - says what happened
    """The worker process ended without a report; some of MeshLab's filters crash on awkward meshes.

    Attributes:
        place: the work that it was doing.
        status: its exit status; minus the signal's number if a signal ended it.
        details: the end of what it wrote to stderr.
    """

    def __init__(
        self, place: Place, status: int, details: str = "", *, memory_limit: int | None = None, advice: str = ""
    ) -> None:
        super().__init__(f"{place}: the worker process {_cause(status, memory_limit)}{advice and f'; {advice}'}")
        self.place = place
        self.status = status
        self.details = details

    @property
    def signal(self) -> str | None:
        """The name of the signal that ended the worker, such as ``"SIGSEGV"``, or None."""
        return _signal_name(self.status)


class GuardBroken(RunError):  # noqa: N818 - says what happened
    """The result does not keep within the limits that the recipe or the command set; it was not written.

    Attributes:
        breaches: each `pymeshfair.running.guarding.Breach` by name: what, where, how much, and how much was allowed.
        maps: the files of the intervention map, which show where.
    """

    def __init__(self, breaches: Sequence[Mapping[str, Any]], maps: Sequence[Path]) -> None:
        sentences = "; ".join(f"{breach['guard']}: {breach['message']}" for breach in breaches)
        shown = f"; {maps[0].name} shows where" if maps else "; --map OUT.ply shows where"
        super().__init__(f"{sentences}{shown}. No output was written; --keep-broken writes it all the same")
        self.breaches = tuple(breaches)
        self.maps = tuple(maps)


class RunTimeout(RunError):  # noqa: N818 - says what happened
    """The run took longer than it was given, and was stopped.

    Attributes:
        place: the work that it was doing.
        seconds: the allowed time.
    """

    def __init__(self, place: Place, seconds: float, *, is_given: bool = True) -> None:
        """See the class; without `is_given` the time is that which reading any file has."""
        reason = (
            f"the {seconds:g} s that the run was given; give it more, or a smaller mesh"
            if is_given
            else f"{seconds:g} s, ten times as long as files of its size take to read; it is probably damaged"
        )
        super().__init__(f"{place}: stopped after {reason}")
        self.place = place
        self.seconds = seconds


class OutOfMemory(RunError):  # noqa: N818 - says what happened
    """The run needed more memory than there is, or than it was given.

    Attributes:
        place: the work that it was doing.
        limit: the allowed bytes, or None.
    """

    def __init__(self, place: Place, limit: int | None) -> None:
        limit_text = "there is" if limit is None else f"the {limit / 1e6:.0f} MB that the run was given"
        super().__init__(f"{place}: needed more memory than {limit_text}; give it more, or a smaller mesh")
        self.place = place
        self.limit = limit


class WorkerError(RunError):
    """The worker raised an exception that is none of ours: a defect of pymeshfair.

    Attributes:
        place: the work that it was doing.
        details: the traceback, and the end of what it wrote to stderr.
    """

    def __init__(self, place: Place, reason: str, details: str) -> None:
        super().__init__(f"{place}: {reason}; this is a defect of pymeshfair, please report it")
        self.place = place
        self.details = details


def _signal_name(status: int) -> str | None:
    if status >= 0:
        return None
    try:
        return signal.Signals(-status).name
    except ValueError:
        return f"signal {-status}"


def _cause(status: int, memory_limit: int | None) -> str:
    name = _signal_name(status)
    if name is None:
        return f"ended with exit status {status}, which it never does by itself"
    if name == "SIGKILL":
        return "was killed (SIGKILL): by hand, or by the system because memory ran out"
    limited = "" if memory_limit is None else f", perhaps for want of memory (the limit is {memory_limit / 1e6:.0f} MB)"
    return f"crashed ({name}){limited}"

"""The ways in which a run can fail."""

import signal
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import Place, RunError


class PlacedError(RunError):
    """A failure with its place, the work that the run was doing."""

    def __init__(self, place: Place, words: str) -> None:
        super().__init__(f"{place}: {words}")
        self.place = place


class WorkerDied(PlacedError):  # noqa: N818 - says what happened
    """The worker process ended without a report; some of MeshLab's filters crash on awkward meshes.

    `status` is its exit status, minus the signal's number if a signal ended it; `details` the end of what it wrote to stderr.
    """

    def __init__(
        self, place: Place, status: int, details: str = "", *, memory_limit: int | None = None, advice: str = ""
    ) -> None:
        self.status = status
        self.details = details
        name = self.signal
        if name is None:
            cause = f"ended with exit status {status}, which it never does by itself"
        elif name == "SIGKILL":
            cause = "was killed (SIGKILL): by hand, or by the system because memory ran out"
        else:
            limit = "" if memory_limit is None else f", perhaps for want of memory (the limit is {memory_limit / 1e6:.0f} MB)"
            cause = f"crashed ({name}){limit}"
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
    """The result does not keep within the limits that the recipe or the command set; it was not written.

    `breaches` has each `pymeshfair.running.guarding.Breach` by name: what, where, how much, and how much was allowed; `maps` the
    files of the intervention map, which show where.
    """

    def __init__(self, breaches: Sequence[Mapping[str, Any]], maps: Sequence[Path]) -> None:
        sentences = "; ".join(f"{breach['guard']}: {breach['message']}" for breach in breaches)
        shown = f"; {maps[0].name} shows where" if maps else "; --map OUT.ply shows where"
        super().__init__(f"{sentences}{shown}. No output was written; --keep-broken writes it all the same")
        self.breaches = tuple(breaches)
        self.maps = tuple(maps)


class RunTimeout(PlacedError):  # noqa: N818 - says what happened
    """The run took longer than it was given, `seconds`, and was stopped."""

    def __init__(self, place: Place, seconds: float, *, is_given: bool = True) -> None:
        """See the class; without `is_given` the time is that which reading any file has."""
        reason = (
            f"the {seconds:g} s that the run was given; give it more, or a smaller mesh"
            if is_given
            else f"{seconds:g} s, ten times as long as files of its size take to read; it is probably damaged"
        )
        super().__init__(place, f"stopped after {reason}")
        self.seconds = seconds


class OutOfMemory(PlacedError):  # noqa: N818 - says what happened
    """The run needed more memory than there is, or than the `limit` in bytes that it was given."""

    def __init__(self, place: Place, limit: int | None) -> None:
        limit_text = "there is" if limit is None else f"the {limit / 1e6:.0f} MB that the run was given"
        super().__init__(place, f"needed more memory than {limit_text}; give it more, or a smaller mesh")
        self.limit = limit


class WorkerError(PlacedError):
    """The worker raised an exception that is none of ours: a defect of pymeshfair.

    `details` are the traceback, and the end of what it wrote to stderr.
    """

    def __init__(self, place: Place, reason: str, details: str) -> None:
        super().__init__(place, f"{reason}; this is a defect of pymeshfair, please report it")
        self.details = details

"""A worker's process, however it was started: by itself, or as a fork of one that has everything loaded."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from types import TracebackType
from typing import IO, Protocol, TypeAlias

from ..operating_system import this_system
from .environment import program_of, worker_environment


class Started(Protocol):
    """A process that waits for its assignment; it leads a session of its own.

    Attributes:
        pid: its number.
        stdin: its orders; it ends when that is closed.
        stdout: its reports.
        stderr: its talk.
    """

    pid: int
    stdin: IO[bytes]
    stdout: IO[bytes]
    stderr: IO[bytes]

    def has_ended(self) -> bool:
        """Whether it is gone; processes that it started may still hold its pipes open."""

    def wait(self, timeout: float | None = None) -> int | None:
        """Its exit status, minus a signal's number if that was the end; None if it has not ended after `timeout` seconds."""

    def kill(self) -> None:
        """End it and whatever it has started."""


#: the module whose ``main`` is the worker of a run
RUN = "pymeshfair.running.worker"
#: starts a worker's process
Start: TypeAlias = Callable[[], Started]


class FreshProcess:
    """An interpreter of its own, which loads everything anew."""

    def __init__(self, threads: int | None, module: str = RUN) -> None:
        """Start it; see `worker_environment` for `threads`, and `module` is run."""
        self._system = this_system()
        # In a session of its own Ctrl-C on the terminal does not reach it, and one signal ends it with all its children.
        self._process = subprocess.Popen(
            program_of(module),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=worker_environment(threads),
            **self._system.own_session(),
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        self.pid = self._process.pid
        self.stdin: IO[bytes] = self._process.stdin
        self.stdout: IO[bytes] = self._process.stdout
        self.stderr: IO[bytes] = self._process.stderr

    def has_ended(self) -> bool:
        """See `Started`."""
        return self._system.has_ended(self._process)

    def wait(self, timeout: float | None = None) -> int | None:
        """See `Started`."""
        try:
            return self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            return None

    def kill(self) -> None:
        """See `Started`."""
        if self._process.returncode is None:  # else it has been waited for, and another process may have its number by now
            self._system.kill(self._process)


class EarlyProcess:
    """A fresh process that loads MeshLab and numba while its assignment is still being checked; a context manager.

    If nobody takes it, it is ended with the context.
    """

    def __init__(self, *, is_wanted: bool = True) -> None:
        """See the class; nothing is started before the context is entered, nor then unless it is wanted."""
        self._is_wanted = is_wanted
        self._waiting: FreshProcess | None = None

    def __enter__(self) -> EarlyProcess:
        self._waiting = FreshProcess(None) if self._is_wanted else None
        return self

    def start(self) -> Started:
        """The process, for whoever gives it its assignment and ends it."""
        process, self._waiting = self._waiting, None
        return process or FreshProcess(None)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._waiting is not None:
            self._waiting.kill()
            self._waiting.wait()
            for stream in (self._waiting.stdin, self._waiting.stdout, self._waiting.stderr):
                stream.close()

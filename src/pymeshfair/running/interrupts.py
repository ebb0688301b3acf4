"""Delays Ctrl-C and other signals that end a process until the run has been cleaned up."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from queue import SimpleQueue
from types import FrameType, TracebackType
from typing import Any

from ..operating_system import this_system


class Interrupted(BaseException):
    """A signal asked for the end of the run. Used within `running` alone; callers see KeyboardInterrupt."""


class Interrupts:
    """While it lasts, SIGINT, SIGTERM and SIGHUP are put into a queue; afterwards the first of them has its usual effect.

    So clean-up is never interrupted: the supervisor sees the signal where it waits, stops the worker and removes its files; only
    then is KeyboardInterrupt raised, or does the process end by the signal. Handlers that a program has set itself stay. Outside
    the main thread nothing changes, as Python delivers no signals there.
    """

    def __init__(self, queue: SimpleQueue[tuple[str, Any]]) -> None:
        self._queue = queue  # gets ``("signal", number)``
        self._previous: dict[int, Any] = {}
        self._first: int | None = None

    def check(self) -> None:
        """Raise `Interrupted` if a signal has come."""
        if self._first is not None:
            raise Interrupted

    @contextlib.contextmanager
    def lifted(self) -> Iterator[None]:
        """Give signals their usual effect for a while, in which other work takes them itself."""
        for number, handler in self._previous.items():
            signal.signal(number, handler)
        try:
            self.check()
            yield
        finally:
            for number in self._previous:
                signal.signal(number, self._take)

    def __enter__(self) -> Interrupts:
        if threading.current_thread() is threading.main_thread():
            for name in this_system().stop_signals:
                number = getattr(signal, name)
                if signal.getsignal(number) in (signal.default_int_handler, signal.SIG_DFL):
                    self._previous[number] = signal.signal(number, self._take)
        return self

    def _take(self, number: int, frame: FrameType | None) -> None:
        self._first = self._first or number
        self._queue.put(("signal", number))

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for number, handler in self._previous.items():
            signal.signal(number, handler)
        if self._first is None:
            return
        if self._first != signal.SIGINT:
            signal.raise_signal(self._first)
        raise KeyboardInterrupt from (None if isinstance(error, Interrupted) else error)

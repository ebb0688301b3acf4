"""One process that does work, seen from the one that gives it orders."""

import pickle
import subprocess
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import IO, Any, TypeAlias

from ..errors import RunError
from ..operating_system import this_system
from .environment import program_of, worker_environment
from .forked import ForkedProcess
from .order import Answer, Order
from .worker import END_OF_TALK

#: what comes from a process: ``("event", value)`` that a task reports, ``("talk", line)`` for a line on its stderr,
#: ``("answer", Answer)`` and ``("silent", None)`` when a task has ended and all its talk was read, and ``("end", None)`` twice,
#: when the two streams are closed
Items: TypeAlias = SimpleQueue[tuple[str, Any]]

#: the most bytes of one line of talk
_LINE_LIMIT = 4096
#: seconds to wait for a killed process; it takes longer only if a disk does not answer
_PATIENCE = 5.0
#: seconds between two looks at a silent process, and for the rest of its talk once the answer is there
_PULSE = 0.5


class LostProcessError(RunError):
    """A process ended in the middle of a task."""

    def __init__(self, status: int) -> None:
        super().__init__(f"the worker process ended with status {status}")
        self.status = status  # its exit status; minus the signal's number if a signal ended it


class Process:
    """A process that waits for orders, and does one at a time."""

    def __init__(self, threads: int | None = None, modules: Sequence[str] = (), *, forked: bool = False) -> None:
        """Start it.

        Args:
            threads: that a filter may use, see `worker_environment`.
            modules: those that it imports before the first order.
            forked: make it a copy of this process, see `pymeshfair.processes.forked`, in place of a new interpreter.
        """
        self._system = this_system()
        # In a session of its own Ctrl-C on the terminal does not reach it, and one signal ends it with all its children.
        self._process: Any = (
            ForkedProcess(threads)
            if forked
            else subprocess.Popen(
                [*program_of("pymeshfair.processes.worker"), *modules],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env=worker_environment(threads),
                **self._system.own_session(),
            )
        )
        self.pid = self._process.pid
        self.is_idle = True
        self._items: Items = SimpleQueue()
        self._readers: list[threading.Thread] = []  # from the first order on, so that this process may be forked until then

    def _give(self, order: Order, items: Items) -> None:
        self.is_idle, self._items = False, items
        if not self._readers:
            for read, stream in ((self._read_reports, self._process.stdout), (self._read_talk, self._process.stderr)):
                self._readers.append(threading.Thread(target=read, args=(stream,), daemon=True))
                self._readers[-1].start()
        with suppress(OSError):  # it has died already, which the end of its streams tells
            pickle.dump(order, self._process.stdin)
            self._process.stdin.flush()

    def do(
        self,
        order: Order,
        take: Callable[[str, Any], None] = lambda kind, item: None,
        *,
        items: Items | None = None,
        pulse: Callable[[], float] = lambda: _PULSE,
    ) -> Answer:
        """Give it an order and wait for the answer.

        Args:
            order: the work.
            take: called with all else that comes; an exception that it raises ends the waiting.
            items: what comes is put there, perhaps among items of others.
            pulse: called time and again for the most seconds to wait; may raise, too.

        Raises:
            LostProcessError: it has ended without an answer.
        """
        items = SimpleQueue() if items is None else items
        self._give(order, items)
        done: Answer | None = None
        missing = {"answer", "silent"}
        while missing:
            try:
                kind, item = items.get(timeout=pulse())
            except Empty:
                if done is not None:
                    break  # something that it started holds its stderr
                kind, item = "end" if self.has_ended() else "", None
            if kind == "end" and done is None:
                self._take_the_rest(items, take)
                raise LostProcessError(self.wait())
            missing.discard(kind)
            if kind == "answer":
                done = item
            elif kind not in ("", "end", "silent"):
                take(kind, item)
        assert done is not None
        self.is_idle = not missing and not done.is_used_up
        return done

    def _take_the_rest(self, items: Items, take: Callable[[str, Any], None]) -> None:
        """Take what a process that has ended said last."""
        with suppress(Empty):
            while (item := items.get(timeout=_PULSE))[0] != "end":
                if item[0] == "talk":
                    take(*item)

    def has_ended(self) -> bool:
        """Whether it is gone; processes that it started may still hold its pipes open."""
        return self._process.returncode is not None or self._system.has_ended(self._process)

    def wait(self) -> int:
        """Its exit status, once it has ended; minus a signal's number if that was the end."""
        status: int = self._process.wait()
        return status

    def kill(self) -> None:
        """End it and the processes that it has started; may be called from any thread."""
        if self._process.returncode is None:  # else it has been waited for, and another process may have its number by now
            self._system.kill(self._process)

    def close(self) -> None:
        """End it, and leave nothing of it."""
        self.kill()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_PATIENCE)
        for reader in self._readers:
            reader.join(1.0)
        for stream in (self._process.stdin, self._process.stdout, self._process.stderr):
            with suppress(OSError):  # its last order has not arrived
                stream.close()

    def _read_reports(self, stream: IO[bytes]) -> None:
        with suppress(EOFError, pickle.UnpicklingError, ValueError, OSError):  # killed, perhaps in the middle of its answer
            while True:
                item = pickle.load(stream)
                self._items.put(item)  # those of the order that is being carried out by now
        self._items.put(("end", None))

    def _read_talk(self, stream: IO[bytes]) -> None:
        with suppress(ValueError, OSError):
            while line := stream.readline(_LINE_LIMIT):
                if line.strip() == END_OF_TALK.strip():
                    self._items.put(("silent", None))
                elif text := line.decode("utf-8", "replace").rstrip():
                    self._items.put(("talk", text))
        self._items.put(("end", None))

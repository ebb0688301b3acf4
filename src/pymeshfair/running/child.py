"""Gives a worker process its assignment, reads what it writes, and ends it."""

from __future__ import annotations

import json
import threading
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from queue import SimpleQueue
from types import TracebackType
from typing import IO, Any

from .messages import parse_talk, to_line
from .started import FreshProcess, Start, Started

#: the last lines of a worker's stderr that are kept for the report of its death, and the most bytes of one
_TAIL_LINES, _LINE_LIMIT = 60, 4096
#: seconds to wait for a killed process; it takes longer only if a disk does not answer
_PATIENCE = 5.0


class WorkerProcess:
    """A worker that carries out one assignment; a context manager that leaves no process behind.

    What it writes arrives in the queue: ``("report", document)`` for a line on its channel, ``("talk", Talk)`` for a line on its
    stderr, and ``("end", None)`` twice, when each of the two is closed.
    """

    def __init__(
        self,
        assignment: Mapping[str, Any],
        queue: SimpleQueue[tuple[str, Any]],
        *,
        threads: int | None = None,
        start: Start | None = None,
    ) -> None:
        """See the class; nothing is started before the context is entered.

        Args:
            assignment: the document of a `pymeshfair.running.messages.Assignment`.
            queue: takes what the worker writes.
            threads: that a filter may use in a fresh process, see `worker_environment`.
            start: what starts the process in place of that.
        """
        self._assignment = assignment
        self._queue = queue
        self._start: Start = start or (lambda: FreshProcess(threads))
        self._process: Started | None = None
        self._threads: list[threading.Thread] = []
        self.tail: deque[str] = deque(maxlen=_TAIL_LINES)

    def __enter__(self) -> WorkerProcess:
        self._process = process = self._start()
        for reader, stream in ((self._read_reports, process.stdout), (self._read_talk, process.stderr)):
            self._threads.append(threading.Thread(target=reader, args=(stream,), daemon=True))
            self._threads[-1].start()
        # A long recipe fills the pipe until the worker reads; a thread writes it, so that Ctrl-C need not wait.
        self._threads.append(threading.Thread(target=self._send, args=(process.stdin,), daemon=True))
        self._threads[-1].start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        assert self._process is not None
        self._process.kill()
        self._process.wait(_PATIENCE)
        for thread in self._threads:
            thread.join(1.0)
        for stream in (self._process.stdin, self._process.stdout, self._process.stderr):
            with suppress(OSError):
                stream.close()

    @property
    def pid(self) -> int:
        """The number of the worker's process."""
        assert self._process is not None
        return self._process.pid

    def has_ended(self) -> bool:
        """Whether the process is gone; processes that it started may still hold its pipes open."""
        assert self._process is not None
        return self._process.has_ended()

    def wait(self) -> int:
        """The exit status, once both streams have ended; minus a signal's number if that was the end."""
        assert self._process is not None
        status = self._process.wait()
        assert status is not None
        return status

    def _send(self, stream: IO[bytes]) -> None:
        with suppress(ValueError, OSError):  # the worker has died already; the end of its streams tells that
            stream.write(to_line(self._assignment))
            stream.flush()  # the pipe stays open: the worker ends when it is closed

    def _read_reports(self, stream: IO[bytes]) -> None:
        with suppress(ValueError, OSError):
            for line in stream:
                self._queue.put(("report", json.loads(line)))
        self._queue.put(("end", None))

    def _read_talk(self, stream: IO[bytes]) -> None:
        with suppress(ValueError, OSError):
            while line := stream.readline(_LINE_LIMIT):
                text = line.decode("utf-8", "replace").rstrip()
                if text:
                    talk = parse_talk(text)
                    if talk.fraction is None and talk.step is None:
                        self.tail.append(text)
                    self._queue.put(("talk", talk))
        self._queue.put(("end", None))

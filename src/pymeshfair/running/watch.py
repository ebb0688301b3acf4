"""Follows a worker until it ends, and turns every failure into an exception that says at which step it happened."""

from __future__ import annotations

import math
import shutil
import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from ..errors import Place, RunError, StepFailedError
from ..files.errors import InputError, OutputError
from .child import WorkerProcess
from .errors import OutOfMemory, RunTimeout, WorkerDied, WorkerError
from .interrupts import Interrupted
from .job import Compiling, Event, Job, Message, PhaseStarted, StepProgress, StepStarted
from .messages import Talk, decode_event

#: seconds between two looks at a silent worker
_PULSE = 0.5
#: bytes; a disk with less free space counts as full
_FULL = 1 << 20
#: MeshLab's level of log for warnings
_WARNING = 1
#: seconds that reading any file may take, compilation not among them, and bytes a second besides: ten times as long as the
#: slowest format takes
_LOAD_SECONDS, _LOAD_RATE = 60.0, 1e6


class Watch:
    """Reads the events and the talk of one worker.

    Attributes:
        said: what filters said, by the number of their step; 0 stands for reading and writing.
        warned: those of these words that MeshLab calls warnings.
    """

    def __init__(
        self, job: Job, worker: WorkerProcess, queue: SimpleQueue[tuple[str, Any]], on_event: Callable[[Event], None]
    ) -> None:
        """See the class; `queue` is the one that the worker and the signals put into."""
        self._job = job
        self._worker = worker
        self._queue = queue
        self._on_event = on_event
        self._place = Place("starting the worker")
        self._last_step: Place | None = None
        self._speaker = 0
        self._load_seconds = 0.0
        self._load_deadline = self._load_left = math.inf
        self._report: dict[str, Any] | None = None
        self._failure: dict[str, Any] | None = None
        self.said: defaultdict[int, list[str]] = defaultdict(list)
        self.warned: defaultdict[int, list[str]] = defaultdict(list)

    def until_done(self, started: float) -> dict[str, Any]:
        """What the worker reports in the end.

        Args:
            started: when the job's time began to run (`time.monotonic`).

        Raises:
            RunError: the worker failed or died, or its time ran out.
            Interrupted: a signal came.
        """
        given = math.inf if self._job.timeout is None else self._job.timeout
        open_streams = 2
        while open_streams:
            now = time.monotonic()
            if now >= started + given:
                raise RunTimeout(self._place, given)
            if now >= self._load_deadline:
                raise RunTimeout(self._place, self._load_seconds, is_given=False)
            deadline = min(started + given, self._load_deadline)
            try:
                kind, item = self._queue.get(timeout=min(_PULSE, deadline - now))
            except Empty:
                if self._report is not None or self._failure is not None or self._worker.has_ended():
                    break  # a process that the worker started holds its pipes open
                continue
            if kind == "signal":
                raise Interrupted
            if kind == "end":
                open_streams -= 1
            elif kind == "talk":
                self._hear(item)
            else:
                self._read(item)
        if self._report is not None:
            return self._report
        raise self._error()

    def _read(self, document: Mapping[str, Any]) -> None:
        event = decode_event(document)
        if event is not None:
            if isinstance(event, PhaseStarted):
                path = self._job.input if event.phase == "reading" else self._job.output
                self._place = Place(f"{event.phase} {path.name}")
                self._load_seconds = _LOAD_SECONDS + path.stat().st_size / _LOAD_RATE if event.phase == "reading" else math.inf
                self._load_deadline = time.monotonic() + self._load_seconds
            elif isinstance(event, StepStarted):
                self._last_step = self._place = self._step(event)
                self._load_deadline = self._load_left = math.inf
            elif isinstance(event, Compiling):
                self._pause_load(event)
            self._on_event(event)
        elif "done" in document:
            self._report = document["done"]
        elif "failed" in document:
            self._failure = dict(document)

    def _pause_load(self, event: Compiling) -> None:
        """Stop the time that reading has while filters are compiled, which a slow machine needs minutes for."""
        if event.is_going_on:
            self._load_left = self._load_deadline - time.monotonic()
            self._load_deadline = math.inf
        else:
            self._load_deadline = time.monotonic() + self._load_left

    def _step(self, event: StepStarted) -> Place:
        step = self._job.recipe.script.steps[event.index - 1]
        return Place.of_step(event.index, event.total, event.filter, file=self._job.recipe.script.path, line=step.line)

    def _hear(self, talk: Talk) -> None:
        if talk.step is not None:
            self._speaker = talk.step
        elif talk.fraction is not None:
            if self._speaker:
                self._on_event(StepProgress(self._speaker, talk.fraction))
        elif talk.level is not None and talk.text:
            (self.warned if talk.level == _WARNING else self.said)[self._speaker].append(talk.text)
            if self._speaker:
                self._on_event(Message(talk.text, "warning" if talk.level == _WARNING else "info", self._speaker))

    def _error(self) -> RunError:
        if self._failure is None:
            status = self._worker.wait()
            if self._place.doing.startswith("writing") and self._disk_is_full():
                return OutputError(self._job.output, "the disk is full")
            advice = "the file is probably damaged" if self._place.doing.startswith("reading") else ""
            details = "\n".join(self._worker.tail)
            return WorkerDied(self._place, status, details, memory_limit=self._job.memory_limit, advice=advice)
        kind, reason, path = (self._failure[key] for key in ("failed", "reason", "path"))
        if kind == "input":
            return InputError(Path(path), reason)
        if kind == "output":
            return OutputError(Path(path), "the disk is full" if self._disk_is_full() else reason)
        if kind == "memory":
            return OutOfMemory(self._place, self._job.memory_limit)
        if kind == "import":
            return RunError(f"MeshLab cannot be loaded: {reason}")
        if kind == "step":
            return StepFailedError(self._place if self._place.step else self._last_step or self._place, reason)
        return WorkerError(self._place, reason, "\n".join([self._failure["details"], *self._worker.tail]))

    def _disk_is_full(self) -> bool:
        try:
            return shutil.disk_usage(self._job.output.parent).free < _FULL
        except OSError:
            return False

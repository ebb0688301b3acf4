"""Follows the worker of a run until it is done, and turns every failure into an exception that says at which step it happened."""

from __future__ import annotations

import math
import shutil
import signal
import time
from collections import defaultdict, deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from queue import Empty

from ..errors import Place, RunError, StepFailedError
from ..files.errors import InputError, OutputError
from ..processes.order import Answer, DefectError
from ..processes.process import Items, Process
from .errors import OutOfMemory, RunTimeout, WorkerDied, WorkerError
from .interrupts import Interrupted
from .job import Compiling, Event, Job, Message, PhaseStarted, StepProgress, StepStarted
from .report import Report
from .talk import parse_talk

#: seconds between two looks at a silent worker
_PULSE = 0.5
#: bytes; a disk with less free space counts as full
_FULL = 1 << 20
#: MeshLab's level of log for warnings
_WARNING = 1
#: the last lines of talk that are kept for the report of a death
_TAIL_LINES = 60
#: seconds that reading any file may take, compilation not among them, and bytes a second besides: ten times as long as the
#: slowest format takes
_LOAD_SECONDS, _LOAD_RATE = 60.0, 1e6


class Watch:
    """Reads the events and the talk of one worker."""

    def __init__(self, job: Job, worker: Process, items: Items, on_event: Callable[[Event], None]) -> None:
        """See the class; `items` is what the worker and the signals put into."""
        self._job = job
        self._worker = worker
        self._items = items
        self._on_event = on_event
        self._place = Place("starting the worker")
        self._last_step: Place | None = None
        self._speaker = 0
        self._load_seconds = 0.0
        self._load_deadline = self._load_left = math.inf
        self._answer: Answer | None = None
        self._said: defaultdict[int, list[str]] = defaultdict(list)
        self._warned: defaultdict[int, list[str]] = defaultdict(list)
        self._tail: deque[str] = deque(maxlen=_TAIL_LINES)

    def until_done(self, started: float) -> Report:
        """What the worker reports in the end.

        Args:
            started: when the job's time began to run (`time.monotonic`).

        Raises:
            RunError: the worker failed or died, or its time ran out.
            Interrupted: a signal came.
        """
        timeout = math.inf if self._job.timeout is None else self._job.timeout
        missing = {"answer", "silent"}
        while missing:
            now = time.monotonic()
            if now >= started + timeout:
                raise RunTimeout(self._place, timeout)
            if now >= self._load_deadline:
                raise RunTimeout(self._place, self._load_seconds, is_given=False)
            deadline = min(started + timeout, self._load_deadline)
            try:
                kind, item = self._items.get(timeout=min(_PULSE, deadline - now))
            except Empty:
                if self._answer is not None:
                    break  # a process that the worker started holds its pipes open
                kind = "end" if self._worker.has_ended() else ""
            if kind == "signal":
                raise Interrupted
            if kind == "end" and self._answer is None:
                self._hear_the_rest()
                raise self._death()
            missing.discard(kind)
            if kind == "talk":
                self._hear(item)
            elif kind == "event":
                self._take(item)
            elif kind == "answer":
                self._answer = item
        assert self._answer is not None
        if self._answer.error is not None:
            raise self._failure(self._answer.error, self._answer.details)
        self._worker.is_idle = not missing and not self._answer.is_used_up
        return self._with_talk(self._answer.result, self._answer.peak_memory)

    def _take(self, event: Event) -> None:
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

    def _hear(self, line: str) -> None:
        talk = parse_talk(line)
        if talk.step is not None:
            self._speaker = talk.step
        elif talk.fraction is not None:
            if self._speaker:
                self._on_event(StepProgress(self._speaker, talk.fraction))
        else:
            self._tail.append(line)
            if talk.level is not None and talk.text:
                (self._warned if talk.level == _WARNING else self._said)[self._speaker].append(talk.text)
                if self._speaker:
                    self._on_event(Message(talk.text, "warning" if talk.level == _WARNING else "info", self._speaker))

    def _with_talk(self, report: Report, peak_memory: int | None) -> Report:
        """The report with what MeshLab said meanwhile."""
        warnings = [f"MeshLab says: {text}" for text in self._warned[0]]
        warnings += [f"step {n}: {text}" for n in sorted(self._warned) if n for text in self._warned[n]]
        steps = (
            replace(step, messages=(*self._said[number], *step.messages)) if self._said[number] else step
            for number, step in enumerate(report.steps, 1)
        )
        return replace(report, steps=tuple(steps), warnings=(*report.warnings, *warnings), peak_memory=peak_memory)

    def _hear_the_rest(self) -> None:
        """Read what a process that has ended said last."""
        with suppress(Empty):
            while (item := self._items.get(timeout=_PULSE))[0] != "end":
                if item[0] == "talk":
                    self._hear(item[1])

    def _death(self) -> RunError:
        status = self._worker.wait()
        if self._place.doing.startswith("writing") and self._disk_is_full():
            return OutputError(self._job.output, "the disk is full")
        is_crash = status != -getattr(signal, "SIGKILL", 0) and self._place.doing.startswith("reading")
        advice = "the file is probably damaged" if is_crash else ""
        limit = self._job.memory_limit
        return WorkerDied(self._place, status, "\n".join(self._tail), memory_limit=limit, advice=advice)

    def _failure(self, error: Exception, details: str) -> Exception:
        match error:
            case OutputError():
                return OutputError(error.path, "the disk is full") if self._disk_is_full() else error
            case InputError():
                return error
            case MemoryError():
                return OutOfMemory(self._place, self._job.memory_limit)
            case ImportError():
                return RunError(f"a library cannot be loaded: {error}")
            case StepFailedError():
                return StepFailedError(self._place if self._place.step else self._last_step or self._place, error.reason)
            case DefectError() | OSError():
                return WorkerError(self._place, str(error), "\n".join([details, *self._tail]))
        return error

    def _disk_is_full(self) -> bool:
        try:
            return shutil.disk_usage(self._job.output.parent).free < _FULL
        except OSError:
            return False

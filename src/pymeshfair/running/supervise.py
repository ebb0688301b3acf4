"""A run from the checks to the files in their places; the work between them is done in one piece by a worker, or by tiles.

Every failure of the worker becomes an exception that says at which step it happened.
"""

from __future__ import annotations

import math
import shutil
import signal
import time
from collections import defaultdict, deque
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Any, TypeAlias

from ..errors import Place, RunError, StepFailedError
from ..files.errors import InputError, OutputError
from ..files.inputs import check_input
from ..files.outputs import check_maps, check_output
from ..files.provenance import formatted, provenance_path
from ..files.writing import StagedFile, clear_up, output_lock, place, remove_folder, stage_file, staging_folder
from ..operating_system import this_system
from ..processes.order import DefectError, Order
from ..processes.pool import Pool
from ..processes.process import Items, LostProcessError, Process
from ..processes.worker import report as report_event
from ..scripts.guards import refuse_unmeasured
from ..scripts.warnings import check_needs
from .errors import GuardBroken, OutOfMemory, RunTimeout, WorkerDied, WorkerError
from .interrupts import Interrupted, Interrupts
from .job import Compiling, Event, Job, Message, PhaseStarted, RunResult, StepProgress, StepStarted
from .origins import removed_path
from .report import Report, record_of, result_of
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
        self._said: defaultdict[int, list[str]] = defaultdict(list)
        self._warned: defaultdict[int, list[str]] = defaultdict(list)
        self._tail: deque[str] = deque(maxlen=_TAIL_LINES)

    def until_done(self, order: Order, started: float) -> Report:
        """The report of the worker to which the order is given, of a job that began at `started` (`time.monotonic`)."""
        timeout = math.inf if self._job.timeout is None else self._job.timeout

        def pulse() -> float:
            now = time.monotonic()
            if now >= started + timeout:
                raise RunTimeout(self._place, timeout)
            if now >= self._load_deadline:
                raise RunTimeout(self._place, self._load_seconds, is_given=False)
            return min(_PULSE, started + timeout - now, self._load_deadline - now)

        try:
            answer = self._worker.do(order, self._take_item, items=self._items, pulse=pulse)
        except LostProcessError as error:
            raise self._death(error.status) from None
        if answer.error is not None:
            self._worker.is_idle = False  # what a failed run has left in memory is not for the next one
            raise self._failure(answer.error, answer.details)
        return self._with_talk(answer.result, answer.peak_memory)

    def _take_item(self, kind: str, item: Any) -> None:
        if kind == "signal":
            raise Interrupted
        if kind == "talk":
            self._hear(item)
        elif kind == "event":
            self._take(item)

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

    def _death(self, status: int) -> RunError:
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


#: the modules that a worker of a run imports before its first order
MODULES = ("pymeshfair.running.session",)
#: does the work of a run: is given the job, the staging folder, what takes signals, and what to call with each event
Work: TypeAlias = "Callable[[Job, Path, Items, Callable[[Event], None]], Report]"


def workers_of_runs(most: int = 1, threads: int | None = None, *, rest_after: float | None = None) -> Pool:
    """Processes for `run_job`, see `pymeshfair.processes.pool.Pool`."""
    return Pool(most, threads, MODULES, rest_after=rest_after)


def run_job(
    job: Job,
    on_event: Callable[[Event], None] = lambda event: None,
    *,
    workers: Pool | None = None,
    work: Work | None = None,
    also: Callable[[RunResult], Sequence[StagedFile]] | None = None,
) -> RunResult:
    """Carry out a job: everything is checked, the work is done, and the files appear whole or not at all.

    Args:
        job: what to do.
        on_event: called with each event, in this thread. An exception that it raises stops the run and is passed on.
        workers: lends the process that does the work; None starts one.
        work: does the work otherwise.
        also: makes further files, which appear with the output or not at all. It is given the result while the output, its side
            files and its provenance are still in the staging folder, all in one.

    Raises:
        ScriptError: a step needs layers or rasters that the run does not have.
        ParameterError: there are limits, but no measures are to be taken; or one has a unit, and that of the scan is not known.
        InputError: the input, or another file, cannot be read.
        OutputError: the output cannot or must not be written.
        StepFailedError: a filter could not do its work.
        WorkerDied: the worker process crashed or was killed.
        GuardBroken: the result goes beyond a limit.
        RunTimeout, OutOfMemory: the run needed more than it was given.
        KeyboardInterrupt: Ctrl-C, within a second, after everything has been cleaned up.
    """
    started, clock = datetime.now(timezone.utc), time.monotonic()
    others = tuple(Path(other).absolute() for other in job.others)
    job = replace(job, input=Path(job.input).absolute(), output=Path(job.output).absolute(), others=others)
    check_needs(job.recipe.script, layers=1 + len(others))
    job.check_unit()
    if not job.measures:
        refuse_unmeasured(job.all_guards)
    for path in (job.input, *others):
        check_input(path)
    if job.map is not None:
        job = replace(job, map=Path(job.map).absolute())
    _check_outputs(job)
    items: Items = SimpleQueue()
    with (
        Interrupts(items) as interrupts,
        output_lock(job.output),
        staging_folder(job.output) as stage,
        nullcontext(workers) if workers else workers_of_runs(1, job.threads) as pool,
    ):
        report = (work or partial(_in_one_piece, pool, clock))(job, stage, items, on_event)
        interrupts.check()
        seconds = time.monotonic() - clock
        if report.output is None:
            _check_outputs(job)  # again, as files may have come meanwhile
            place(report.maps, stage)
            raise GuardBroken(report.breaches, [file.target for file in report.maps])
        record = record_of(job, report, started=started, seconds=seconds)
        provenance = stage_file(stage / "provenance.json", provenance_path(job.output), formatted(record))
        output, *side_files = report.staged
        more: Sequence[StagedFile] = ()
        if also is not None:
            staged = result_of(job, record, [file.staged for file in side_files], [file.staged for file in report.maps])
            with interrupts.lifted():
                more = also(replace(staged, output=output.staged, provenance=provenance.staged))
        interrupts.check()
        _check_outputs(job)
        place([*side_files, *report.maps, *more, output, provenance], stage, outdated=provenance.target)
        remove_folder(stage)  # while the worker lives, which removes it if this process is killed meanwhile
    return result_of(job, record, [file.target for file in side_files], [file.target for file in report.maps])


def _check_outputs(job: Job) -> None:
    """Refuse files that cannot or must not be written."""
    check_output(job.output, job.made_from, overwrite=job.overwrite)
    if job.map is not None:
        check_maps((job.map, removed_path(job.map)), job.output, job.made_from, overwrite=job.overwrite)


def _in_one_piece(pool: Pool, started: float, job: Job, stage: Path, items: Items, on_event: Callable[[Event], None]) -> Report:
    """Let one process do the work."""
    limit = this_system().usable_memory() if job.memory_limit is None else job.memory_limit
    if_lost = partial(clear_up, stage, job.output)
    order = Order.of(carry_out, job, stage, memory_limit=limit, if_lost=if_lost)
    with pool.lend() as worker:
        return Watch(job, worker, items, on_event).until_done(order, started)


def carry_out(job: Job, stage: Path) -> Report:
    """The work of a run, in the process that does it."""
    from .session import Session

    return Session(job, stage, report_event).run()

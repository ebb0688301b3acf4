"""Supervises a run: checks, locks, stages and places the files. One worker process does the work, or several do it by tiles."""

from __future__ import annotations

import contextlib
import math
import re
import shutil
import signal
import threading
import time
from collections import defaultdict, deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from types import FrameType, TracebackType
from typing import Any, TypeAlias

from ..errors import GuardBroken, OutOfMemory, Place, RunError, RunTimeout, WorkerDied, WorkerError
from ..files.errors import OutputError
from ..files.inputs import check_input
from ..files.outputs import check_maps, check_output
from ..files.provenance import formatted, provenance_path, read_provenance, recorded_digest
from ..files.writing import StagedFile, clear_up, output_lock, place, remove_folder, stage_file, staging_folder
from ..operating_system import this_system
from ..processes.process import Items, LostProcessError, Pool, Process
from ..processes.worker import DefectError, Order, says_lack_of_memory
from ..processes.worker import report as report_event
from ..scripts.guards import refuse_unmeasured
from ..scripts.warnings import check_needs
from .job import Compiling, Event, Job, Message, PhaseStarted, Report, RunResult, StepProgress, StepStarted

_PULSE = 0.5  # seconds between two checks of the time limits
_FULL = 1 << 20  # bytes; a disk with less free space counts as full
_WARNING = 1  # MeshLab's log level for warnings
_TAIL_LINES = 60  # how many of the last lines on stderr an error shows
#: time limit until the first step, without compilation: seconds + bytes of files / rate; the slowest format needs a tenth of it
_LOAD_SECONDS, _LOAD_RATE = 60.0, 1e6


class Interrupted(BaseException):
    """A signal asks for the end of the run. Raised only in blocks of `Interrupts`."""


class Interrupts:
    """Defers SIGINT, SIGTERM and SIGHUP: inside the block they go into a queue; after it the first signal has its usual effect.

    So no signal interrupts the clean-up. Handlers that the program has set stay. Outside of the main thread nothing is deferred.
    """

    def __init__(self, queue: SimpleQueue[tuple[str, Any]]) -> None:
        self._queue = queue  # gets ``("signal", number)``
        self._previous: dict[int, Any] = {}
        self._first: int | None = None

    def check(self) -> None:
        if self._first is not None:
            raise Interrupted

    @contextlib.contextmanager
    def lifted(self) -> Iterator[None]:
        """Restore the usual effect of signals inside the block, for work that handles signals itself."""
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


_MARK = "pymeshfair-step"
_LOG = re.compile(r"LOG: (\d+) (.*?)\s*(?:\[ (\d{1,3})% \])?\s*")
#: lines that say that nothing was done, and lines with numbers that are also among the step's values
_NOTHING = re.compile(
    r"(?:Successfully )?(?:removed|deleted|split|closed) 0 .*|Nothing done: .*"
    r"|\|.*\||(?:Inertia Tensor is|Principal axes are|axis momenta are) :",
    re.IGNORECASE,
)


def mark(step: int) -> bytes:
    """The line on stderr that assigns the following lines to a step; 0 for no step."""
    return f"\n{_MARK} {step}\n".encode("ascii")


@dataclass(frozen=True)
class Talk:
    """One line that a worker wrote to stderr."""

    text: str  # the line without MeshLab's prefix; empty for a mark, and for the lines of `_NOTHING`
    level: int | None = None  # MeshLab's log level (0 system, 1 warning, 2 filter, 3 debug); None if the line is not MeshLab's
    fraction: float | None = None  # the progress of a filter, from 0 to 1, if the line reports it
    step: int | None = None  # the step that begins here, if the line is a mark


def parse_talk(line: str) -> Talk:
    """Parse a line."""
    words = line.split()
    if len(words) == 2 and words[0] == _MARK and words[1].isdigit():
        return Talk("", step=int(words[1]))
    match = _LOG.fullmatch(line)
    if match is None:
        return Talk(line)
    level, text, percent = match.groups()
    text = "" if _NOTHING.fullmatch(text.strip()) else text.strip()
    return Talk(text, int(level), None if percent is None else min(int(percent), 100) / 100)


class Watch:
    """Reads the events of one worker and its lines on stderr."""

    def __init__(self, job: Job, worker: Process, items: Items, on_event: Callable[[Event], None]) -> None:
        self._job, self._worker, self._items, self._on_event = job, worker, items, on_event
        self._place = Place("starting the worker")
        self._step = 0  # the step to which lines on stderr belong; 0 for none
        self._load_seconds = self._load_deadline = math.inf
        self._texts: defaultdict[tuple[int, bool], list[str]] = defaultdict(list)  # by step, and by whether they are warnings
        self._tail: deque[str] = deque(maxlen=_TAIL_LINES)

    def until_done(self, order: Order, started: float) -> Report:
        """Give the order to the worker and return its report; the job began at `started` (`time.monotonic`)."""
        timeout = math.inf if self._job.timeout is None else self._job.timeout

        def pulse() -> float:
            now = time.monotonic()
            if now >= started + timeout:
                raise RunTimeout(self._place, timeout)
            if now >= self._load_deadline:
                raise RunTimeout(self._place, self._load_seconds, is_given=False)
            return min(_PULSE, started + timeout - now, self._load_deadline - now)

        try:
            answer = self._worker.do(order, self._take, items=self._items, pulse=pulse)
        except LostProcessError as error:
            raise self._death(error.status) from None
        if answer.error is not None:
            self._worker.is_idle = False  # a failed run may leave memory in use
            raise self._failure(answer.error, answer.details)
        return self._with_talk(answer.result, answer.peak_memory)

    def _take(self, kind: str, event: Any) -> None:
        if kind == "signal":
            raise Interrupted
        if kind == "talk":
            self._take_line(event)
        if kind != "event":
            return
        if isinstance(event, PhaseStarted):
            files = (self._job.input, *self._job.others) if event.phase == "reading" else ()
            self._place = Place(f"{event.phase} {(*files, self._job.output)[0].name}")
            self._load_seconds = _LOAD_SECONDS + sum(path.stat().st_size for path in files) / _LOAD_RATE if files else math.inf
        elif isinstance(event, StepStarted):
            script = self._job.recipe.script
            line = script.steps[event.index - 1].line
            self._place = Place.of_step(event.index, event.total, event.filter, file=script.path, line=line)
            self._load_seconds = math.inf
        if isinstance(event, PhaseStarted | StepStarted | Compiling):
            compiles = isinstance(event, Compiling) and event.is_going_on  # compilation can delay reading by minutes
            self._load_deadline = math.inf if compiles else time.monotonic() + self._load_seconds
        self._on_event(event)

    def _take_line(self, line: str) -> None:
        talk = parse_talk(line)
        if talk.step is not None:
            self._step = talk.step
        elif talk.fraction is not None:
            if self._step:
                self._on_event(StepProgress(self._step, talk.fraction))
        else:
            self._tail.append(line)
            if talk.level is not None and talk.text:
                is_warning = talk.level == _WARNING
                self._texts[self._step, is_warning].append(talk.text)
                if self._step:
                    self._on_event(Message(talk.text, "warning" if is_warning else "info", self._step))

    def _with_talk(self, report: Report, peak_memory: int | None) -> Report:
        warned = sorted(step for step, is_warning in self._texts if is_warning)
        warnings = [f"step {n}: {text}" if n else f"MeshLab says: {text}" for n in warned for text in self._texts[n, True]]
        steps = [replace(step, messages=(*self._texts[n, False], *step.messages)) for n, step in enumerate(report.steps, 1)]
        return replace(report, steps=tuple(steps), warnings=(*report.warnings, *warnings), peak_memory=peak_memory)

    def _death(self, status: int) -> RunError:
        if self._place.doing.startswith("writing") and self._disk_is_full():
            return OutputError(self._job.output, "the disk is full")
        tail, limit = "\n".join(self._tail), self._job.memory_limit
        if says_lack_of_memory(tail):
            return OutOfMemory(self._place, limit)
        is_crash = status != -getattr(signal, "SIGKILL", 0) and self._place.doing.startswith("reading")
        advice = "the file is probably damaged" if is_crash else ""
        return WorkerDied(self._place, status, tail, memory_limit=limit, advice=advice)

    def _failure(self, error: Exception, details: str) -> Exception:
        match error:
            case OutputError():
                return OutputError(error.path, "the disk is full") if self._disk_is_full() else error
            case MemoryError():
                return OutOfMemory(self._place, self._job.memory_limit)
            case ImportError():
                return RunError(f"a library cannot be loaded: {error}")
            case DefectError() | OSError():
                return WorkerError(self._place, str(error), "\n".join([details, *self._tail]))
        return error

    def _disk_is_full(self) -> bool:
        with contextlib.suppress(OSError):
            return shutil.disk_usage(self._job.output.parent).free < _FULL
        return False


MODULES = ("pymeshfair.running.session",)  # what a worker imports while it waits for its first order
#: does the work of a run, given the job, the staging folder, the queue of signals, and the callback for events
Work: TypeAlias = "Callable[[Job, Path, Items, Callable[[Event], None]], Report]"


def workers_of_runs(most: int = 1, threads: int | None = None, *, rest_after: float | None = None) -> Pool:
    """Processes for `run_job`, see `pymeshfair.processes.process.Pool`."""
    return Pool(most, threads, MODULES, rest_after=rest_after)


def run_job(
    job: Job,
    on_event: Callable[[Event], None] = lambda event: None,
    *,
    workers: Pool | None = None,
    work: Work | None = None,
    also: Callable[[RunResult], Sequence[StagedFile]] | None = None,
) -> RunResult:
    """Carry out a job: check everything, do the work, and write all files completely, or none.

    `on_event` is called with each event, in this thread; an exception that it raises stops the run and is passed on. `workers`
    lends the process that does the work (None starts one); `work` does it in place of one process. `also` makes further staged
    files from the staged result; they are placed together with the output. After Ctrl-C everything is cleaned up within a
    second. If a guard is broken, only maps are written, and `GuardBroken` is raised, unless the job has `keep_broken`.
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
        contextlib.nullcontext(workers) if workers else workers_of_runs(1, job.threads) as pool,
    ):
        report = (work or partial(_in_one_piece, pool, clock))(job, stage, items, on_event)
        interrupts.check()
        seconds = time.monotonic() - clock
        former_maps = set(job.map_files) - {file.target for file in report.maps}
        if report.output is None:
            _check_outputs(job)  # again, as other programs may have written files since
            place(report.maps, stage, outdated=[*former_maps])
            raise GuardBroken(report.breaches, [file.target for file in report.maps])
        record = report.record(job, started=started, seconds=seconds)
        provenance = stage_file(stage / "provenance.json", provenance_path(job.output), formatted(record))
        output, *side_files = report.staged
        further: Sequence[StagedFile] = ()
        if also is not None:
            staged = RunResult.of(job, record, [file.staged for file in side_files], [file.staged for file in report.maps])
            with interrupts.lifted():
                further = also(replace(staged, output=output.staged, provenance=provenance.staged))
        interrupts.check()
        _check_outputs(job)
        files = [*side_files, *report.maps, output, *further]
        # With its provenance in place, a killed run can be repeated; so it comes first, unless an output with other bytes exists.
        if not job.output.exists() or recorded_digest(read_provenance(job.output), job.output) == report.output["sha256"]:
            place([provenance, *files], stage, outdated=[*former_maps])
        else:
            place([*files, provenance], stage, outdated=[provenance.target, *former_maps])
        remove_folder(stage)  # while the worker still runs: if this process is killed here, the worker removes it
    return RunResult.of(job, record, [file.target for file in side_files], [file.target for file in report.maps])


def _check_outputs(job: Job) -> None:
    check_output(job.output, job.made_from, overwrite=job.overwrite)
    if job.map is not None:
        check_maps(job.map_files, job.output, job.made_from, overwrite=job.overwrite)


def _in_one_piece(pool: Pool, started: float, job: Job, stage: Path, items: Items, on_event: Callable[[Event], None]) -> Report:
    limit = this_system().usable_memory() if job.memory_limit is None else job.memory_limit
    order = Order.of(carry_out, job, stage, memory_limit=limit, if_lost=partial(clear_up, stage, job.output))
    with pool.lend() as worker:
        return Watch(job, worker, items, on_event).until_done(order, started)


def carry_out(job: Job, stage: Path) -> Report:
    """Does the work in this process."""
    from .session import Session

    return Session(job, stage, report_event).run()

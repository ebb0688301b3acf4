"""Carries out a batch, from its plan to its summary: a process lent by a pool cleans each scan or draws its page."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cache
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeAlias

from ..errors import OutOfMemory, ParameterError, RunError, WorkerDied
from ..files.errors import OutputBusyError
from ..files.formats import extension
from ..files.inputs import check_input
from ..files.outputs import check_output
from ..files.provenance import read_provenance, sha256_of
from ..files.writing import check_place, check_target
from ..operating_system import this_system
from ..processes.cluster import ClusterError, LostSchedulerError, Scheduler
from ..processes.environment import PACKAGES, packages_here
from ..processes.process import Items, Pool
from ..running.job import Job, RunResult
from ..running.supervise import Interrupted, Interrupts, run_job, workers_of_runs
from ..scripts.warnings import check_needs
from .outcomes import DOCUMENT, NAME, TABLE, BatchError, Journal, Outcome, Summary, now, read_journal
from .page import NAME as PAGE
from .page import draw, page_path, write_page
from .plan import Scan, job_of, sample

if TYPE_CHECKING:
    from .cluster import DaskWorkers

_PATIENCE = 20.0  # seconds of new tries while an output is busy: a lost worker may still remove its files
_PULSE = 1.0  # seconds between checks of workers
_GROWTH = 2.0  # the largest expected ratio of output to input bytes: double in place of single precision
_READERS = 4  # threads that read files and compute their checksums
Kind: TypeAlias = Literal["clean", "draw"]


@dataclass(frozen=True)
class Station:
    """Does tasks of a batch in this process and in processes of its pool. Several threads may use it."""

    template: Job  # the options that all runs share
    folder: Path  # of the batch
    pool: Pool  # lends processes, see `pool_of`; each gets an equal share of processors and memory

    def submit(self, kind: Kind, scan: Scan) -> Future[Any]:
        return self.pool.call(self.do, kind, scan)

    def end(self) -> None:
        self.pool.close()

    def check(self) -> str | None:
        """Returns None: only the workers of a scheduler can be lost, see `DaskWorkers.check`."""
        return None

    def do(self, kind: Kind, scan: Scan) -> Any:
        """Does a task in this thread. "clean" returns the `Outcome`, "draw" why there is no page, or "" if there is one."""
        usable = this_system().usable_memory()
        share = None if usable is None else usable // self.pool.most
        if kind == "clean":
            return self._clean(scan, share)
        page, memory = page_path(self.folder, scan.output), self.template.memory_limit or share
        try:
            draw(scan.input, scan.output, page, memory=memory, overwrite=self.template.overwrite, workers=self.pool)
        except Exception as error:
            return str(error) or type(error).__name__
        return ""

    def _clean(self, scan: Scan, memory: int | None) -> Outcome:
        started, host = time.monotonic(), socket.gethostname()
        try:
            record = self._run(job_of(self.template, scan, threads=_share_of_threads(self.pool.most), memory=memory)).record
            return replace(Outcome.of_record(record, scan.input, scan.output), finished=now(), host=host)
        except Exception as error:
            return Outcome.of_error(scan.input, scan.output, error, time.monotonic() - started, host)

    def _run(self, job: Job) -> RunResult:
        from ..tiles.course import can_be_cut, run_by_tiles

        deadline, is_first = time.monotonic() + _PATIENCE, True
        job.output.parent.mkdir(parents=True, exist_ok=True)
        while True:
            try:
                return run_job(job, workers=self.pool)
            except OutputBusyError:
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.2)
            except OutOfMemory:
                if not can_be_cut(job):
                    raise
                note = "the run needed more memory than it was given, so the scan was cut into tiles"
                return run_by_tiles(replace(job, warnings=(*job.warnings, note)), check_wanted=self.pool.check_open)
            except WorkerDied as error:
                if error.signal != "SIGKILL" or not is_first:
                    raise
                is_first = False  # killed by a user, or because parallel runs took the memory
            self.pool.check_open()


def _share_of_threads(slots: int) -> int:
    return max(1, this_system().processors() // slots)


def pool_of(slots: int, *, rest_after: float | None = None) -> Pool:
    """Makes a pool of processes for `slots` parallel tasks, see `Pool`."""
    return workers_of_runs(slots, _share_of_threads(slots), rest_after=rest_after)


class Listener(Protocol):
    """Receives the events of a batch, in the thread that runs it. An exception in a method ends the batch."""

    def begin(self, total: int) -> None: ...  # the number of scans to do
    def outcome(self, scan: Scan, outcome: Outcome) -> None: ...  # a scan has ended; its outcome is in the journal
    def page(self, scan: Scan, problem: str) -> None: ...  # a page was drawn, or `problem` says why not
    def note(self, text: str) -> None: ...  # a message for the user, about the workers, the journal or the disk


@dataclass
class BatchRun:
    """Cleans scans, reports each outcome after it is in the journal, and draws the pages of cleaned scans."""

    workers: Station | DaskWorkers
    journal: Journal
    items: Items  # the queue of signals and finished tasks
    listener: Listener
    outcomes: dict[int, Outcome]  # by number of the scan; `run` adds the new outcomes
    draws: bool  # draw pages
    stop: bool  # see `Task`
    pages: dict[str, str] = field(default_factory=dict)  # by output: why there is no page; empty if there is one
    tasks: dict[Future[Any], tuple[Kind, Scan]] = field(default_factory=dict)  # unfinished tasks

    def run(self, scans: Sequence[Scan], drawn: Sequence[Scan]) -> None:
        """Cleans `scans`, and draws the pages of the scans `drawn`, which an earlier batch cleaned."""
        try:
            for scan in scans:
                self._submit("clean", scan)
            for scan in drawn:
                self._submit("draw", scan)
            while self.tasks:
                self._next()
        finally:
            self.workers.end()

    def _submit(self, kind: Kind, scan: Scan) -> None:
        future = self.workers.submit(kind, scan)
        self.tasks[future] = kind, scan
        future.add_done_callback(lambda done: self.items.put(("done", done)))

    def _next(self) -> None:
        try:
            kind, item = self.items.get(timeout=_PULSE)
        except Empty:
            if note := self.workers.check():
                self.listener.note(note)
            return
        if kind == "signal":
            if threading.current_thread() is threading.main_thread():
                signal.signal(signal.SIGINT, lambda number, frame: os._exit(130))
            raise Interrupted
        kind, scan = self.tasks.pop(item)
        try:
            result = item.result()
        except CancelledError:
            raise LostSchedulerError from None
        except Exception as error:
            self.workers.check()
            lost = ClusterError(f"the workers that had the scan were lost: {error}")
            result = str(lost) if kind == "draw" else Outcome.of_error(scan.input, scan.output, lost, 0.0, "")
        if kind == "draw":
            self.pages[str(scan.output)] = result
            self.listener.page(scan, result)
            return
        self.journal.append(result)
        self.outcomes[scan.number] = result
        self.listener.outcome(scan, result)
        if result.status != "done" and self.stop:
            self.tasks.clear()
        elif result.status != "failed" and self.draws:
            self._submit("draw", scan)


def done_before(scans: Sequence[Scan], template: Job, journal: Mapping[str, Outcome]) -> dict[int, Outcome]:
    """Returns, by scan number, the outcomes of scans whose output fits the present input, recipe, options, guards and versions.

    An output that breaks a guard counts only with `Job.keep_broken`. `journal` adds details that the provenance lacks.
    """
    digest, packages = cache(sha256_of), packages_here()

    def outcome_of(scan: Scan) -> Outcome | None:
        record = read_provenance(scan.output)
        if record is None:
            return None
        try:
            job = replace(template, recipe=scan.recipe)
            limits = job.all_guards.in_mesh_units(job.unit_of(record["input"].get("unit"))).texts()
            made_by = scan.recipe.digest, template.options, limits, packages
            if _made_by(record) != made_by or not _is_whole(record, scan, template.others, digest):
                return None
            outcome = Outcome.of_record(record, scan.input, scan.output)
        except (KeyError, TypeError, ValueError, OSError, ParameterError):  # a document of another program, or a file is gone
            return None
        if outcome.status == "broken" and not template.keep_broken:
            return None
        former = journal.get(str(scan.output))
        told = former if former is not None and former.digests == outcome.digests else outcome
        return replace(told, input=outcome.input, status=outcome.status, breaches=outcome.breaches, resumed=True)

    with ThreadPoolExecutor(_READERS) as pool:
        return {scan.number: outcome for scan, outcome in zip(scans, pool.map(outcome_of, scans), strict=True) if outcome}


def _made_by(record: Mapping[str, Any]) -> tuple[Any, ...]:
    return (
        record["recipe"]["sha256"],
        {name: value for name, value in record.get("options", {}).items() if name != "own_texture_names"},
        record.get("guards", {}).get("limits", {}),
        {name: record["versions"].get(name) for name in PACKAGES},
    )


def _is_whole(record: Mapping[str, Any], scan: Scan, layers: Sequence[Path], digest: Callable[[Path], str]) -> bool:
    """Returns whether input, layers, output and their side files match the record; a file may have moved with its side files."""

    def are_there(file: Path, former: Mapping[str, Any]) -> bool:
        sides = former["side_files"]
        places = [file.parent / os.path.relpath(side["path"], Path(former["path"]).parent) for side in sides]
        pairs = zip((file, *places), (former, *sides), strict=True)
        return all(path.is_file() and digest(path) == entry["sha256"] for path, entry in pairs)

    read, made = record["input"], record["output"]
    if Path(made["path"]).name != scan.output.name or len(layers) != len(read["others"]):
        return False
    files = ((scan.input, read), (scan.output, made), *zip(layers, read["others"], strict=True))
    return all(are_there(path, former) for path, former in files)


@dataclass(frozen=True)
class Prospect:
    """A preview of a batch."""

    states: Mapping[int, str]  # by number of the scan: ``"to do"``, ``"done"`` or ``"cannot be done"``
    problems: Mapping[int, str]  # by number: the reasons why scans cannot be done
    bytes_in: int  # total size of the readable inputs of scans that are not done
    bytes_free: int | None  # on the disk of the outputs; None if unknown

    @property
    def lacks_room(self) -> bool:
        return self.bytes_free is not None and self.bytes_free < _GROWTH * self.bytes_in


@dataclass
class Task:
    """One batch."""

    scans: Sequence[Scan]
    template: Job  # see `Station`
    folder: Path  # of outputs, an absolute path; is made if it does not exist
    scheduler: Scheduler | None  # of dask; None for this machine
    jobs: int  # the number of scans cleaned at a time on this machine
    _: KW_ONLY
    resume: bool = False  # skip scans that are done
    stop: bool = False  # stop after the first scan that fails or breaks a guard
    sample: int | None = None  # do only this number of scans, spread over all sizes
    report: bool = False  # make a page for every cleaned scan, and one for the batch
    written: tuple[Path, ...] = field(default=(), init=False)  # the files about the whole batch

    def look_ahead(self) -> Prospect:
        if self.folder.is_dir():
            self._check_own_files()
        return self._prospect(self._done(read_journal(self.folder / NAME)))

    def _prospect(self, done: Collection[int]) -> Prospect:
        """Checks all that can be checked without reading a mesh; `done` has the numbers of finished scans."""
        template = self.template
        check_needs(template.recipe.script, layers=1 + len(template.others))
        for path in template.others:
            check_input(path)
        problems, size = {}, 0
        for scan in self.scans:
            if scan.number in done:
                continue
            job = replace(template, input=scan.input, recipe=scan.recipe)
            job.check_unit()
            try:
                check_input(scan.input)
                size += scan.input.stat().st_size
                check_output(scan.output, job.made_from, overwrite=template.overwrite, makes_folder=True)
            except (RunError, OSError) as error:
                problems[scan.number] = str(error)
        states = {scan.number: "done" if scan.number in done else "to do" for scan in self.scans}
        free = None
        with suppress(OSError):
            existing = next((parent for parent in (self.folder, *self.folder.parents) if parent.exists()), self.folder)
            free = shutil.disk_usage(existing).free
        return Prospect(states | dict.fromkeys(problems, "cannot be done"), problems, size, free)

    def _check_own_files(self) -> None:
        """Refuses to replace batch files without `overwrite`, unless a batch's journal, empty or with outcomes, is there."""
        journal = self.folder / NAME
        is_ours = check_place(journal) and bool(read_journal(journal) or not journal.stat().st_size)
        for name in (NAME, TABLE, DOCUMENT, *([PAGE] if self.report else [])):
            check_target(self.folder / name, (extension(Path(name)),), overwrite=self.template.overwrite or is_ours)

    def _done(self, journal: Mapping[str, Outcome]) -> dict[int, Outcome]:
        return done_before(self.scans, self.template, journal) if self.resume else {}

    @contextmanager
    def processes(self) -> Iterator[Pool | None]:
        """Starts processes of this machine for `carry_out`, or yields None if a scheduler has the workers."""
        if self.scheduler is not None:
            yield None
            return
        with pool_of(min(self.jobs, len(self.scans))) as pool:
            pool.prepare()
            yield pool

    def carry_out(self, listener: Listener, pool: Pool | None = None) -> Summary:
        """Does the batch; writes outcomes to ``batch.json`` and ``batch.csv``, also after Ctrl-C; a report to ``batch.html``."""
        started, clock = now(), time.monotonic()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BatchError(f"cannot make the folder {self.folder}: {error.strerror or error}") from error
        self._check_own_files()
        with Journal(self.folder, resume=self.resume) as journal:
            outcomes = self._done(journal.before)
            if journal.before and not self.resume:
                listener.note(
                    f"the journal of {len(journal.before):,} scans in {self.folder} is replaced; --resume would continue it"
                )
            if self._prospect(outcomes).lacks_room:
                listener.note(f"the disk of {self.folder} may be too small: outputs may need twice the size of the inputs")
            todo = [scan for scan in self.scans if scan.number not in outcomes]
            drawn = [scan for scan in self.scans if scan.number in outcomes and self.report]
            if self.sample is not None:
                todo = sample(todo, self.sample)
            listener.begin(len(todo))
            pages: Mapping[str, str] = {}
            try:
                if todo or drawn:
                    with self._workers(todo or drawn, pool) as (workers, items):
                        run = BatchRun(workers, journal, items, listener, outcomes, self.report, self.stop)
                        run.run(todo, drawn)
                        pages = run.pages
            finally:
                ordered = [outcomes[scan.number] for scan in self.scans if scan.number in outcomes]
                summary = Summary(ordered, len(self.scans), self.template, started, now(), time.monotonic() - clock)
                if outcomes:  # without outcomes the files of a former batch stay
                    self.written = (*summary.write(self.folder), journal.path)
            if self.report and outcomes:
                self.written += (write_page(self.folder, summary, pages),)
        return summary

    @contextmanager
    def _workers(self, scans: Sequence[Scan], pool: Pool | None) -> Iterator[tuple[Station | DaskWorkers, Items]]:
        """Opens the workers for scans, and a queue of finished tasks and signals; raises `ClusterError` if workers are unfit."""
        items: Items = SimpleQueue()
        if self.scheduler is None:
            with Interrupts(items):
                yield Station(self.template, self.folder, pool or pool_of(self.jobs)), items
            return
        from .cluster import workers_of_scheduler

        with workers_of_scheduler(self.scheduler, self.template, scans, self.folder) as workers, Interrupts(items):
            yield workers, items

"""Does the tasks of a batch: the workers of a machine, and the loop that gives them scans and writes down the outcomes.

Each scan is cleaned, and its page drawn, in a process that is lent for it.
"""

from __future__ import annotations

import os
import signal
import socket
import threading
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from queue import Empty
from typing import Any, Literal, Protocol, TypeAlias

from ..errors import OutOfMemory, WorkerDied
from ..files.errors import OutputBusyError
from ..operating_system import this_system
from ..processes.cluster import LostSchedulerError
from ..processes.pool import Pool
from ..processes.process import Items
from ..running.job import Job, RunResult
from ..running.supervise import Interrupted, run_job, workers_of_runs
from .journal import Journal, Outcome, now
from .page import draw, page_path
from .plan import Scan, job_of

#: seconds to wait for another run of the same output: of a lost worker, which may still be clearing up
_PATIENCE = 20.0
#: the work on a scan: it is cleaned, or its page is drawn
Kind: TypeAlias = Literal["clean", "draw"]


def share_of_threads(slots: int) -> int:
    """The threads of each of so many tasks at a time."""
    return max(1, this_system().processors() // slots)


def pool_of(slots: int, *, rest_after: float | None = None) -> Pool:
    """Processes for so many tasks at a time, see `pymeshfair.processes.pool.Pool`."""
    return workers_of_runs(slots, share_of_threads(slots), rest_after=rest_after)


@dataclass(frozen=True)
class Station:
    """Does the tasks of a batch in this process and those that it starts. May be used from several threads."""

    template: Job  # the options that all runs share
    folder: Path  # of the batch
    slots: int  # tasks at a time; each takes its share of processors and memory
    pool: Pool  # lends the processes, see `pool_of`; tasks fail once it is closed

    def do(self, kind: Kind, scan: Scan) -> Any:
        """Do a task in this thread: an `Outcome`, or what `draw` gives, with ``"problem"`` the reason why there is no page."""
        if kind == "clean":
            return self._clean(scan)
        memory, overwrite = self.template.memory_limit or self._memory(), self.template.overwrite
        page = page_path(self.folder, scan.output)
        try:
            return draw(scan.input, scan.output, page, memory=memory, overwrite=overwrite, workers=self.pool)
        except Exception as error:
            return {"problem": str(error)}

    def _memory(self) -> int | None:
        """Bytes that a task may take by default."""
        memory = this_system().usable_memory()
        return None if memory is None else memory // self.slots

    def _clean(self, scan: Scan) -> Outcome:
        started, host = time.monotonic(), socket.gethostname()
        try:
            job = job_of(self.template, scan, threads=share_of_threads(self.slots), memory=self._memory())
            record = self._run(job).record
            return replace(Outcome.of_record(record, job.input, job.output), finished=now(), host=host)
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
                note = "it needed more memory than it was given, so that it was cut into tiles"
                return run_by_tiles(replace(job, warnings=(*job.warnings, note)), check_wanted=self.pool.check_open)
            except WorkerDied as error:
                if error.signal != "SIGKILL" or not is_first:
                    raise
                is_first = False  # by hand, or for want of memory while others ran
            self.pool.check_open()


class Workers(Protocol):
    """Do tasks; ``(kind, (scan, result))`` is put into a queue when one has ended, where the result is a function that gives it.

    That raises `LostSchedulerError`, or `ClusterError` where the workers were lost that did it.
    """

    def submit(self, kind: Kind, scan: Scan) -> None:
        """Do a task when those before it are done or under way."""

    def give_up(self) -> None:
        """End what is under way, and begin nothing more."""

    def look(self) -> str | None:
        """A message about the workers for the user, or None."""


class ThisMachine:
    """Threads of this process at a station; see `Workers`. A context manager that ends them."""

    def __init__(self, station: Station, items: Items) -> None:
        self._station = station
        self._items = items
        self._threads = ThreadPoolExecutor(station.slots)

    def __enter__(self) -> ThisMachine:
        return self

    def __exit__(self, *_: object) -> None:
        self.give_up()

    def submit(self, kind: Kind, scan: Scan) -> None:
        future = self._threads.submit(self._station.do, kind, scan)
        future.add_done_callback(lambda done: None if done.cancelled() else self._items.put((kind, (scan, done.result))))

    def give_up(self) -> None:
        """See `Workers`; returns when all has been cleared up."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        self._station.pool.close()
        self._threads.shutdown()

    def look(self) -> str | None:
        return None


#: seconds between checks of the workers
_PULSE = 1.0


class Listener(Protocol):
    """Called on the events of a batch, in the thread that runs it. An exception of a method ends the batch."""

    def begin(self, total: int) -> None:
        """So many scans are to do."""

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        """A scan has ended; its outcome is in the journal."""

    def page(self, scan: Scan, made: Mapping[str, Any]) -> None:
        """A page was drawn: the result of `pymeshfair.batch.page.draw`, or ``"problem"`` with the reason of a failure."""

    def note(self, text: str) -> None:
        """A message about the workers for the user."""


@dataclass
class Course:
    """Cleans scans, reports each outcome once it is in the journal, and draws pages of the cleaned scans."""

    workers: Workers
    journal: Journal
    items: Items
    listener: Listener
    outcomes: dict[int, Outcome]  # takes those of the scans by their numbers
    pages: dict[int, Mapping[str, Any]] | None  # takes the drawn pages; None draws none
    stop: bool  # after the first scan that fails
    left: int = 0  # tasks that have not ended

    def run(self, scans: Sequence[Scan], drawn: Sequence[Scan]) -> None:
        """Clean the scans, and draw the pages of others that are done.

        Raises:
            ClusterError: a worker was lost, or the scheduler stopped.
            BatchError: the journal cannot be written.
            KeyboardInterrupt: Ctrl-C, within a second; a second one ends the process at once.
        """
        for scan in scans:
            self.submit("clean", scan)
        for scan in drawn:
            self.submit("draw", scan)
        try:
            while self.left:
                self._next()
        except BaseException:
            self.workers.give_up()
            raise

    def submit(self, kind: Kind, scan: Scan) -> None:
        """Let the workers do a task."""
        self.workers.submit(kind, scan)
        self.left += 1

    def _next(self) -> None:
        try:
            kind, item = self.items.get(timeout=_PULSE)
        except Empty:
            if note := self.workers.look():
                self.listener.note(note)
            return
        if kind == "signal":
            if threading.current_thread() is threading.main_thread():
                signal.signal(signal.SIGINT, lambda number, frame: os._exit(130))
            raise Interrupted
        self.left -= 1
        scan, result = item
        try:
            made = result()
        except LostSchedulerError:
            raise
        except Exception as error:
            lost = {"problem": f"its worker was lost: {error}"}
            made = lost if kind == "draw" else Outcome.of_error(scan.input, scan.output, error, 0.0, "")
        if kind == "clean":
            self._take(scan, made)
        elif self.pages is not None:
            self.pages[scan.number] = made
            self.listener.page(scan, made)

    def _take(self, scan: Scan, outcome: Outcome) -> None:
        """Record the outcome of a scan that has ended."""
        self.journal.append(outcome)
        self.outcomes[scan.number] = outcome
        self.listener.outcome(scan, outcome)
        if outcome.status != "done" and self.stop:
            self.workers.give_up()
            self.left = 0
        elif outcome.status != "failed" and self.pages is not None:
            self.submit("draw", scan)

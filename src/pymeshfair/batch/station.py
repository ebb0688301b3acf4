"""Does the tasks of a batch on one machine: each scan is cleaned, and its page drawn, in a process that is lent for it."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, Protocol, TypeAlias

from ..errors import RunError
from ..files.errors import OutputBusyError
from ..operating_system import this_system
from ..processes.pool import Pool
from ..processes.process import Items, Process
from ..running.errors import OutOfMemory, WorkerDied
from ..running.job import Job, RunResult
from ..running.memory import default_memory
from ..running.supervise import run_job, workers_of_runs
from .drawing import draw, page_path
from .outcome import Outcome, now
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


class Station:
    """Does the tasks of a batch in this process and those that it starts. May be used from several threads."""

    def __init__(self, template: Job, slots: int, pool: Pool) -> None:
        """See the class.

        Args:
            template: the options that all runs share.
            slots: tasks at a time; each takes its share of processors and memory.
            pool: lends the processes, see `pool_of`; it is closed with the station.
        """
        self._template = template
        self._host = socket.gethostname()
        self._threads = share_of_threads(slots)
        memory = default_memory()
        self._memory = None if memory is None else memory // slots
        self._pool = pool
        self._lent: dict[str, Process] = {}
        self._cancelled: set[str] = set()

    def close(self) -> None:
        """End all that is going on."""
        self._pool.close()

    def cancel(self, key: str) -> None:
        """End the task of that key, or refuse it when it begins."""
        self._cancelled.add(key)
        if process := self._lent.get(key):
            process.kill()

    def clean(self, key: str, scan: Scan) -> Outcome:
        """Clean one scan in this thread."""
        started = time.monotonic()
        try:
            job = job_of(self._template, scan, threads=self._threads, memory=self._memory)
            record = self._run(key, job).record
            return replace(Outcome.of_record(record, job.input, job.output), finished=now(), host=self._host)
        except Exception as error:
            return Outcome.of_error(scan.input, scan.output, error, time.monotonic() - started, self._host)

    def draw(self, key: str, scan: Scan, page: Path) -> dict[str, Any]:
        """Make the page of one scan in this thread, see `pymeshfair.batch.drawing.draw`; ``"problem"`` says why there is none."""
        limit = self._template.memory_limit or self._memory
        try:
            return draw(
                scan.input,
                scan.output,
                page,
                memory=limit,
                overwrite=self._template.overwrite,
                workers=_Lender(self._pool, key, self._lent, self._cancelled),
            )
        except Exception as error:
            return {"problem": str(error)}

    def _check_wanted(self, key: str) -> None:
        if key in self._cancelled:
            raise RunError("the batch was given up")

    def _run(self, key: str, job: Job) -> RunResult:
        from ..tiles.course import can_be_cut, run_by_tiles

        deadline, is_first = time.monotonic() + _PATIENCE, True
        job.output.parent.mkdir(parents=True, exist_ok=True)
        while True:
            try:
                return run_job(job, workers=_Lender(self._pool, key, self._lent, self._cancelled))
            except OutputBusyError:  # noqa: PERF203
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.2)
            except OutOfMemory:
                if not can_be_cut(job):
                    raise
                note = "it needed more memory than it was given, so that it was cut into tiles"
                job = replace(job, warnings=(*job.warnings, note))
                return run_by_tiles(job, check_wanted=partial(self._check_wanted, key))
            except WorkerDied as error:
                if error.signal != "SIGKILL" or not is_first or key in self._cancelled:
                    raise
                is_first = False  # by hand, or for want of memory while others ran


@dataclass(frozen=True)
class _Lender:
    """Lends the processes of a pool for one task, whose process is known while it lasts and killed if the task is cancelled."""

    pool: Pool
    key: str
    lent: dict[str, Process]
    cancelled: set[str]

    @contextmanager
    def lend(self) -> Iterator[Process]:
        with self.pool.lend() as process:
            self.lent[self.key] = process
            try:
                if self.key in self.cancelled:
                    process.kill()
                yield process
            finally:
                del self.lent[self.key]


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
    """Threads of this process with a station; see `Workers`. A context manager that ends them."""

    def __init__(self, template: Job, folder: Path, slots: int, items: Items, pool: Pool) -> None:
        """See the class; `slots` tasks are done at a time, in processes that `pool` lends."""
        self._station = Station(template, slots, pool)
        self._folder = folder
        self._items = items
        self._threads = ThreadPoolExecutor(slots)
        self._keys: set[str] = set()

    def __enter__(self) -> ThisMachine:
        return self

    def __exit__(self, *_: object) -> None:
        self.give_up()
        self._station.close()

    def submit(self, kind: Kind, scan: Scan) -> None:
        key = f"{kind}-{scan.number}"
        self._keys.add(key)
        future = self._threads.submit(do_task, self._station, kind, scan, self._folder, key)
        result: Callable[[], Any] = future.result
        future.add_done_callback(lambda done: None if done.cancelled() else self._items.put((kind, (scan, result))))

    def give_up(self) -> None:
        """See `Workers`; returns when all has been cleared up."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for key in self._keys:
            self._station.cancel(key)
        self._threads.shutdown()

    def look(self) -> str | None:
        return None


def do_task(station: Station, kind: Kind, scan: Scan, folder: Path, key: str) -> Any:
    """Do a task at a station: an `Outcome`, or what `pymeshfair.batch.drawing.draw` gives."""
    if kind == "clean":
        return station.clean(key, scan)
    return station.draw(key, scan, page_path(folder, scan.output))

"""Carries a batch out: dask schedules, the journal remembers, and nothing is begun on a worker that is not fit."""

from __future__ import annotations

import os
import secrets
import signal
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Protocol

from distributed import Client, Future, KilledWorker

from ..running.interrupts import Interrupted, Interrupts
from .cluster import open_client
from .drawing import page_path
from .errors import BatchError, LostSchedulerError, UnfitWorkersError
from .fitness import probe, unfit_for
from .journal import Journal
from .outcome import Outcome
from .plan import Scan
from .settings import Settings
from .station import Station, clean, draw_page

#: seconds between two looks at the workers
_PULSE = 1.0
#: seconds that cancelled scans have to clear up
_CLEARING = 0.6


class Listener(Protocol):
    """Who is told how a batch goes, in the thread that carries it out. An exception that is raised ends the batch."""

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        """A scan has ended, and is in the journal."""

    def page(self, scan: Scan, made: Mapping[str, Any]) -> None:
        """A page was made: what `pymeshfair.batch.drawing.draw` gave back, or ``"problem"``, why there is none."""

    def note(self, text: str) -> None:
        """Something that users should know of the workers."""


def carry_out(
    scans: Sequence[Scan],
    settings: Settings,
    journal: Journal,
    folder: Path,
    *,
    address: str | None,
    jobs: int,
    stop: bool,
    pages: bool,
    listener: Listener,
    done: Sequence[Scan] = (),
) -> None:
    """Clean scans, and tell what came of each once that is in the journal; then make their pages.

    Args:
        scans: what to do.
        settings: how.
        journal: of the folder.
        folder: where outputs go; it exists.
        address: of a scheduler, or None for this machine.
        jobs: scans at a time on this machine.
        stop: give up after the first scan that fails.
        pages: make a page of each scan that is done.
        listener: who is told.
        done: scans that were done before and get pages, too.

    Raises:
        UnfitWorkersError: a worker has other versions or does not see the files; nothing was begun.
        LostSchedulerError: the scheduler is gone.
        BatchError: no scheduler, no worker, or no room for the journal.
        KeyboardInterrupt: Ctrl-C, within a second; a second one ends the process at once.
    """
    name = f"pymeshfair-batch-{secrets.token_hex(8)}"
    with open_client(address, jobs) as client, probe(folder, scans, settings) as asked:
        _check_workers(client, asked)
        client.register_plugin(Station(name, asked), name=name)
        queue: SimpleQueue[tuple[str, Any]] = SimpleQueue()
        try:
            with Interrupts(queue):
                _Course(client, name, journal, queue, folder, listener, stop=stop, pages=pages).run(scans, done)
        finally:
            if client.status == "running" and address is not None:
                client.unregister_worker_plugin(name)


def _check_workers(client: Client, asked: Mapping[str, Any]) -> None:
    answers = client.run(unfit_for, asked, on_error="return")
    if not answers:
        raise BatchError("the scheduler has no workers; start some, and start the batch again")
    unfit = {
        address: [f"it cannot even be asked: {type(answer).__name__}: {answer}"] if isinstance(answer, BaseException) else answer
        for address, answer in answers.items()
    }
    unfit = {address: reasons for address, reasons in unfit.items() if reasons}
    if unfit:
        raise UnfitWorkersError(unfit, len(answers) - len(unfit))


class _Course:
    """The way of one batch from the first scan to the last."""

    def __init__(
        self,
        client: Client,
        name: str,
        journal: Journal,
        queue: SimpleQueue[tuple[str, Any]],
        folder: Path,
        listener: Listener,
        *,
        stop: bool,
        pages: bool,
    ) -> None:
        self._client = client
        self._name = name
        self._journal = journal
        self._queue = queue
        self._folder = folder
        self._listener = listener
        self._stop = stop
        self._pages = pages
        self._running: dict[str, tuple[Scan, Future[Any]]] = {}
        self._workers_missed = False

    def run(self, scans: Sequence[Scan], done: Sequence[Scan]) -> None:
        for scan in scans:
            self._submit(clean, scan)
        for scan in done if self._pages else ():
            self._submit(draw_page, scan)
        try:
            while self._running:
                self._next()
        except BaseException:
            self._give_up()
            raise

    def _submit(self, task: Callable[[str, Mapping[str, Any]], Any], scan: Scan) -> None:
        """Hand a scan or its page to dask, which takes first what it was given first."""
        key = f"{self._name}-{task.__name__}-{scan.number}"
        order = {
            "input": str(scan.input),
            "output": str(scan.output),
            "overrides": scan.overrides,
            "page": str(page_path(self._folder, scan.output)),
        }
        future = self._client.submit(task, self._name, order, key=key, pure=False)
        self._running[key] = scan, future
        future.add_done_callback(lambda done: self._queue.put((task.__name__, done.key)))

    def _next(self) -> None:
        try:
            kind, item = self._queue.get(timeout=_PULSE)
        except Empty:
            self._look_at_workers()
            return
        if kind == "signal":
            if threading.current_thread() is threading.main_thread():
                signal.signal(signal.SIGINT, lambda number, frame: os._exit(130))
            raise Interrupted
        if item not in self._running:
            return
        scan, future = self._running.pop(item)
        if kind == draw_page.__name__:
            self._take_page(scan, future)
        else:
            self._take(scan, future)

    def _take_page(self, scan: Scan, future: Future[Any]) -> None:
        """Tell of a page that has been made, or could not be."""
        try:
            made = future.result()
        except (CancelledError, KilledWorker) as error:
            made = {"problem": f"its worker was lost: {error}"}
        self._listener.page(scan, made)

    def _take(self, scan: Scan, future: Future[Any]) -> None:
        """Note what came of a scan that has ended."""
        try:
            outcome: Outcome = future.result()
        except CancelledError:
            raise LostSchedulerError from None
        except KilledWorker as error:
            lost = BatchError(f"every worker that began it was lost, {error.allowed_failures + 1} in all")
            outcome = Outcome.of_error(scan.input, scan.output, lost, 0.0, "")
        except Exception as error:
            if self._client.status != "running":
                raise LostSchedulerError from error
            outcome = Outcome.of_error(scan.input, scan.output, error, 0.0, "")
        future.release()
        self._journal.append(outcome)
        self._listener.outcome(scan, outcome)
        if outcome.status != "done" and self._stop:
            self._give_up()
        elif outcome.status != "failed" and self._pages:
            self._submit(draw_page, scan)

    def _give_up(self) -> None:
        """End the scans that are under way, and note those that come to their end all the same."""
        if not self._running:
            return
        self._client.cancel([future for _, future in self._running.values()], force=True)
        self._running.clear()
        deadline = time.monotonic() + _CLEARING
        while time.monotonic() < deadline and any(station.is_at_work for station in self._stations_here()):
            time.sleep(0.01)

    def _stations_here(self) -> list[Station]:
        """The stations in this process; those of other machines clear up by themselves."""
        workers = getattr(self._client.cluster, "workers", {})
        return [worker.plugins[self._name] for worker in workers.values()]

    def _look_at_workers(self) -> None:
        if self._client.status != "running":
            raise LostSchedulerError
        missed = not self._client.scheduler_info(n_workers=-1)["workers"]
        if missed and not self._workers_missed:
            self._listener.note("no worker is left; the batch goes on when one comes, and Ctrl-C ends it")
        self._workers_missed = missed

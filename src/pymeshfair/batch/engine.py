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
from typing import Any

from distributed import Client, Future, KilledWorker

from ..running.interrupts import Interrupted, Interrupts
from .cluster import open_client
from .errors import BatchError, LostSchedulerError, UnfitWorkersError
from .fitness import probe, unfit_for
from .journal import Journal
from .outcome import Outcome
from .plan import Scan
from .settings import Settings
from .station import Station, clean

#: seconds between two looks at the workers
_PULSE = 1.0
#: seconds that cancelled scans have to clear up
_CLEARING = 0.6

#: called with each outcome in the order in which scans end
Listener = Callable[[Scan, Outcome], None]


def carry_out(
    scans: Sequence[Scan],
    settings: Settings,
    journal: Journal,
    folder: Path,
    *,
    address: str | None,
    jobs: int,
    stop: bool = False,
    on_outcome: Listener = lambda scan, outcome: None,
    on_note: Callable[[str], None] = lambda text: None,
) -> dict[int, Outcome]:
    """Clean scans; what came of each by its number. Each is in the journal before it is told.

    Args:
        scans: what to do.
        settings: how.
        journal: of the folder.
        folder: where outputs go; it exists.
        address: of a scheduler, or None for this machine.
        jobs: scans at a time on this machine.
        stop: give up after the first scan that fails.
        on_outcome: called in this thread. An exception that it raises ends the batch.
        on_note: called with what users should know of the workers.

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
                return _Course(client, name, journal, queue, stop, on_outcome, on_note).run(scans)
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
        stop: bool,
        on_outcome: Listener,
        on_note: Callable[[str], None],
    ) -> None:
        self._client = client
        self._name = name
        self._journal = journal
        self._queue = queue
        self._stop = stop
        self._on_outcome = on_outcome
        self._on_note = on_note
        self._running: dict[str, tuple[Scan, Future[Outcome]]] = {}
        self._outcomes: dict[int, Outcome] = {}
        self._looked = time.monotonic()
        self._workers_missed = False

    def run(self, scans: Sequence[Scan]) -> dict[int, Outcome]:
        for scan in scans:
            key = f"{self._name}-{scan.number}"
            order = {"input": str(scan.input), "output": str(scan.output), "overrides": scan.overrides}
            future = self._client.submit(clean, self._name, order, key=key, pure=False)
            self._running[key] = scan, future
            future.add_done_callback(lambda done: self._queue.put(("done", done.key)))
        try:
            while self._running:
                self._next()
        except BaseException:
            self._give_up()
            raise
        return self._outcomes

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
        outcome = self._take(item)
        if outcome is not None and outcome.status != "done" and self._stop:
            self._give_up()

    def _take(self, key: str) -> Outcome | None:
        """Note what came of a scan that has ended."""
        if key not in self._running:
            return None
        scan, future = self._running.pop(key)
        try:
            outcome = future.result()
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
        self._outcomes[scan.number] = outcome
        self._on_outcome(scan, outcome)
        return outcome

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
            self._on_note("no worker is left; the batch goes on when one comes, and Ctrl-C ends it")
        self._workers_missed = missed

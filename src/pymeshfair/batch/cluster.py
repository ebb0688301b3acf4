"""Runs a batch on the workers of a dask scheduler: each worker has a `Station`, which does its tasks."""

from __future__ import annotations

import logging
import pickle
import secrets
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from distributed import Client, Reschedule, Worker, WorkerPlugin, get_worker

from ..processes.cluster import Conditions, LostSchedulerError, Scheduler, check_workers, conditions, open_client
from ..running.job import Job
from .plan import Scan
from .work import Kind, Station, pool_of

_IDLE = 120.0  # seconds without work after which a worker ends its idle processes


@contextmanager
def workers_of_scheduler(scheduler: Scheduler, template: Job, scans: Sequence[Scan], folder: Path) -> Iterator[DaskWorkers]:
    """Opens the workers of a scheduler for a batch, after checking them."""
    name = f"pymeshfair-batch-{secrets.token_hex(8)}"
    scan_of_folder = {scan.input.parent: scan.input for scan in reversed(scans)}
    inputs = [*scan_of_folder.values(), *template.others]
    with open_client(scheduler) as client, conditions(folder, template.recipe, inputs) as worker_conditions:
        check_workers(client, worker_conditions)
        client.register_plugin(_Plugin(name, pickle.dumps(template), worker_conditions), name=name)
        try:
            yield DaskWorkers(client, name)
        finally:
            if client.status == "running":
                client.unregister_worker_plugin(name)


class DaskWorkers:
    """The workers of a scheduler, with the methods `submit`, `end` and `check` of a `Station`."""

    def __init__(self, client: Client, name: str) -> None:
        self._client = client
        self._name = name
        self._executor: Any = client.get_executor(pure=False)
        self._were_missing = False

    def submit(self, kind: Kind, scan: Scan) -> Future[Any]:
        future: Future[Any] = self._executor.submit(_do, self._name, kind, scan, key=f"{self._name}-{kind}-{scan.number}")
        return future

    def end(self) -> None:
        if self._client.status == "running":
            self._executor.shutdown(wait=False)

    def check(self) -> str | None:
        if self._client.status != "running":
            raise LostSchedulerError
        were_missing, self._were_missing = self._were_missing, not self._client.scheduler_info(n_workers=-1)["workers"]
        if self._were_missing and not were_missing:
            return "no worker is left; the batch continues when a worker joins, and Ctrl-C ends it"
        return None


@dataclass(eq=False)
class _Plugin(WorkerPlugin):
    """Holds the station of a worker during a batch; dask sends the plugin to workers that join later, too."""

    name: str  # the name of the batch, with which the names of its tasks begin
    template: bytes  # a pickled `Job`
    worker_conditions: Conditions
    station: Station | None = None

    def setup(self, worker: Worker) -> None:
        """Makes the station; dask calls this method on every worker. A worker that joins late and is unfit is closed."""
        if unfit := self.worker_conditions.unfit():
            logging.getLogger(__name__).error("this worker cannot take part in the batch: %s", "; ".join(unfit))
            worker.loop.add_callback(worker.close, reason="pymeshfair-batch-unfit")
            return
        pool = pool_of(worker.state.nthreads, rest_after=_IDLE)
        self.station = Station(pickle.loads(self.template), self.worker_conditions.probe.parent, pool)

    def teardown(self, worker: Worker) -> None:
        """Ends the processes; dask calls this method when the batch or the worker ends."""
        if self.station is not None:
            self.station.pool.close()

    def transition(self, key: Any, start: str, finish: str, **more: Any) -> None:
        """Ends all processes if dask releases a running task: the batch has ended early. Dask calls this method for all tasks."""
        if (start, finish) == ("executing", "released") and self.station is not None and str(key).startswith(self.name):
            threading.Thread(target=self.station.pool.close, daemon=True).start()  # so that dask need not wait


def _do(batch: str, kind: Kind, scan: Scan) -> Any:
    plugin = cast("_Plugin", get_worker().plugins[batch])
    if plugin.station is None:
        raise Reschedule
    return plugin.station.do(kind, scan)

"""A batch on the workers of a scheduler of dask: each keeps a station while the batch lasts."""

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

#: seconds without work after which a worker ends its processes
_IDLE = 120.0


@contextmanager
def workers_of_scheduler(scheduler: Scheduler, template: Job, scans: Sequence[Scan], folder: Path) -> Iterator[OfScheduler]:
    """The workers of a scheduler."""
    name = f"pymeshfair-batch-{secrets.token_hex(8)}"
    firsts = {scan.input.parent: scan.input for scan in reversed(scans)}
    inputs = [*firsts.values(), *template.others]
    with open_client(scheduler) as client, conditions(folder, template.recipe, inputs) as wanted:
        check_workers(client, wanted)
        client.register_plugin(_Plugin(name, pickle.dumps(template), wanted), name=name)
        try:
            yield OfScheduler(client, name)
        finally:
            if client.status == "running":
                client.unregister_worker_plugin(name)


class OfScheduler:
    """The workers of a scheduler, with what the `Station` of one machine has."""

    def __init__(self, client: Client, name: str) -> None:
        self._client = client
        self._name = name
        self._executor: Any = client.get_executor(pure=False)
        self._were_missed = False

    def submit(self, kind: Kind, scan: Scan) -> Future[Any]:
        future: Future[Any] = self._executor.submit(_do, self._name, kind, scan, key=f"{self._name}-{kind}-{scan.number}")
        return future

    def give_up(self) -> None:
        if self._client.status == "running":
            self._executor.shutdown(wait=False)

    def look(self) -> str | None:
        if self._client.status != "running":
            raise LostSchedulerError
        were_missed, self._were_missed = self._were_missed, not self._client.scheduler_info(n_workers=-1)["workers"]
        if self._were_missed and not were_missed:
            return "no worker is left; the batch goes on when one comes, and Ctrl-C ends it"
        return None


@dataclass(eq=False)
class _Plugin(WorkerPlugin):
    """The station of every worker during a batch; dask sends it to workers that join later, too."""

    name: str  # of the batch, with which the names of its tasks begin
    template: bytes  # a pickled `Job`
    wanted: Conditions
    station: Station | None = None

    def setup(self, worker: Worker) -> None:
        """Called by dask on every worker. One that came late and is not fit leaves again."""
        if unfit := self.wanted.unfit():
            logging.getLogger(__name__).error("this worker cannot take part in the batch: %s", "; ".join(unfit))
            worker.loop.add_callback(worker.close, reason="pymeshfair-batch-unfit")
            return
        pool = pool_of(worker.state.nthreads, rest_after=_IDLE)
        self.station = Station(pickle.loads(self.template), self.wanted.probe.parent, pool)

    def teardown(self, worker: Worker) -> None:
        """Called by dask when the batch or the worker ends."""
        if self.station is not None:
            self.station.pool.close()

    def transition(self, key: Any, start: str, finish: str, **more: Any) -> None:
        """Called by dask for every task: once one is not wanted any more the batch was given up or killed, and all are ended."""
        if (start, finish) == ("executing", "released") and self.station is not None and str(key).startswith(self.name):
            threading.Thread(target=self.station.pool.close, daemon=True).start()  # dask is not to wait for that


def _do(batch: str, kind: Kind, scan: Scan) -> Any:
    """A task, on whichever worker dask gives it to."""
    plugin = cast("_Plugin", get_worker().plugins[batch])
    if plugin.station is None:
        raise Reschedule
    return plugin.station.do(kind, scan)

"""The workers of a batch: threads of this process, which start those that do the work, or those of a scheduler."""

from __future__ import annotations

import contextlib
import logging
import warnings
from collections.abc import Iterator
from typing import Any

import dask
from distributed import Client, Scheduler, SpecCluster, Worker

from .errors import BatchError

#: what dask would record about thousands of tasks, and measure of a process whose threads only wait
_QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.scheduler.dashboard.status.task-stream-length": 100,
    "distributed.admin.low-level-log-length": 100,
    "distributed.admin.log-length": 100,
    "distributed.worker.memory.terminate": 1.0,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.target": False,
}
#: seconds in which a scheduler must answer
_ANSWER = "10s"


class _WithoutPages:
    """A server of dask's that opens no port: its pages, which it would show to every machine, have no switch."""

    def start_http_server(self, *arguments: Any, **options: Any) -> None:
        """Called by dask; does nothing."""


class _Scheduler(_WithoutPages, Scheduler):
    pass


class _Worker(_WithoutPages, Worker):
    pass


@contextlib.contextmanager
def open_client(address: str | None, jobs: int) -> Iterator[Client]:
    """A client of the scheduler at `address`, or if that is None of one in this process with so many tasks at a time.

    Args:
        address: of a scheduler, or None.
        jobs: tasks at a time on this machine, threads of this process.

    Raises:
        BatchError: no scheduler answers there.
    """
    for name in ("distributed", "tornado"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what matters is told in the batch's own words
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set(_QUIET))
        stack.enter_context(warnings.catch_warnings())
        warnings.simplefilter("ignore")  # other versions of dask's own packages
        if address is None:
            client = Client(stack.enter_context(_in_this_process(jobs)), set_as_default=False)
        else:
            try:
                client = Client(address, timeout=_ANSWER, set_as_default=False)
            except (OSError, ValueError, TimeoutError) as error:
                raise BatchError(f"no scheduler answers at {address}: {error}") from error
        stack.enter_context(client)
        yield client


def _in_this_process(jobs: int) -> SpecCluster:
    """A scheduler and a worker that talk within this process, so that nobody else can."""
    options = {"protocol": "inproc://", "dashboard": False}
    worker = {"cls": _Worker, "options": options | {"nthreads": jobs, "memory_limit": 0}}
    return SpecCluster(workers={0: worker}, scheduler={"cls": _Scheduler, "options": options}, silence_logs=False)

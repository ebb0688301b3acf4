"""The workers of a batch: threads of this process, which start those that do the work, or those of a scheduler."""

from __future__ import annotations

import contextlib
import logging
import tempfile
import warnings
from collections.abc import Iterator, Mapping

import dask
from distributed import Client, LocalCluster

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


@contextlib.contextmanager
def open_client(
    address: str | None, jobs: int, *, processes: Mapping[str, str] | None = None, memory: int = 0
) -> Iterator[Client]:
    """A client of the scheduler at `address`, or if that is None of one in this process with so many tasks at a time.

    Args:
        address: of a scheduler, or None.
        jobs: tasks at a time on this machine.
        processes: the environment of a process for each of them; None if they run in threads of this one.
        memory: bytes above which such a process is ended, and its task begun again; 0 for any number.

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
            cluster = stack.enter_context(_local_cluster(jobs, processes, memory))
            client = Client(cluster, set_as_default=False)
        else:
            try:
                client = Client(address, timeout=_ANSWER, set_as_default=False)
            except (OSError, ValueError, TimeoutError) as error:
                raise BatchError(f"no scheduler answers at {address}: {error}") from error
        stack.enter_context(client)
        yield client


def _local_cluster(jobs: int, processes: Mapping[str, str] | None, memory: int) -> LocalCluster:
    if processes is None:
        kind = {"n_workers": 1, "threads_per_worker": jobs, "processes": False, "protocol": "inproc://", "silence_logs": False}
    else:
        kind = {"n_workers": jobs, "threads_per_worker": 1, "processes": True, "env": dict(processes)}
        kind |= {"silence_logs": logging.CRITICAL, "local_directory": tempfile.gettempdir()}
    return LocalCluster(**kind, dashboard_address=None, worker_dashboard_address=None, memory_limit=memory)

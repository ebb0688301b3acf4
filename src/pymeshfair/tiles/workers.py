"""The workers that do tiles: processes of this machine, or those of a dask scheduler; the same tasks on both."""

from __future__ import annotations

import contextlib
import os
import secrets
import signal
import socket
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import Any

import dask
from distributed import Client, KilledWorker, LocalCluster

from ..batch.cluster import open_client
from ..errors import FilterInputError, RunError
from ..files.errors import ContentsError
from ..operating_system import this_system
from ..running.environment import worker_environment
from ..running.interrupts import Interrupted
from ..running.versions import versions

#: seconds between two looks at silent workers
_PULSE = 0.5
#: how often a task may lose its worker
_LOST = 3


class TileError(RunError):
    """A tile could not be done."""


class FullDiskError(RunError):
    """There is no room for what a task has to write."""


@dataclass(frozen=True)
class _Answer:
    """What came of a task: its result, or a failure as its kind and words, which cross from process to process as they are."""

    result: Any = None
    failure: tuple[str, str] | None = None
    process: str = ""
    peak: int | None = None
    seconds: float = 0.0


def _answer(task: Callable[..., Any], *arguments: Any) -> _Answer:
    """Do a task, on a worker."""
    started = time.process_time()
    failure, result = None, None
    try:
        result = task(*arguments)
    except ContentsError as error:
        failure = "contents", str(error)
    except FilterInputError as error:
        failure = "filter", str(error)
    except MemoryError:
        failure = "memory", ""
    except OSError as error:
        failure = "disk", (error.strerror or str(error)).lower()
    except Exception:
        failure = "defect", traceback.format_exc()
    process = f"{socket.gethostname()} {os.getpid()}"
    return _Answer(result, failure, process, this_system().peak_memory(), time.process_time() - started)


class Pool:
    """Does tasks on workers, in whatever order, and gives their results in the order of the tasks.

    Attributes:
        peaks: by process, the most bytes that it has held, as far as that is known.
        seconds: processor time of all tasks.
    """

    def __init__(self, client: Client, queue: SimpleQueue[tuple[str, Any]]) -> None:
        """See the class; the queue is that of `Interrupts`."""
        self._client = client
        self._queue = queue
        self._name = f"pymeshfair-tiles-{secrets.token_hex(8)}"
        self._stage = 0
        self.peaks: dict[str, int] = {}
        self.seconds = 0.0

    def run(self, task: Callable[..., Any], *arguments: Any) -> Any:
        """Do one task."""
        return self.map(task, [arguments], lambda share: None)[0]

    def map(self, task: Callable[..., Any], tasks: Sequence[tuple[Any, ...]], progress: Callable[[float], None]) -> list[Any]:
        """Do a task with each of some arguments.

        Args:
            task: a function of a module, or a method of an object that can be sent. It begins again if its worker is lost.
            tasks: the arguments.
            progress: called with the share that is done.

        Raises:
            ContentsError, FilterInputError, MemoryError, FullDiskError, TileError: a task failed.
            Interrupted: a signal came.
        """
        self._stage += 1
        futures = {
            (key := f"{self._name}-{self._stage}-{number}"): self._client.submit(
                _answer, task, *arguments, key=key, pure=False, retries=0
            )
            for number, arguments in enumerate(tasks)
        }
        for future in futures.values():
            future.add_done_callback(lambda done: self._queue.put(("done", done.key)))
        results: dict[str, Any] = {}
        try:
            while len(results) < len(futures):
                try:
                    kind, key = self._queue.get(timeout=_PULSE)
                except Empty:
                    if self._client.status != "running":
                        raise TileError("the scheduler does not answer any more") from None
                    continue
                if kind == "signal":
                    raise Interrupted
                if key in futures and key not in results:
                    results[key] = self._result(futures[key])
                    progress(len(results) / len(futures))
        except BaseException:
            with contextlib.suppress(Exception):
                self._client.cancel(list(futures.values()), force=True)
            raise
        return [results[key] for key in futures]

    def _result(self, future: Any) -> Any:
        try:
            answer: _Answer = future.result()
        except KilledWorker as error:
            raise TileError(
                f"every worker that began a tile was lost, {error.allowed_failures + 1} in all, perhaps for want of memory"
            ) from error
        except CancelledError as error:
            raise TileError("the scheduler does not answer any more") from error
        self.seconds += answer.seconds
        if answer.peak is not None:
            self.peaks[answer.process] = answer.peak
        if answer.failure is not None:
            _raise(*answer.failure)
        return answer.result


def _raise(kind: str, words: str) -> None:
    if kind == "contents":
        raise ContentsError(words)
    if kind == "filter":
        raise FilterInputError(words)
    if kind == "memory":
        raise TileError("a tile needs more memory than there is; give it more")
    if kind == "disk":
        raise FullDiskError(words)
    raise TileError(f"a worker failed, which is a defect of pymeshfair; please report it:\n{words}")


@contextlib.contextmanager
def open_pool(
    address: str | None, workers: int, threads: int, queue: SimpleQueue[tuple[str, Any]], *, memory: int
) -> Iterator[Pool]:
    """Workers for as long as the context lasts.

    Args:
        address: of a scheduler, whose workers must have the same versions and see the same disk; None for this machine.
        workers: how many of these.
        threads: that a filter may use in each of these.
        queue: of `Interrupts`.
        memory: bytes above which one of this machine's workers is ended, and its task begun again.

    Raises:
        TileError: a worker of the scheduler has other versions.
    """
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set({"distributed.scheduler.allowed-failures": _LOST}))
        client = stack.enter_context(open_client(address, workers, processes=worker_environment(threads), memory=memory))
        if address is not None:
            here = versions()
            there = client.run(versions)
            wrong = {
                name for found in there.values() for name in here if name not in ("system",) and found.get(name) != here[name]
            }
            if wrong or not there:
                raise TileError(f"workers have other versions of {', '.join(sorted(wrong))}" if wrong else "there are no workers")
        try:
            yield Pool(client, queue)
        except BaseException:
            _end(client.cluster)
            raise


def _end(cluster: Any) -> None:
    """End the processes of this machine's workers at once: a task that is under way would hold up their end."""
    if not isinstance(cluster, LocalCluster):
        return
    for nanny in cluster.workers.values():
        with contextlib.suppress(AttributeError, ProcessLookupError, TypeError):
            nanny.auto_restart = False
            os.kill(nanny.pid, signal.SIGKILL)

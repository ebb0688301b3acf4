"""The workers that do tiles: processes of this machine, or those of a dask scheduler; the same tasks on both."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Future
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Protocol

from ..errors import FilterInputError, RunError
from ..files.errors import ContentsError
from ..running.interrupts import Interrupted
from ..running.versions import versions
from .answers import Answer, LostWorkerError, answer
from .processes import Processes

if TYPE_CHECKING:
    from distributed import Client

#: seconds between two looks at silent workers
_PULSE = 0.5


class TileError(RunError):
    """A tile could not be done."""


class FullDiskError(RunError):
    """There is no room for what a task has to write."""


class Workers(Protocol):
    """What does tasks, in whatever order."""

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Answer]:
        """Do a task."""

    def is_there(self) -> bool:
        """Whether answers are still to be expected."""


class Pool:
    """Does tasks on workers, and gives their results in the order of the tasks.

    Attributes:
        peaks: by process, the most bytes that it has held, as far as that is known.
        seconds: processor time of all tasks.
    """

    def __init__(self, workers: Workers, queue: SimpleQueue[tuple[str, Any]]) -> None:
        """See the class; the queue is that of `Interrupts`."""
        self._workers = workers
        self._queue = queue
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
        futures = [self._workers.submit(task, *arguments) for arguments in tasks]
        for future in futures:
            future.add_done_callback(lambda done: self._queue.put(("done", done)))
        results: dict[Future[Answer], Any] = {}
        try:
            while len(results) < len(futures):
                try:
                    kind, item = self._queue.get(timeout=_PULSE)
                except Empty:
                    if not self._workers.is_there():
                        raise TileError("the scheduler does not answer any more") from None
                    continue
                if kind == "signal":
                    raise Interrupted
                results[item] = self._result(item)
                progress(len(results) / len(futures))
        except BaseException:
            for future in futures:
                future.cancel()
            raise
        return [results[future] for future in futures]

    def _result(self, future: Future[Answer]) -> Any:
        try:
            answer = future.result()
        except CancelledError as error:
            raise TileError("the scheduler does not answer any more") from error
        except LostWorkerError as error:
            raise TileError(f"{error}, perhaps for want of memory") from error
        except Exception as error:  # dask's, such as KilledWorker
            raise TileError(f"a tile was lost with its workers: {error}") from error
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
        memory: bytes that each of these may take.

    Raises:
        TileError: a worker of the scheduler has other versions.
    """
    if address is None:
        with Processes(workers, threads, memory) as processes:
            yield Pool(processes, queue)
        return
    from ..batch.cluster import open_client

    with open_client(address, workers) as client:
        here, there = versions(), client.run(versions)
        wrong = {name for found in there.values() for name in here if name != "system" and found.get(name) != here[name]}
        if wrong or not there:
            raise TileError(f"workers have other versions of {', '.join(sorted(wrong))}" if wrong else "there are no workers")
        yield Pool(_OfScheduler(client), queue)


class _OfScheduler:
    """The workers of a dask scheduler, see `Workers`."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._executor = client.get_executor(pure=False, retries=0)

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Answer]:
        future: Future[Answer] = self._executor.submit(answer, task, *arguments)
        return future

    def is_there(self) -> bool:
        return bool(self._client.status == "running")

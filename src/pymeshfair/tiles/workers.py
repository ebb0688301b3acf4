"""Does the tasks of a run by tiles, on processes of this machine or on the workers of a dask scheduler.

Their files are in a folder, with a journal of the finished tasks: a run that was killed goes on from it. The same run gives the
same tasks in the same order. So a resumed run takes the results of finished tasks from the journal, and their files are in the
folder. A task that was under way is done again.
"""

import contextlib
import hashlib
import math
import os
import pickle
import stat
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Future
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from queue import Empty
from typing import Any, BinaryIO

from ..errors import Place, RunError, RunTimeout
from ..files.errors import OutputError
from ..files.writing import WORK_PREFIX, in_use, remove_folder
from ..filters.execution import ignore_progress
from ..processes.cluster import LostSchedulerError, Scheduler, check_workers, conditions, open_client
from ..processes.process import Items, LostProcessError, Pool
from ..processes.worker import Answer, DefectError, answer
from ..running.job import Job
from ..running.supervise import Interrupted
from .plan import Budget

_JOURNAL = "journal"
#: seconds between two looks at silent workers
_PULSE = 0.5


@dataclass(frozen=True)
class WorkFolder:
    """The folder and its journal."""

    path: Path  # the folder
    note: str  # why the files of a former run are not used; empty if they are, or if there are none
    journal: BinaryIO
    results: Mapping[tuple[int, int], Any]  # of a former run, by the number of the group of tasks, and that in the group

    def append(self, call: int, number: int, result: Any) -> None:
        """Write down that a task is finished."""
        self.journal.write(pickle.dumps((call, number, result)))
        self.journal.flush()


def work_path(output: Path) -> Path:
    """The folder of the run to an output: a hidden one beside it."""
    return output.with_name(WORK_PREFIX + hashlib.sha256(os.fsencode(output.name)).hexdigest()[:16])


@contextlib.contextmanager
def work_folder(output: Path, key: Mapping[str, Any], *, resume: bool) -> Iterator[WorkFolder]:
    """The folder for a run to `output`, removed at the end of the run; the output must be locked.

    Its key stands for all on which the tasks and their files depend. With `resume` the files of a former run with the same key
    are used, any others are removed. If the run fails the folder stays with `resume`, and always if the scheduler is lost.
    """
    path = work_path(output)
    results, end, note = _former(path, key) if resume else ({}, 0, "")
    with contextlib.ExitStack() as opened:
        try:
            if not end:
                remove_folder(path)
                path.mkdir(mode=0o700)
            opened.enter_context(in_use(path))
            journal = opened.enter_context((path / _JOURNAL).open("r+b" if end else "wb"))
            journal.truncate(end)
            journal.seek(end)
            if not end:
                journal.write(pickle.dumps(dict(key)))
                journal.flush()
        except OSError as error:
            raise OutputError(output, f"cannot make a folder beside it: {error.strerror or error}") from error
        try:
            yield WorkFolder(path, note, journal, results)
        except BaseException as error:
            if not resume and not isinstance(error, LostSchedulerError):
                remove_folder(path)
            raise
        remove_folder(path)


def _former(path: Path, key: Mapping[str, Any]) -> tuple[dict[tuple[int, int], Any], int, str]:
    """Of a former run its results, the end of its last whole record in bytes (0 if it cannot be used), and why it cannot."""
    results: dict[tuple[int, int], Any] = {}
    end = 0
    try:
        # Pickles run code, so that a folder of another user is not read.
        status = path.lstat()
        if not stat.S_ISDIR(status.st_mode) or (hasattr(os, "getuid") and status.st_uid != os.getuid()):
            return {}, 0, f"the folder {path} belongs to another user"
        with (path / _JOURNAL).open("rb") as file:
            former = pickle.load(file)
            if former != dict(key):
                names = " and ".join(name for name in key if former.get(name) != key[name])
                return {}, 0, f"the files of the former run are not used, since it differs in {names}"
            while True:
                end = file.tell()
                call, number, done = pickle.load(file)
                results[call, number] = done
    except Exception:  # there is no such run, or a record was not written to its end
        return results, end, ""


class TileError(RunError):
    """A tile could not be done."""


@dataclass
class Tasks:
    """Does tasks on workers, and gives their results in the order of the tasks."""

    submit: Callable[..., Future[Answer]]  # does a task with its arguments on some worker
    items: Items  # of `pymeshfair.running.supervise.Interrupts`
    timeout: float = math.inf  # seconds from now in which all must be done
    check: Callable[[], None] = lambda: None  # called every moment; may raise to stop
    work: WorkFolder | None = None  # the folder of the files of the tasks
    peaks: dict[str, int] = field(default_factory=dict)  # by process, the most bytes that it has held, as far as that is known

    def __post_init__(self) -> None:
        self._deadline = time.monotonic() + self.timeout
        self._calls = 0

    def run(self, task: Callable[..., Any], *arguments: Any) -> Any:
        """Do one task."""
        return self.map(task, [arguments])[0]

    def map(
        self,
        task: Callable[..., Any],
        tasks: Sequence[tuple[Any, ...]],
        progress: Callable[[float], None] = ignore_progress,
        *,
        again: bool = False,
    ) -> list[Any]:
        """Do a task with each of some arguments: a function of a module, or a method of an object that can be sent.

        It must give the same if it is done twice, also if it was not done to its end the first time: its worker may be lost, or
        all of the run killed. With `again` a resumed run does it, too, as its files are not in the folder of work.
        """
        call, self._calls = self._calls, self._calls + 1
        former = {} if self.work is None or again else self.work.results
        results = {number: former[call, number] for number in range(len(tasks)) if (call, number) in former}
        futures = {self.submit(task, *tasks[number]): number for number in range(len(tasks)) if number not in results}
        for future in futures:
            future.add_done_callback(lambda done: self.items.put(("done", done)))
        try:
            while len(results) < len(tasks):
                if time.monotonic() >= self._deadline:
                    raise RunTimeout(Place("working by tiles"), self.timeout)
                self.check()
                with contextlib.suppress(Empty):
                    kind, done = self.items.get(timeout=_PULSE)
                    if kind == "signal":
                        raise Interrupted
                    number = futures[done]
                    results[number] = self._result_of(done)
                    if self.work is not None:
                        self.work.append(call, number, results[number])
                    progress(len(results) / len(tasks))
        except BaseException:
            for future in futures:
                future.cancel()
            raise
        return [results[number] for number in range(len(tasks))]

    def _result_of(self, future: Future[Answer]) -> Any:
        try:
            done = future.result()
        except CancelledError as error:
            raise LostSchedulerError from error
        except LostProcessError as error:
            raise TileError(f"every worker that began a tile was lost ({error}), perhaps for want of memory") from error
        except Exception as error:  # dask's, such as KilledWorker
            raise TileError(f"a tile was lost with its workers: {error}") from error
        if done.peak_memory is not None:
            self.peaks[done.process] = max(done.peak_memory, self.peaks.get(done.process, 0))
        match done.error:
            case None:
                return done.result
            case MemoryError():
                raise TileError("a tile needs more memory than there is; give it more")
            case DefectError():
                raise TileError(f"a worker failed, which is a defect of pymeshfair; please report it:\n{done.details}")
        raise done.error


@contextlib.contextmanager
def open_tasks(
    scheduler: Scheduler | None, share: Budget, job: Job, items: Items, *, memory: int, check: Callable[[], None]
) -> Iterator[Tasks]:
    """Workers of this machine, or of a dask scheduler, for as long as the context lasts; each here may take `memory` bytes."""
    timeout = math.inf if job.timeout is None else job.timeout
    if scheduler is None:
        with Pool(share.workers, share.threads) as pool:
            yield Tasks(partial(pool.submit, memory_limit=memory), items, timeout=timeout, check=check)
        return
    with open_client(scheduler) as client:
        with conditions(job.output.parent, job.recipe, [job.input]) as wanted:
            check_workers(client, wanted)

        def check_scheduler() -> None:
            check()
            if client.status != "running":
                raise LostSchedulerError

        executor = client.get_executor(pure=False, retries=0)
        yield Tasks(partial(executor.submit, answer), items, timeout=timeout, check=check_scheduler)

"""Does the tasks of a run by tiles, in processes of this machine or on the workers of a dask scheduler.

The temporary files of a run are in a folder, with a journal of finished tasks. The same run has the same tasks in the same order,
so a resumed run takes the results of finished tasks from the journal, and does only the other tasks.
"""

import contextlib
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
from ..files.writing import WORK_PREFIX, in_use, mark, remove_folder
from ..filters.execution import ignore_progress
from ..processes.cluster import LostSchedulerError, Scheduler, check_workers, conditions, open_client
from ..processes.process import Items, LostProcessError, Pool
from ..processes.worker import Answer, DefectError, answer
from ..running.job import Job
from ..running.supervise import Interrupted
from .plan import Budget

_JOURNAL = "journal"
_PULSE = 0.5  # seconds between two checks while workers send nothing


@dataclass(frozen=True)
class WorkFolder:
    """The folder of the temporary files of a run, and its journal."""

    path: Path
    note: str  # why a resumed run does not use the files of a former run; else empty
    journal: BinaryIO
    results: Mapping[tuple[int, int], Any]  # of a former run, by the `Tasks.map` call's number and the task's number in the call

    def append(self, call: int, number: int, result: Any) -> None:
        self.journal.write(pickle.dumps((call, number, result)))
        self.journal.flush()


def work_path(output: Path) -> Path:
    """Returns the path of the hidden folder for a run, beside its output."""
    return output.with_name(WORK_PREFIX + mark(output))


@contextlib.contextmanager
def work_folder(output: Path, key: Mapping[str, Any], *, resume: bool) -> Iterator[WorkFolder]:
    """Opens the folder for a run to `output`, and removes it at the end of the run; the output must be locked.

    `key` has everything on which the tasks and their files depend. The files of a former run are used if `resume` is True and
    that run had the same key, else removed. After a failure the folder is kept if `resume` is True or the scheduler is lost.
    """
    path = work_path(output)
    results, end, note = _former(path, key) if resume else ({}, 0, "")
    with contextlib.ExitStack() as opened:
        try:
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
            yield WorkFolder(path, note, journal, results)
        except BaseException as error:
            if not resume and not isinstance(error, LostSchedulerError):
                remove_folder(path)
            raise
        remove_folder(path)


def _former(path: Path, key: Mapping[str, Any]) -> tuple[dict[tuple[int, int], Any], int, str]:
    """Returns the results of a former run, the size of its journal's complete records in bytes, and `WorkFolder.note`."""
    results: dict[tuple[int, int], Any] = {}
    end = 0
    try:
        # Pickles can run code, so a folder of another user is not read.
        status = path.lstat()
        if not stat.S_ISDIR(status.st_mode) or (hasattr(os, "getuid") and status.st_uid != os.getuid()):
            return {}, 0, f"{path} is not a folder of this user"
        with (path / _JOURNAL).open("rb") as file:
            former = pickle.load(file)
            if former != dict(key):
                names = " and ".join(name for name in key if former.get(name) != key[name])
                return {}, 0, f"the files of the former run are not used, since it differs in {names}"
            while True:
                end = file.tell()
                call, number, done = pickle.load(file)
                results[call, number] = done
    except Exception:  # there is no former run; or the journal ends here, perhaps with an incomplete record
        return results, end, ""


class TileError(RunError):
    """A task of a tile failed."""


@dataclass
class Tasks:
    """Does tasks on workers, and returns the results in the order of the tasks."""

    submit: Callable[..., Future[Answer]]  # does a task with its arguments on any worker
    items: Items  # the queue of signals from `pymeshfair.running.supervise.Interrupts`, and of finished tasks
    timeout: float = math.inf  # seconds for all tasks together, from the creation of this object
    check: Callable[[], None] = lambda: None  # called after each task, and at least twice a second; may raise to stop
    work: WorkFolder | None = None
    peaks: dict[str, int] = field(default_factory=dict)  # peak memory by process in bytes, if known

    def __post_init__(self) -> None:
        self._deadline = time.monotonic() + self.timeout
        self._calls = 0

    def run(self, task: Callable[..., Any], *arguments: Any) -> Any:
        return self.map(task, [arguments])[0]

    def map(
        self,
        task: Callable[..., Any],
        tasks: Sequence[tuple[Any, ...]],
        progress: Callable[[float], None] = ignore_progress,
        *,
        again: bool = False,
    ) -> list[Any]:
        """Calls `task`, which can be pickled, with each tuple of arguments; a call may be repeated after its worker was killed.

        With `again`, for calls that write outside the folder of temporary files, a resumed run repeats all calls.
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
            raise TileError(f"each worker that tried a tile ended ({error}), perhaps for lack of memory") from error
        except Exception as error:  # errors of dask, such as KilledWorker
            raise TileError(f"a tile was lost with its workers: {error}") from error
        if done.peak_memory is not None:
            self.peaks[done.process] = max(done.peak_memory, self.peaks.get(done.process, 0))
        match done.error:
            case None:
                return done.result
            case MemoryError():
                raise TileError("a tile needs more memory than the run may use; allow it more")
            case DefectError():
                raise TileError(f"a worker failed, which is a defect of pymeshfair; please report it:\n{done.details}")
        raise done.error


@contextlib.contextmanager
def open_tasks(
    scheduler: Scheduler | None, budget: Budget, job: Job, items: Items, *, memory: int, check: Callable[[], None]
) -> Iterator[Tasks]:
    """Opens workers of this machine, each limited to `memory` bytes, or those of a dask scheduler."""
    timeout = math.inf if job.timeout is None else job.timeout
    if scheduler is None:
        with Pool(budget.workers, budget.threads) as pool:
            yield Tasks(partial(pool.submit, memory_limit=memory), items, timeout=timeout, check=check)
        return
    with open_client(scheduler) as client:
        with conditions(job.output.parent, job.recipe, [job.input]) as worker_conditions:
            check_workers(client, worker_conditions)

        def check_scheduler() -> None:
            check()
            if client.status != "running":
                raise LostSchedulerError

        executor = client.get_executor(pure=False, retries=0)
        yield Tasks(partial(executor.submit, answer), items, timeout=timeout, check=check_scheduler)

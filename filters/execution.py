"""Progress reports, parallel tasks, and library calls that can be abandoned.

Each iteration of a parallel kernel writes its own results, so the bits do not depend on the number of threads.
"""

import os
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import AbstractContextManager, nullcontext
from functools import cache
from typing import Any, TypeVar

from .compilation import allowed_threads, set_threads, single_thread

#: Called with the finished share of the work, from 0 to 1; may raise to stop the work.
Progress = Callable[[float], None]
#: Kernels on fewer vertices run on one thread, since waking other threads would cost more than it saves.
SERIAL_BELOW = 20_000
#: The number of parts per thread in a loop over a large mesh: with many parts no thread waits long for another.
_PARTS = 8
#: The smallest part, as a share of `SERIAL_BELOW`. Smaller parts would cost more than they save.
_LEAST_PART = 0.625
T = TypeVar("T")
#: Seconds between two progress reports during a long task.
_POLL = 0.1
_BLOCK = 1 << 16


def ignore_progress(done: float) -> None:
    """Does nothing with the progress."""


def part_of(progress: Progress, start: float, stop: float) -> Progress:
    """Returns the progress of a part of the work that runs from the share `start` of the whole to `stop`."""
    return lambda share: progress(start + share * (stop - start))


def rising(progress: Progress, start: float = 0.0, stop: float = 1.0) -> Progress:
    """Returns a progress function like that of `part_of`, but the reported share never falls, even if the work restarts."""
    furthest = 0.0

    def report(share: float) -> None:
        nonlocal furthest
        furthest = max(furthest, share)
        progress(start + (stop - start) * furthest)

    return report


def blocks(count: int) -> Iterator[slice]:
    """Yields the rows from 0 to `count` in blocks of 65,536, for arrays that would not fit into the cache or memory at once."""
    for start in range(0, count, _BLOCK):
        yield slice(start, min(start + _BLOCK, count))


def threads_for(size: int) -> AbstractContextManager[None]:
    """A context in which kernels called from this thread run on one thread if `size`, a number of vertices, is small."""
    return nullcontext() if size >= SERIAL_BELOW else single_thread()


def in_parallel(work: Callable[..., None], tasks: Iterable[tuple[Any, ...]], progress: Progress) -> None:
    """Calls ``work(*task)`` for each task, on as many threads as numba may use. Each task must write to memory of its own.

    The threads are Python threads, and kernels release the GIL. Several threads of a program may call this at once; numba's own
    pool would crash on some platforms. `progress` is called after each task and during long tasks; if it raises, the remaining
    tasks are dropped.
    """
    with ThreadPoolExecutor(allowed_threads()) as pool:
        futures = [pool.submit(work, *task) for task in tasks]
        try:
            for done, future in enumerate(futures):
                while not wait([future], timeout=_POLL).done:
                    progress(done / len(futures))
                future.result()
                progress((done + 1) / len(futures))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def over_range(kernel: Callable[..., None], count: int, *arguments: Any) -> None:
    """Calls ``kernel(*arguments, first, last)`` for ranges that cover 0 to `count`, on several threads if `count` is large.

    A range has the elements from `first` to `last` - 1. The kernel must release the GIL, and write results of each element to
    memory of its own. The calling thread works too: a call ends even if all threads of the pool are busy.
    """
    parts = min(_PARTS * allowed_threads(), count // max(1, int(_LEAST_PART * SERIAL_BELOW)))
    others = min(allowed_threads(), parts) - 1
    if others < 1:
        kernel(*arguments, 0, count)
        return
    waiting = deque((part * count // parts, (part + 1) * count // parts) for part in range(parts))

    def work() -> None:
        while True:
            try:
                first, last = waiting.popleft()
            except IndexError:
                return
            kernel(*arguments, first, last)

    helpers = [_pool_of(os.getpid()).submit(work) for _ in range(others)]
    try:
        work()
    finally:
        waiting.clear()
        for helper in helpers:
            if not helper.cancel():
                helper.result()


@cache
def _pool_of(process: int) -> ThreadPoolExecutor:
    """Returns the one pool for all loops of a process; a forked process needs its own, as threads are not forked."""
    return ThreadPoolExecutor(os.cpu_count())


def abandonable(work: Callable[[], T], progress: Progress, done: float) -> T:
    """Returns the result of `work`, which runs in a separate thread and must release the GIL.

    Meanwhile `progress` is called ten times a second with `done`, the finished share before `work`. If `progress` raises, the
    thread is abandoned: it ends when `work` returns, and the result is dropped.
    """
    future: Future[T] = Future()
    threads = allowed_threads()

    def run() -> None:
        set_threads(threads)
        try:
            future.set_result(work())
        except BaseException as error:  # raised again in the waiting thread
            future.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    while not wait([future], timeout=_POLL).done:
        progress(done)
    return future.result()


__all__ = [
    "Progress",
    "abandonable",
    "blocks",
    "ignore_progress",
    "in_parallel",
    "over_range",
    "part_of",
    "rising",
    "threads_for",
]

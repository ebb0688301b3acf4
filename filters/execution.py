"""Progress, threads, tasks, and library calls that can be abandoned.

Every parallel kernel writes each result from one iteration alone, so the results have the same bits for any number of threads.
Very small meshes are faster on one.
"""

import os
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from functools import cache
from typing import Any, TypeVar

from .compilation import allowed_threads, set_threads, single_thread

#: Called with the share of the work that is done, from 0 to 1; it may raise to stop the work.
Progress = Callable[[float], None]
#: Kernels on fewer vertices run on one thread: waking others costs more than it saves.
SERIAL_BELOW = 20_000
#: The parts for each thread of a loop over a large mesh, enough that no thread waits long for another.
_PARTS = 8
#: No part is smaller than this share of `SERIAL_BELOW`: a loop is often one of many that several threads call already.
_LEAST_PART = 0.625
T = TypeVar("T")
#: Seconds between two reports of the progress while a long task runs, so that the caller can stop the work.
_POLL = 0.1
#: Rows of a block.
_BLOCK = 1 << 16


def ignore_progress(done: float) -> None:
    """No progress."""


def part_of(progress: Progress, start: float, stop: float) -> Progress:
    """The progress of a part of the work, which begins when the share `start` of the whole is done and ends at `stop`."""
    return lambda share: progress(start + share * (stop - start))


def rising(progress: Progress, start: float = 0.0, stop: float = 1.0) -> Progress:
    """As `part_of`, and never less than before, for work that may restart."""
    furthest = 0.0

    def report(share: float) -> None:
        nonlocal furthest
        furthest = max(furthest, share)
        progress(start + (stop - start) * furthest)

    return report


def blocks(count: int) -> Iterator[slice]:
    """The rows from 0 to `count` in blocks of 65,536, where the arrays of all would not fit into the cache or into memory."""
    for start in range(0, count, _BLOCK):
        yield slice(start, min(start + _BLOCK, count))


@contextmanager
def threads_for(size: int) -> Iterator[None]:
    """A context in which kernels called from this thread run on one thread if `size`, a number of vertices, is small."""
    if size >= SERIAL_BELOW:
        yield
        return
    with single_thread():
        yield


def in_parallel(work: Callable[..., None], tasks: Iterable[tuple[Any, ...]], progress: Progress) -> None:
    """Calls ``work(*task)`` for every task, which writes to a place of its own, on as many threads as numba may use.

    The threads are Python's and the kernels release the GIL: a thread that is done takes the next task, and several threads of a
    program may work at once, which numba's own pool does not survive everywhere. `progress` is called after every task and while
    a long one runs; if it raises, the tasks that have not begun are dropped.
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
    """Calls ``kernel(*arguments, first, last)`` so that the ranges cover 0 to `count`, on several threads if that is large.

    The kernel releases the GIL and writes the results of each number from `first` to before `last`, of vertices or faces, to
    places of their own. The calling thread works too, so that calls from threads of a full pool end.
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

    helping = [_kept_pool(os.getpid()).submit(work) for _ in range(others)]
    try:
        work()
    finally:
        waiting.clear()
        for helper in helping:
            if not helper.cancel():
                helper.result()


@cache
def _kept_pool(process: int) -> ThreadPoolExecutor:
    """One pool for all loops of a process: a fork inherits it without its threads."""
    return ThreadPoolExecutor(os.cpu_count())


def abandonable(work: Callable[[], T], progress: Progress, done: float) -> T:
    """The result of `work`, which releases the GIL in a thread of its own, while `progress` is called ten times a second.

    That is with the share of the whole work that was `done` before. If it raises, the thread is abandoned: it ends when its call
    returns, and its result is dropped.
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

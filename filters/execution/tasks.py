"""Tasks of different lengths, run on a pool of threads."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from typing import Any

from ..compilation import allowed_threads
from . import threads
from .progress import Progress

#: Into so many parts for each thread a loop over a large mesh is cut: enough that no thread waits long for another.
_PARTS = 8
#: No part is smaller than this share of `SERIAL_BELOW`: a loop is often one of many that several threads call already.
_LEAST_PART = 0.625
#: Seconds after which the progress is reported again while a long task runs, so that the caller can stop the work.
_PATIENCE = 0.2


def in_parallel(work: Callable[..., None], tasks: Iterable[tuple[Any, ...]], progress: Progress) -> None:
    """Calls ``work(*task)`` for every task on as many threads as numba may use.

    The threads are Python's and the kernels release the GIL. ``prange`` would not do: here a thread that is done takes the next
    task, `progress` is called after every task, and several threads of a program may work at once, which numba's own pool does
    not survive everywhere.

    Args:
        work: writes its result to a place of its own.
        tasks: the arguments of each call.
        progress: called after every task and while a long one runs; may raise, which drops the tasks that have not begun.
    """
    with ThreadPoolExecutor(allowed_threads()) as pool:
        futures = [pool.submit(work, *task) for task in tasks]
        try:
            for done, future in enumerate(futures):
                while not wait([future], timeout=_PATIENCE).done:
                    progress(done / len(futures))
                future.result()
                progress((done + 1) / len(futures))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def over_range(kernel: Callable[..., None], count: int, *arguments: Any) -> None:
    """Calls ``kernel(*arguments, first, last)`` so that the ranges cover 0 to `count`, on several threads if that is large.

    One kernel without the GIL serves small meshes and large ones: waking numba's threads for a small mesh costs as much as the
    work, even if one of them gets all of it. The calling thread works too, so that calls from threads of a full pool end.

    Args:
        kernel: writes the results of each number from `first` to before `last` to places of their own.
        count: of vertices or faces.
        *arguments: of the kernel.
    """
    parts = min(_PARTS * allowed_threads(), count // max(1, int(_LEAST_PART * threads.SERIAL_BELOW)))
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

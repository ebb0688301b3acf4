"""Work shared out among threads, in tasks that differ in length."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, wait
from typing import Any

from numba import get_num_threads

from . import threads  # noqa: F401  chooses numba's threading layer
from .progress import Progress

#: seconds after which a long task's progress is said again, so that whoever hears it can stop the work
_PATIENCE = 0.2


def in_parallel(work: Callable[..., None], tasks: Iterable[tuple[Any, ...]], progress: Progress) -> None:
    """Call ``work(*task)`` for every task on as many threads as numba may use; `progress` may raise to drop the tasks to come.

    A pool of Python threads over kernels without the GIL, and not ``prange``: whoever is done takes the next task, the caller
    hears of every task and can be interrupted, and two threads of a program may do this at once, which numba's own pool does
    not survive everywhere.
    """
    with ThreadPoolExecutor(get_num_threads()) as pool:
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


def part_of(progress: Progress, start: float, stop: float) -> Progress:
    """The progress of a part of the work, which begins when the share `start` of the whole is done and ends at `stop`."""
    return lambda share: progress(start + share * (stop - start))

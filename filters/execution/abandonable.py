"""Runs an uninterruptible library call in a thread that can be abandoned."""

import threading
from collections.abc import Callable
from typing import TypeVar

from .progress import Progress

T = TypeVar("T")
#: Seconds between two reports of the progress.
_POLL = 0.1


def abandonable(work: Callable[[], T], progress: Progress, done: float) -> T:
    """The result of `work`, which runs in a thread of its own while `progress` is called.

    If `progress` raises, the thread is abandoned: it ends when its call returns, and its result is dropped. This helps only with
    calls that release the GIL, as SuperLU and numpy's eigensolver do.

    Args:
        work: the call.
        progress: called about ten times a second with `done`; may raise to stop.
        done: the share of the whole work that was done before.
    """
    results: list[T] = []
    errors: list[BaseException] = []

    def run() -> None:
        try:
            results.append(work())
        except BaseException as error:  # raised again in the waiting thread
            errors.append(error)

    worker = threading.Thread(target=run, daemon=True)
    worker.start()
    while worker.is_alive():
        worker.join(_POLL)
        progress(done)
    if errors:
        raise errors[0]
    return results[0]

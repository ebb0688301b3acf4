"""Work of one long call into a library, which nobody can interrupt but anybody can turn away from."""

import threading
from collections.abc import Callable
from typing import TypeVar

from .progress import Progress

T = TypeVar("T")
_POLL = 0.1


def abandonable(work: Callable[[], T], progress: Progress, done: float) -> T:
    """The result of `work`, done in a thread so that `progress` is called meanwhile with `done`.

    If `progress` raises, the thread is left to itself: it ends with its call, and what it has made goes with it. That helps only
    with calls that let other threads run, as SuperLU and numpy's eigensolver do.
    """
    results: list[T] = []
    errors: list[BaseException] = []

    def run() -> None:
        try:
            results.append(work())
        except BaseException as error:  # told to the one who waits
            errors.append(error)

    worker = threading.Thread(target=run, daemon=True)
    worker.start()
    while worker.is_alive():
        worker.join(_POLL)
        progress(done)
    if errors:
        raise errors[0]
    return results[0]

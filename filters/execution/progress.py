"""The share of the work that is done, as long work reports it."""

from collections.abc import Callable

#: Called with the share of the work that is done, from 0 to 1; it may raise to stop the work.
Progress = Callable[[float], None]


def ignore_progress(done: float) -> None:
    """The progress of a caller who does not ask for any."""


def part_of(progress: Progress, start: float, stop: float) -> Progress:
    """The progress of a part of the work, which begins when the share `start` of the whole is done and ends at `stop`."""
    return lambda share: progress(start + share * (stop - start))


def rising(progress: Progress, start: float = 0.0, stop: float = 1.0) -> Progress:
    """As `part_of`, and never less than before, for work that may begin once more."""
    furthest = 0.0

    def tell(share: float) -> None:
        nonlocal furthest
        furthest = max(furthest, share)
        progress(start + (stop - start) * furthest)

    return tell

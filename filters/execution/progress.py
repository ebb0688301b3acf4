"""How long work tells how far it is."""

from collections.abc import Callable

#: Called with the share of the work that is done, from 0 to 1; it may raise to stop the work.
Progress = Callable[[float], None]


def ignore_progress(done: float) -> None:
    """The progress of someone who does not want to know."""

"""Rarer garbage collection, since most processes live for seconds, and most objects as long as their process."""

import atexit
import gc


def collect_seldom() -> None:
    """Collects garbage rarely, not at exit: collections during work and at exit each took a tenth of a command's start time."""
    gc.set_threshold(50_000, 20, 50)
    atexit.register(gc.freeze)

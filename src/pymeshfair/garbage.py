"""Rarer garbage collection, since most processes live for seconds, and most objects as long as their process."""

import atexit
import gc


def collect_seldom() -> None:
    """Collects garbage rarely, and not at exit, as each of the two kinds of collection took a tenth of a command's start time."""
    gc.set_threshold(50_000, 20, 50)
    atexit.register(gc.freeze)

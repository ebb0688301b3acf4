"""Rare garbage collection: a process of ours lives for seconds, and most of its objects live to its end."""

import atexit
import gc


def collect_seldom() -> None:
    """Look for garbage seldom, and not at all at the end: a tenth of a command's start each went into being looked through."""
    gc.set_threshold(50_000, 20, 50)
    atexit.register(gc.freeze)

"""Rare garbage collection: a process of ours lives for seconds, and most of its objects live to its end."""

import atexit
import gc

#: new objects until Python looks through them, instead of 700, and how often it looks through older ones with them
_NEW, _SELDOM, _SELDOMER = 50_000, 20, 50


def collect_seldom() -> None:
    """Look for garbage seldom, and not at all at the end.

    Importing what a command needs makes some hundred thousand objects, of which a tenth of the start went into being looked
    through, and another tenth at the end.
    """
    gc.set_threshold(_NEW, _SELDOM, _SELDOMER)
    atexit.register(gc.freeze)

"""Where compiled kernels are kept, and when one has to be compiled.

Numba keeps compiled code beside the sources or in the user's cache folder, and refuses to import a module of kernels where it
can write to neither: a package installed by an administrator, run by an account without a home, as containers do.
"""

import atexit
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any


def ensure_kernel_cache() -> None:
    """Let numba keep this process's kernels in a temporary folder if nothing else can be written to.

    They are compiled again in the next process; the environment variable NUMBA_CACHE_DIR names a folder that lasts.
    """
    if "NUMBA_CACHE_DIR" in os.environ or os.access(Path(__file__).parent, os.W_OK):
        return
    import numba

    try:
        numba.njit(cache=True)(_probe)
    except RuntimeError:
        # A fresh folder of our own: compiled code from a place where others can write would be theirs to choose.
        folder = tempfile.mkdtemp(prefix="pymeshfair-kernels-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        config: Any = numba.config
        config.CACHE_DIR = folder


def on_first_compilation(tell: Callable[[], None]) -> None:
    """Call `tell` once, when this process first compiles a kernel instead of finding it compiled; that takes seconds."""
    from numba.core import event

    class Once(event.Listener):
        """Tells of the first beginning."""

        told = False

        def on_start(self, event: object) -> None:
            if not self.told:
                self.told = True
                tell()

        def on_end(self, event: object) -> None:
            """Nobody waits for it."""

    register: Any = event.register
    register("numba:compile", Once())


def _probe() -> None:
    """Something to compile."""

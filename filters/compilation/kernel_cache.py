"""The cache of compiled kernels, and a notice when one has to be compiled.

Numba keeps compiled code beside the sources or in the user's cache folder. Where it can write to neither it refuses to import a
module of kernels: in a container, for example, where an administrator installed the package and the account has no home.
"""

import atexit
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any


def ensure_kernel_cache() -> None:
    """Makes numba keep this process's kernels in a temporary folder if it can write nowhere else.

    The next process compiles them again; the environment variable NUMBA_CACHE_DIR names a folder that lasts.
    """
    if "NUMBA_CACHE_DIR" in os.environ or os.access(Path(__file__).parent, os.W_OK):
        return
    import numba

    try:
        numba.njit(cache=True)(_probe)
    except RuntimeError:
        # A new folder of our own: in a folder where others can write, they could replace the compiled code.
        folder = tempfile.mkdtemp(prefix="pymeshfair-kernels-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        config: Any = numba.config
        config.CACHE_DIR = folder


def on_first_compilation(tell: Callable[[], None]) -> None:
    """Calls `tell` once, when this process first compiles a kernel, which takes seconds, instead of loading it."""
    from numba.core import event

    class Once(event.Listener):
        """Calls `tell` at the first start of a compilation."""

        told = False

        def on_start(self, event: object) -> None:
            if not self.told:
                self.told = True
                tell()

        def on_end(self, event: object) -> None:
            """Required by numba."""

    register: Any = event.register
    register("numba:compile", Once())


def _probe() -> None:
    """Something to compile."""

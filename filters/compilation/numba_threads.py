"""Numba, imported when it is first needed, and how many threads it may use."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import cache
from typing import Any

_LOCK = threading.Lock()


@cache
def load_numba() -> Any:
    """The module numba."""
    import numba

    # Numba tries Intel TBB first and warns when it finds an old one, such as that in the pymeshlab wheel. OpenMP is as fast.
    if "NUMBA_THREADING_LAYER" not in os.environ and "NUMBA_THREADING_LAYER_PRIORITY" not in os.environ:
        config: Any = numba.config
        config.THREADING_LAYER_PRIORITY = ["omp", "tbb", "workqueue"]
    return numba


def call_parallel(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call what shares its work among numba's threads.

    Where OpenMP is missing, as on a bare Linux and on macOS, these are numba's own, which end the process when two threads of a
    program call them at once: there one waits for the other.
    """
    try:
        is_safe = load_numba().threading_layer() != "workqueue"
    except ValueError:  # they are started by the first call
        is_safe = False
    with nullcontext() if is_safe else _LOCK:
        return function(*arguments)


def load_compiler() -> None:
    """Load numba and its tables of types now, rather than when the first kernel is called.

    Only while this is the one thread that imports: numba asks whether scipy's linear algebra is there by importing all of it, and
    is told here that it is. A kernel that uses it loads it then.
    """
    load_numba()
    name = "scipy.linalg.cython_blas"
    if name not in sys.modules and "numba.np.arraymath" not in sys.modules:
        blocked: Any = None
        sys.modules[name] = blocked
        try:
            from numba.np import arraymath
        finally:
            del sys.modules[name]
        tables: Any = arraymath
        tables._HAVE_BLAS = True
    from numba.core.registry import cpu_target

    cpu_target.target_context.refresh()


def allowed_threads() -> int:
    """How many threads kernels called from this thread may use."""
    return int(load_numba().get_num_threads())


@contextmanager
def single_thread() -> Iterator[None]:
    """A context in which kernels called from this thread use one thread."""
    numba = load_numba()
    allowed = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        yield
    finally:
        numba.set_num_threads(allowed)

"""The threads of parallel kernels: OpenMP's, through numba's module, or numba's own where there is no OpenMP."""

import ctypes
import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import cache
from typing import Any

from .machine_code import extension

#: The functions that parallel code calls besides ``numba_parallel_for``.
_FUNCTIONS = (
    *("do_scheduling_signed", "do_scheduling_unsigned", "allocate_sched", "deallocate_sched", "get_sched_size"),
    *("get_num_threads", "set_num_threads", "get_thread_id", "set_parallel_chunksize", "get_parallel_chunksize"),
)
_OF_THREAD = threading.local()


@cache
def most_threads() -> int:
    """The number of threads: one a processor that this process may use, or NUMBA_NUM_THREADS."""
    if count := os.environ.get("NUMBA_NUM_THREADS"):
        return max(1, int(count))
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def allowed_threads() -> int:
    """The number of threads that kernels called from this thread may use."""
    return int(getattr(_OF_THREAD, "count", most_threads()))


def set_threads(count: int) -> None:
    """Let kernels called from this thread use so many threads, from 1 to `most_threads`."""
    if not 1 <= count <= most_threads():
        raise ValueError(f"the number of threads must be from 1 to {most_threads()}, got {count}")
    _OF_THREAD.count = count


@contextmanager
def single_thread() -> Iterator[None]:
    """A context in which kernels called from this thread use one thread."""
    before = allowed_threads()
    set_threads(1)
    try:
        yield
    finally:
        set_threads(before)


def call_parallel(code: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    """Call a parallel kernel with its threads started, and no more of them than this thread allows.

    Where OpenMP is missing, as on a bare Linux and on macOS, the threads are numba's own, which end the process when two threads
    of a program call them at once: there one waits for the other.
    """
    set_number, turns = start_threads()
    with turns:
        set_number(allowed_threads())
        return code(*arguments)


@cache
def start_threads() -> tuple[Any, Any]:
    """Start the threads, whose functions parallel code is linked with.

    Returns:
        The function that sets the number of threads for this thread, and the lock, if only one thread may call at a time.
    """
    import llvmlite.binding as llvm

    turns: Any = nullcontext()
    try:
        layer = extension("np.ufunc.omppool")
    except ImportError:
        layer, turns = extension("np.ufunc.workqueue"), threading.Lock()
    llvm.add_symbol("numba_parallel_for", layer.parallel_for)
    for name in _FUNCTIONS:
        llvm.add_symbol(name, getattr(layer, name))
    ctypes.CFUNCTYPE(None, ctypes.c_int)(layer.launch_threads)(most_threads())
    return ctypes.CFUNCTYPE(None, ctypes.c_int)(layer.set_num_threads), turns

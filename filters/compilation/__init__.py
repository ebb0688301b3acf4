"""Kernels: functions that run as machine code, compiled once by numba in a separate process, and loaded without numba."""

from .kernel import (
    Compilation,
    allowed_threads,
    compile_ahead,
    compiled,
    listed_signatures,
    on_compilation,
    prange,
    set_threads,
    single_thread,
)
from .machine_code import Stored, most_threads, processor, stored

__all__ = [
    "Compilation",
    "Stored",
    "allowed_threads",
    "compile_ahead",
    "compiled",
    "listed_signatures",
    "most_threads",
    "on_compilation",
    "prange",
    "processor",
    "set_threads",
    "single_thread",
    "stored",
]

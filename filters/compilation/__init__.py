"""Functions that run as machine code: compiled once by numba, in a process of its own, and loaded without numba."""

from .ahead import compile_ahead, listed_signatures, signatures_of
from .kernel import Compilation, compiled, loaded_kernels, on_compilation, prange
from .machine_code import Stored, processor, stored
from .threads import allowed_threads, most_threads, set_threads, single_thread

__all__ = [
    "Compilation",
    "Stored",
    "allowed_threads",
    "compile_ahead",
    "compiled",
    "listed_signatures",
    "loaded_kernels",
    "most_threads",
    "on_compilation",
    "prange",
    "processor",
    "set_threads",
    "signatures_of",
    "single_thread",
    "stored",
]

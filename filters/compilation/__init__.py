"""Functions that numba compiles: when they are first called, and kept for all later processes."""

from .ahead import compile_ahead, listed_signatures, signatures_of
from .kernel import compiled, loaded_kernels, prange
from .notices import Compilation, on_compilation
from .numba_threads import allowed_threads, load_compiler, single_thread
from .store import Stored, stored

__all__ = [
    "Compilation",
    "Stored",
    "allowed_threads",
    "compile_ahead",
    "compiled",
    "listed_signatures",
    "load_compiler",
    "loaded_kernels",
    "on_compilation",
    "prange",
    "signatures_of",
    "single_thread",
    "stored",
]

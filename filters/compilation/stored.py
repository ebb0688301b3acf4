"""The cache that numba asks for the machine code of a kernel, in the place of its own."""

from __future__ import annotations

import hashlib
import pickle
from typing import TYPE_CHECKING, Any

from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from . import store

if TYPE_CHECKING:
    from .kernel import Kernel


class StoredKernels(NullCache):
    """Loads and saves what was compiled of one kernel, by its fingerprint and the types of the arguments."""

    def __init__(self, kernel: Kernel) -> None:
        """See the class."""
        self._kernel = kernel

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """What was compiled for these types, or None; numba calls this before it compiles."""
        target_context.refresh()  # numba needs its tables before it can take anything in
        content = store.read(store.compiled_here(target_context.codegen().magic_tuple()), self._name(sig))
        if content is None:
            return None
        try:
            rebuild: Any = CompileResult._rebuild
            return rebuild(target_context, *pickle.loads(content))
        except (EOFError, pickle.UnpicklingError):  # a disk that was full or has failed
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled; numba calls this after it has compiled."""
        if data.library.has_dynamic_globals or any(not lifted.can_cache for lifted in data.lifted):
            return  # it holds addresses of this process
        serialise: Any = dumps
        store.write(store.compiled_here(data.codegen.magic_tuple()), self._name(sig), serialise(data._reduce()))

    def _name(self, sig: Any) -> str:
        types = repr(sig)
        if " at 0x" in types:
            # Kernels among the arguments: their type tells an address, of this process alone.
            types = repr([getattr(getattr(t, "dispatcher", None), "kernel", t) for t in sig])
        key = hashlib.sha256(f"{self._kernel.fingerprint} {types}".encode()).hexdigest()
        return f"{self._kernel.__module__.rpartition('.')[2]}.{self._kernel.__qualname__}-{key[:32]}"

"""What a worker had to load while it worked, so that the process it was forked from loads it once for all that follow.

Loading a kernel from numba's cache takes milliseconds, a module of scipy too: half a second together for a small scan whose
filtering takes a hundredth.
"""

from __future__ import annotations

import contextlib
import importlib
import pickle
import sys
from collections.abc import Iterator
from typing import Any, TypeAlias

from ..filters.compilation import loaded_kernels

#: modules, and kernels as module, name and signature
Loaded: TypeAlias = tuple[frozenset[str], frozenset[tuple[str, str, tuple[Any, ...]]]]


def loaded() -> Loaded:
    """What this process has loaded so far: modules, and kernels of pymeshfair's filters with their signatures."""
    return frozenset(sys.modules), frozenset((m, n, s) for m, n, kernel in _kernels() for s in kernel.signatures)


def _kernels() -> Iterator[tuple[str, str, Any]]:
    """Every compiled function of ours: its module, its name, and itself.

    But for those that share their work among numba's own threads, which must not be there when a process is forked.
    """
    return ((module, name, kernel) for module, name, kernel in loaded_kernels("pymeshfair") if not kernel.options.get("parallel"))


def loaded_since(before: Loaded) -> bytes:
    """What this process has loaded since then, for `load` in another process."""
    now = loaded()
    modules, kernels = now[0] - before[0], now[1] - before[1]
    return pickle.dumps((sorted(modules), list(kernels))) if modules or kernels else b""


def load(data: bytes) -> Iterator[None]:
    """Load what `loaded_since` told, one thing at a step; what cannot be loaded is left to those who need it."""
    modules, kernels = pickle.loads(data)
    for name in modules:
        with contextlib.suppress(Exception):
            importlib.import_module(name)
        yield
    for module, name, signature in kernels:
        with contextlib.suppress(Exception):
            getattr(sys.modules[module], name).compile(signature)
        yield

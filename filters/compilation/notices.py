"""Tells when kernels have to be compiled, which takes seconds, instead of being loaded."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from .store import lasts


@dataclass(frozen=True)
class Compilation:
    """What this process has compiled so far.

    Attributes:
        kernels: how many, one of which may be in work; those that they call are not counted.
        seconds: how long that has taken.
        is_going_on: whether one is in work.
        lasts: whether later processes find it compiled.
    """

    kernels: int = 0
    seconds: float = 0.0
    is_going_on: bool = False
    lasts: bool = True


_listeners: list[Callable[[Compilation], None]] = []
_so_far = [Compilation()]


def on_compilation(tell: Callable[[Compilation], None]) -> None:
    """Calls `tell` whenever this process begins to compile a kernel, and when it has done so."""
    _listeners.append(tell)


@contextmanager
def compiling() -> Iterator[None]:
    """A context in which a kernel is compiled."""
    before = replace(_so_far[0], lasts=lasts())
    _tell(replace(before, kernels=before.kernels + 1, is_going_on=True))
    started = time.perf_counter()
    try:
        yield
    finally:
        _tell(replace(_so_far[0], seconds=before.seconds + time.perf_counter() - started, is_going_on=False))


def _tell(so_far: Compilation) -> None:
    _so_far[0] = so_far
    for tell in _listeners:
        tell(so_far)

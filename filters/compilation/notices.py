"""Tells when kernels have to be compiled, which takes seconds, instead of being loaded."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

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

    kernels: int
    seconds: float
    is_going_on: bool
    lasts: bool


_listeners: list[Callable[[Compilation], None]] = []


def on_compilation(tell: Callable[[Compilation], None]) -> None:
    """Calls `tell` whenever this process begins to compile a kernel, and when it has done so."""
    _listeners.append(tell)


@cache
def listen_to_numba() -> None:
    """Hear from numba what it compiles from now on."""
    from numba.core import event

    class Listener(event.Listener):
        """Hears of every kernel, and inside of that of those that it calls."""

        depth, kernels, seconds, started = 0, 0, 0.0, 0.0

        def on_start(self, event: object) -> None:
            """A kernel begins."""
            self.depth += 1
            if self.depth == 1:
                self.kernels += 1
                self.started = time.perf_counter()
                self._tell(True)

        def on_end(self, event: object) -> None:
            """A kernel is done, or cannot be compiled."""
            self.depth -= 1
            if self.depth == 0:
                self.seconds += time.perf_counter() - self.started
                self._tell(False)

        def _tell(self, is_going_on: bool) -> None:
            for tell in _listeners:
                tell(Compilation(self.kernels, self.seconds, is_going_on, lasts()))

    register: Any = event.register
    register("numba:compile", Listener())

"""Processes of this machine that wait for orders and are lent for one at a time."""

from __future__ import annotations

import importlib
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any

from ..errors import RunError
from .forked import can_fork
from .order import Answer, Order
from .process import LostProcessError, Process

#: the count of processes that may be lost with one task
_LOST = 4


class Pool:
    """So many processes at most, each started when it is needed; a context manager that leaves none behind.

    May be used from several threads. A process that ended, or was given back in the middle of an order, is not lent again.
    """

    def __init__(
        self, most: int = 1, threads: int | None = None, modules: Sequence[str] = (), *, rest_after: float | None = None
    ) -> None:
        """See the class.

        Args:
            most: processes at a time.
            threads: that a filter may use in each, see `pymeshfair.processes.environment.worker_environment`.
            modules: those that each imports before its first order.
            rest_after: seconds after which processes that have nothing to do are ended; None keeps them.
        """
        self._rest_after = rest_after
        self._clock: threading.Timer | None = None
        self._most = most
        self._threads = threads
        self._modules = modules
        self._free = threading.Semaphore(most)
        self._callers = ThreadPoolExecutor(most)
        self._lock = threading.Lock()
        self._idle: list[Process] = []
        self._lent: set[Process] = set()
        self._is_over = False

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End all processes, and lend no more; tasks that were submitted are not begun or fail."""
        self._callers.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            self._is_over = True
            lent = list(self._lent)
        for process in lent:
            process.kill()
        self._callers.shutdown()
        self.rest()

    def check_open(self) -> None:
        """Raise `RunError` once it is closed."""
        if self._is_over:
            raise RunError("the workers are ended")

    def prepare(self) -> None:
        """Start all processes ahead: as copies of this one, which loads the modules for that, where that is sound."""
        if not can_fork():
            self._idle += [Process(self._threads, self._modules) for _ in range(self._most)]
            return
        for name in self._modules:
            importlib.import_module(name)
        self._idle += [Process(self._threads, forked=can_fork()) for _ in range(self._most)]

    def rest(self) -> None:
        """End the processes that have nothing to do."""
        with self._lock:
            idle, self._idle = self._idle, []
        for process in idle:
            process.close()

    @contextmanager
    def lend(self) -> Iterator[Process]:
        """A process, for as long as the context lasts."""
        with self._free:
            with self._lock:
                self.check_open()
                process = self._idle.pop() if self._idle else Process(self._threads, self._modules)
                self._lent.add(process)
            try:
                yield process
            finally:
                with self._lock:
                    self._lent.remove(process)
                    if is_kept := process.is_idle and not self._is_over and not process.has_ended():
                        self._idle.append(process)
                if not is_kept:
                    process.close()
                elif self._rest_after is not None:
                    self._rest_later(self._rest_after)

    def _rest_later(self, seconds: float) -> None:
        with self._lock:
            if self._clock is not None:
                self._clock.cancel()
            self._clock = threading.Timer(seconds, self.rest)
            self._clock.daemon = True
            self._clock.start()

    def submit(self, task: Callable[..., Any], *arguments: Any, memory_limit: int | None = None) -> Future[Answer]:
        """Do a task as soon as a process is free; it begins again if its process is lost.

        The future raises `LostProcessError` if that happens time and again.
        """
        return self._callers.submit(self._do, Order.of(task, *arguments, memory_limit=memory_limit))

    def _do(self, order: Order) -> Answer:
        for _ in range(_LOST - 1):
            with suppress(LostProcessError), self.lend() as process:
                return process.do(order)
        with self.lend() as process:
            return process.do(order)

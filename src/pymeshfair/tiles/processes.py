"""The workers of this machine: processes that take tasks from a pipe, so that no port is open to others.

``python -m pymeshfair.tiles.processes`` is one of them. It reads its limit of memory from stdin, then tasks one after the other,
and writes what came of each to stdout, all of that pickled. It ends when stdin is closed.
"""

from __future__ import annotations

import io
import os
import pickle
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from queue import SimpleQueue
from types import TracebackType
from typing import Any, BinaryIO

from ..garbage import collect_seldom
from ..operating_system import this_system
from ..running.started import FreshProcess
from ..running.worker import silence, take_over_streams
from .answers import Answer, LostWorkerError, answer

#: how many processes may be lost with one task
_LOST = 4


class Processes:
    """So many processes, each of which does one task at a time; a context manager that leaves none behind."""

    def __init__(self, count: int, threads: int, memory: int) -> None:
        """See the class; a process is started with its first task.

        Args:
            count: how many.
            threads: that a filter may use in each.
            memory: bytes that each may take.
        """
        self._all = [_Process(threads, memory) for _ in range(count)]
        self._idle: SimpleQueue[_Process] = SimpleQueue()
        for process in self._all:
            self._idle.put(process)
        self._callers = ThreadPoolExecutor(count)

    def __enter__(self) -> Processes:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._callers.shutdown(wait=False, cancel_futures=True)
        for process in self._all:
            process.stop()
        self._callers.shutdown()
        for process in self._all:
            process.drop()

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Answer]:
        """Do a task as soon as a process is free; it begins again if its process is lost.

        The future raises `LostWorkerError` if all of them are.
        """
        return self._callers.submit(self._do, (task, *arguments))

    def is_there(self) -> bool:
        """Whether answers are still to be expected."""
        return True

    def _do(self, call: tuple[Any, ...]) -> Answer:
        process = self._idle.get()
        try:
            return process.do(call)
        finally:
            self._idle.put(process)


class _Process:
    """One process, and another one in its place whenever it is lost."""

    def __init__(self, threads: int, memory: int) -> None:
        self._threads = threads
        self._memory = memory
        self._lock = threading.Lock()
        self._process: FreshProcess | None = None
        self._is_over = False

    def do(self, call: tuple[Any, ...]) -> Answer:
        """A task and its arguments, done."""
        for _ in range(_LOST):
            process = self._running()
            try:
                _send(process.stdin, call)
                done: Answer = pickle.load(process.stdout)
            except (OSError, EOFError, pickle.UnpicklingError):  # it was killed, perhaps in the middle of its answer
                self.drop()
            else:
                return done
        raise LostWorkerError(f"every worker that began a tile was lost, {_LOST} in all")

    def _running(self) -> FreshProcess:
        with self._lock:
            if self._is_over:
                raise LostWorkerError("the workers are ended")
            if self._process is None:
                self._process = FreshProcess(self._threads, __spec__.name)
                with suppress(OSError):  # it is gone already, which the task meets, too
                    _send(self._process.stdin, self._memory)
            return self._process

    def stop(self) -> None:
        """End it in the middle of its task, and start no other."""
        with self._lock:
            self._is_over = True
            if self._process is not None:
                self._process.kill()

    def drop(self) -> None:
        """End it, if it has not ended by itself; not while another thread speaks with it."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for stream in (process.stdin, process.stdout, process.stderr):
                with suppress(OSError):  # what it was told last has not arrived
                    stream.close()


def _send(stream: Any, value: Any) -> None:
    stream.write(pickle.dumps(value))  # whole: what cannot be pickled leaves no half of itself in the pipe
    stream.flush()


def main() -> None:
    """Do what stdin says, in a process of its own."""
    collect_seldom()
    orders, reports = take_over_streams()
    silence(2)
    calls: SimpleQueue[Any] = SimpleQueue()
    threading.Thread(target=_read, args=(orders, calls), daemon=True).start()
    this_system().limit_memory(calls.get())
    stream = io.BufferedWriter(reports)
    while True:
        _send(stream, answer(*calls.get()))


def _read(orders: BinaryIO, calls: SimpleQueue[Any]) -> None:
    """Read what there is to do; the process ends with whoever says it, also in the middle of a task."""
    try:
        while True:
            calls.put(pickle.load(orders))
    finally:
        os._exit(1)


if __name__ == "__main__":
    main()

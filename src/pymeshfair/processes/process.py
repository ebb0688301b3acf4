"""The parent's side of worker processes: starts them as new interpreters or as forks, sends orders, and pools them."""

from __future__ import annotations

import ctypes
import gc
import importlib
import locale
import math
import os
import pickle
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, suppress
from queue import Empty, SimpleQueue
from typing import IO, Any, TypeAlias

from ..errors import RunError
from ..operating_system import this_system
from .environment import TRIM_THRESHOLD, program_of, worker_environment
from .worker import END_OF_TALK, Answer, Order, serve

#: the items from a process: ``("event", value)``, which a task reports; ``("talk", line)``, a line on stderr; at the end of a
#: task ``("answer", Answer)``, and ``("silent", None)`` after the task's last line on stderr; ``("end", None)`` twice: when the
#: stdout of the process is closed, and when its stderr is closed
Items: TypeAlias = SimpleQueue[tuple[str, Any]]

_LINE_LIMIT = 4096  # the greatest length of a line on stderr, in bytes
_PATIENCE = 5.0  # seconds to wait for a killed process; it takes longer only if a disk does not answer
#: seconds between two checks of a silent process, and to wait for the rest of its stderr after the answer
_PULSE = 0.5
_MOST_LOST = 4  # see `Pool.submit`
#: the number of the trim threshold among the parameters of the C function ``mallopt``
_M_TRIM_THRESHOLD = -1


class LostProcessError(RunError):
    """A process ended in the middle of a task."""

    def __init__(self, status: int) -> None:
        super().__init__(f"the worker process ended with status {status}")
        self.status = status  # as `Process.wait` returns it


class Process:
    """A worker process, which does one order at a time."""

    def __init__(self, threads: int | None = None, modules: Sequence[str] = (), *, forked: bool = False) -> None:
        """Starts the process: a fork of this process, or a new interpreter, which imports `modules` while it waits for orders.

        `threads` is the number of threads that a filter may use, see `worker_environment`.
        """
        self._system = this_system()
        # In its own session the process gets no Ctrl-C from the terminal, and one signal ends it with all its children.
        self._process: Any = (
            ForkedProcess(threads)
            if forked
            else subprocess.Popen(
                [*program_of("pymeshfair.processes.worker"), *modules],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env=worker_environment(threads),
                **self._system.own_session(),
            )
        )
        self.pid = self._process.pid
        self.is_idle = True
        self._items: Items = SimpleQueue()
        self._readers: list[threading.Thread] = []  # are started with the first order, so that this process can fork until then

    def do(
        self,
        order: Order,
        take: Callable[[str, Any], None] = lambda kind, item: None,
        *,
        items: Items | None = None,
        pulse: Callable[[], float] = lambda: _PULSE,
    ) -> Answer:
        """Sends an order and waits for the answer; raises `LostProcessError` if the process ends without one.

        `take` is called with each event, each line on stderr and each item that other threads add to `items`; `pulse` is called
        before each wait for an item, and returns the most seconds to wait. If one of them raises, `do` ends.
        """
        self.is_idle, self._items = False, SimpleQueue() if items is None else items
        if not self._readers:
            for read, stream in ((self._read_reports, self._process.stdout), (self._read_talk, self._process.stderr)):
                self._readers.append(threading.Thread(target=read, args=(stream,), daemon=True))
                self._readers[-1].start()
        with suppress(OSError):  # the process has ended already
            pickle.dump(order, self._process.stdin)
            self._process.stdin.flush()
        answer: Answer | None = None
        missing = {"answer", "silent"}
        while missing:
            try:
                kind, item = self._items.get(timeout=pulse())
            except Empty:
                if answer is not None:
                    break  # a child of the worker holds stderr open
                kind, item = "end" if self.has_ended() else "", None
            if kind == "end" and answer is None:
                with suppress(Empty):  # reads its last lines on stderr
                    while (item := self._items.get(timeout=_PULSE))[0] != "end":
                        if item[0] == "talk":
                            take(*item)
                raise LostProcessError(self.wait())
            missing.discard(kind)
            if kind == "answer":
                answer = item
            elif kind not in ("", "end", "silent"):
                take(kind, item)
        assert answer is not None
        self.is_idle = not missing and not answer.is_used_up
        return answer

    def has_ended(self) -> bool:
        """Returns whether the process has ended; processes that it started may still hold its pipes open."""
        return self._process.returncode is not None or self._system.has_ended(self._process)

    def wait(self) -> int:
        """Waits for the end of the process; returns its exit status, or minus the number of the signal that ended it."""
        return int(self._process.wait())

    def kill(self) -> None:
        """Ends the process, and under POSIX its process group; any thread may call this."""
        if self._process.returncode is None:  # else another process may have its number by now
            self._system.kill(self._process)

    def close(self) -> None:
        self.kill()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_PATIENCE)
        for reader in self._readers:
            reader.join(1.0)
        for stream in (self._process.stdin, self._process.stdout, self._process.stderr):
            with suppress(OSError):  # the process has not read its last order
                stream.close()

    def _read_reports(self, stream: IO[bytes]) -> None:
        with suppress(EOFError, pickle.UnpicklingError, ValueError, OSError):  # the process was killed
            while True:
                item = pickle.load(stream)
                self._items.put(item)  # to the queue of the current order
        self._items.put(("end", None))

    def _read_talk(self, stream: IO[bytes]) -> None:
        with suppress(ValueError, OSError):
            while line := stream.readline(_LINE_LIMIT):
                if line.strip() == END_OF_TALK.strip():
                    self._items.put(("silent", None))
                elif text := line.decode("utf-8", "replace").rstrip():
                    self._items.put(("talk", text))
        self._items.put(("end", None))


def is_fork_safe() -> bool:
    """Returns whether a fork of this process is safe, and gives the same results as a new interpreter.

    It is not safe if other threads run, since their locks stay locked in the fork, or if the libraries of the system do not allow
    it. Results may differ if the encoding of file names is not UTF-8.
    """
    is_alone = this_system().can_fork and len(os.listdir("/proc/self/task")) == 1  # noqa: PTH208 - names alone
    return is_alone and sys.getfilesystemencoding() == "utf-8"


class ForkedProcess:
    """A fork of this process that serves orders, with all modules loaded; has the methods of `subprocess.Popen` used here."""

    def __init__(self, threads: int | None) -> None:
        (orders, stdin), (stdout, answers), (stderr, talk) = (os.pipe() for _ in range(3))
        child_ends = [orders, answers, talk]
        gc.freeze()  # so that both processes share the memory of all present objects
        self.pid = os.fork()
        if self.pid == 0:
            _become_worker(child_ends, worker_environment(threads))
        for descriptor in child_ends:
            os.close(descriptor)
        self.returncode: int | None = None
        self.stdin: IO[bytes] = os.fdopen(stdin, "wb")
        self.stdout: IO[bytes] = os.fdopen(stdout, "rb")
        self.stderr: IO[bytes] = os.fdopen(stderr, "rb")

    def wait(self, timeout: float | None = None) -> int:
        end = time.monotonic() + (math.inf if timeout is None else timeout)
        while self.returncode is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self.returncode = os.waitstatus_to_exitcode(status)
            elif time.monotonic() >= end:
                raise subprocess.TimeoutExpired("worker", timeout or 0.0)
            else:
                time.sleep(0.005)
        return self.returncode


def _become_worker(pipes: list[int], environment: Mapping[str, str]) -> None:
    try:
        os.setsid()
        for target, descriptor in enumerate(pipes):
            os.dup2(descriptor, target)
        os.closerange(3, os.sysconf("SC_OPEN_MAX"))
        _parents = sys.stdout, sys.stderr  # kept: if freed, they would write what the parent has buffered, and close 1 and 2
        sys.stdout, sys.stderr = (os.fdopen(number, "w", 1, "utf-8", "backslashreplace") for number in (1, 2))
        os.environ.update(environment)
        locale.setlocale(locale.LC_ALL, environment["LC_ALL"])
        with suppress(AttributeError, OSError):
            ctypes.CDLL(None).mallopt(_M_TRIM_THRESHOLD, int(environment[TRIM_THRESHOLD]))
        with suppress(ValueError):  # files in the working folder must not be imported in place of libraries
            sys.path.remove("")
        serve(())
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(1)


class Pool(AbstractContextManager["Pool"]):
    """Lends at most `most` processes, each started when it is needed; a context manager that ends all processes at its exit.

    Several threads may use a pool. A process that ended, is used up, or was returned during an order is not lent again.
    """

    def __init__(
        self, most: int = 1, threads: int | None = None, modules: Sequence[str] = (), *, rest_after: float | None = None
    ) -> None:
        """See the class; idle processes are ended `rest_after` seconds after the last return, or kept if it is None."""
        self._rest_after = rest_after
        self._clock = threading.Timer(0.0, self.rest)
        self.most = most
        self._threads = threads
        self._modules = modules
        self._free = threading.Semaphore(most)
        self._callers = ThreadPoolExecutor(most)
        self._lock = threading.Lock()
        self._idle: list[Process] = []
        self._lent: set[Process] = set()
        self._is_over = False

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends all processes, and lends no more; submitted tasks are cancelled or fail."""
        self._callers.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            self._is_over = True
            self._clock.cancel()
            lent = list(self._lent)
        for process in lent:
            process.kill()
        self._callers.shutdown()
        self.rest()

    def check_open(self) -> None:
        if self._is_over:
            raise RunError("the workers are ended")

    def prepare(self) -> None:
        """Starts all processes at once: as forks of this process, with the modules loaded, where a fork is safe."""
        if is_fork_safe():
            for name in self._modules:
                importlib.import_module(name)
        self._idle += [Process(self._threads, self._modules, forked=is_fork_safe()) for _ in range(self.most)]

    def rest(self) -> None:
        with self._lock:
            idle, self._idle = self._idle, []
        for process in idle:
            process.close()

    @contextmanager
    def lend(self) -> Iterator[Process]:
        with self._free:
            with self._lock:
                self.check_open()
                while self._idle and self._idle[-1].has_ended():
                    self._idle.pop().close()
                process = self._idle.pop() if self._idle else Process(self._threads, self._modules)
                self._lent.add(process)
            try:
                yield process
            finally:
                with self._lock:
                    self._lent.remove(process)
                    if is_kept := process.is_idle and not self._is_over and not process.has_ended():
                        self._idle.append(process)
                        if self._rest_after is not None:
                            self._clock.cancel()
                            self._clock = threading.Timer(self._rest_after, self.rest)
                            self._clock.daemon = True
                            self._clock.start()
                if not is_kept:
                    process.close()

    def submit(self, task: Callable[..., Any], *arguments: Any, memory_limit: int | None = None) -> Future[Answer]:
        """Does a task as soon as a process is free; repeats it if the process is lost.

        The future raises `LostProcessError` if `_MOST_LOST` processes are lost with the task.
        """
        return self.call(self._do, Order.of(task, *arguments, memory_limit=memory_limit))

    def call(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        return self._callers.submit(function, *arguments)

    def _do(self, order: Order) -> Answer:
        for _ in range(_MOST_LOST - 1):
            with suppress(LostProcessError), self.lend() as process:
                return process.do(order)
        with self.lend() as process:
            return process.do(order)

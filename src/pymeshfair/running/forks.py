"""Workers that are forked from one process, which has MeshLab and the filters loaded, so that none takes a second to start."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import threading
from collections.abc import Callable
from functools import partial
from types import TracebackType
from typing import IO, Any

from ..operating_system import this_system
from .environment import program_of, worker_environment
from .fork_server import LONGEST
from .started import RUN, FreshProcess, Started

#: seconds that loading everything may take, compilation not among it, and that a fork may
_LOADING, _FORKING = 120.0, 20.0


class ForkServer:
    """Starts workers; a context manager that ends the process they are forked from. May be used from several threads.

    Where processes cannot be forked safely (elsewhere than on Linux, or if a library has started threads) and when the server
    does not answer, every worker is a fresh process.
    """

    def __init__(self, threads: int | None) -> None:
        """Start the server, without waiting for it; see `worker_environment` for `threads`."""
        self._threads = threads
        self._lock = threading.Lock()
        self._link: _Link | None = None
        self._given_up: list[_Link] = []
        if this_system().can_fork:
            self._link = _Link(threads)

    def __enter__(self) -> ForkServer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """End the server. Workers that it has forked go on, and are ended by whoever started them."""
        with self._lock:
            for link in (*self._given_up, *([self._link] if self._link else ())):
                link.close()
            self._link, self._given_up = None, []

    @property
    def pid(self) -> int | None:
        """The number of the process that workers are forked from; None if they are not."""
        return None if self._link is None else self._link.pid

    def prepare(self) -> None:
        """Wait until workers can be forked, as far as they can, so that their own time does not run meanwhile."""
        with self._lock:
            if self._link is not None:
                self._link.is_ready()

    def start(self, module: str = RUN) -> Started:
        """A worker that waits for its assignment; `module` has the function ``main`` that it is."""
        with self._lock:
            while self._link is not None:
                if (forked := self._link.fork(module)) is not None:
                    return forked
                # It stays for the workers that it has forked. If it was killed another takes its place; whatever else went wrong
                # would again, and cost its time for every worker.
                was_killed = self._link.is_broken and self._link.has_worked
                self._given_up.append(self._link)
                self._link = _Link(self._threads) if was_killed else None
        return FreshProcess(self._threads, module)


class _Link:
    """One server process, and the thread that hears it."""

    def __init__(self, threads: int | None) -> None:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._process = subprocess.Popen(
                [*program_of("pymeshfair.running.fork_server"), str(theirs.fileno())],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=worker_environment(threads),
                pass_fds=[theirs.fileno()],
                start_new_session=True,
            )
        self.pid = self._process.pid
        self._socket = ours
        self._ready = threading.Event()
        self._answered = threading.Event()
        self._answer: dict[str, Any] = {}
        self._workers: dict[int, ForkedProcess] = {}
        self.is_broken = False
        self.has_worked = False
        threading.Thread(target=self._hear, daemon=True).start()

    def is_ready(self) -> bool:
        """Wait until the server has loaded everything; whether it has."""
        return self._ready.wait(_LOADING) and not self.is_broken

    def fork(self, module: str) -> ForkedProcess | None:
        """A new worker, or None if there is none to be had from here."""
        if not self.is_ready():
            return None
        pipes = [os.pipe() for _ in range(3)]
        theirs = [pipes[0][0], pipes[1][1], pipes[2][1]]
        ours = [pipes[0][1], pipes[1][0], pipes[2][0]]
        self._answered.clear()
        try:
            socket.send_fds(self._socket, [json.dumps({"fork": module}).encode("ascii")], theirs)
            answered = self._answered.wait(_FORKING) and not self.is_broken
        except OSError:
            answered, self.is_broken = False, True
        finally:
            for descriptor in theirs:
                os.close(descriptor)
        if not answered or "forked" not in self._answer:
            for descriptor in ours:
                os.close(descriptor)
            return None
        worker = self._workers[self._answer["forked"]]
        worker.open(*ours)
        self.has_worked = True
        return worker

    def _hear(self) -> None:
        while True:
            try:
                data = self._socket.recv(LONGEST)
            except OSError:
                data = b""
            if not data:
                break
            message = json.loads(data)
            if "ready" in message:
                self._ready.set()
            elif "ended" in message:
                self._workers[message["ended"]].end(message["status"])
            else:
                if pid := message.get("forked"):
                    self._workers[pid] = ForkedProcess(pid, partial(self._release, pid))
                self._answer = message
                self._answered.set()
        self.is_broken = True
        self._ready.set()
        self._answered.set()
        for worker in list(self._workers.values()):
            worker.end(-signal.SIGKILL)

    def _release(self, pid: int) -> None:
        self._workers.pop(pid, None)
        with contextlib.suppress(OSError):
            self._socket.send(json.dumps({"release": pid}).encode("ascii"))

    def close(self) -> None:
        """End the server process."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._process.kill()
        self._process.wait()
        self._socket.close()


class ForkedProcess:
    """A worker that was forked, see `Started`; its number is its own until it has been waited for."""

    def __init__(self, pid: int, release: Callable[[], None]) -> None:
        """See the class; `release` gives its number free."""
        self.pid = pid
        self.stdin: IO[bytes]
        self.stdout: IO[bytes]
        self.stderr: IO[bytes]
        self._release = release
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._released = False
        self._status = 0

    def open(self, stdin: int, stdout: int, stderr: int) -> None:
        """Take our ends of its pipes."""
        self.stdin, self.stdout, self.stderr = os.fdopen(stdin, "wb"), os.fdopen(stdout, "rb"), os.fdopen(stderr, "rb")

    def end(self, status: int) -> None:
        """Note that it has ended."""
        self._status = status
        self._ended.set()

    def has_ended(self) -> bool:
        """See `Started`."""
        return self._ended.is_set()

    def wait(self, timeout: float | None = None) -> int | None:
        """See `Started`."""
        if not self._ended.wait(timeout):
            return None
        with self._lock:
            if not self._released:
                self._released = True
                self._kill()  # what it started
                self._release()
        return self._status

    def kill(self) -> None:
        """See `Started`."""
        with self._lock:
            if not self._released:
                self._kill()

    def _kill(self) -> None:
        for send in (os.killpg, os.kill):  # it leads no group before it has come to itself
            with contextlib.suppress(ProcessLookupError, PermissionError):
                send(self.pid, signal.SIGKILL)
                return

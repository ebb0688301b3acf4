"""The process that workers are forked from: ``python -m pymeshfair.running.fork_server DESCRIPTOR``.

It loads MeshLab and the filters once. A fork of a process with several threads is not sound, as a lock that another thread holds
stays locked in it for ever; so it starts none, and refuses to fork if a library has started one.

It speaks with `ForkServer` over a socket, a message at a time, as JSON. It is told ``{"fork": module}`` with three descriptors,
the stdin, stdout and stderr of the worker that the module's ``main`` is, and answers ``{"forked": pid}`` or
``{"refused": reason}``. When a worker ends it says ``{"ended": pid, "status": status}``, and keeps its number from being given to
another until it is told ``{"release": pid}``. It ends when the socket is closed. Nothing here is meant to be called otherwise.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import selectors
import socket
import sys
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .loaded import load, loaded, loaded_since

#: bytes; the longest message, for which sockets have room
LONGEST = 1 << 17
_THREADS = Path("/proc/self/task")


class _Server:
    def __init__(self, control: socket.socket) -> None:
        self._control = control
        self._learning, self._telling = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._telling.setblocking(False)
        self._workers: dict[int, int] = {}
        self._selector = selectors.DefaultSelector()
        self._selector.register(control, selectors.EVENT_READ, self._obey)
        self._selector.register(self._learning, selectors.EVENT_READ, self._learn)
        self._loaded = loaded()
        self._to_load: list[Iterator[None]] = []

    def serve(self) -> None:
        """Obey until the socket is closed."""
        gc.collect()
        gc.freeze()  # what is there now stays shared with the workers
        self._say({"ready": os.getpid()})
        while True:
            for key, _ in self._selector.select(0 if self._to_load else None):
                key.data()
            self._load_some()

    def _say(self, message: dict[str, Any]) -> None:
        with contextlib.suppress(OSError):
            self._control.send(json.dumps(message).encode("ascii"))

    def _obey(self) -> None:
        data, descriptors, _, _ = socket.recv_fds(self._control, LONGEST, 3)
        if not data:
            os._exit(0)  # workers see that their own pipes are closed
        message = json.loads(data)
        if "release" in message:
            self._release(message["release"])
            return
        try:
            self._fork(message["fork"], descriptors)
        finally:
            for descriptor in descriptors:
                os.close(descriptor)

    def _fork(self, module: str, descriptors: list[int]) -> None:
        if (count := len(list(_THREADS.iterdir()))) != 1:
            self._say({"refused": f"a library has started {count - 1} threads"})
            return
        pid = os.fork()
        if pid == 0:
            self._become_worker(module, descriptors)
        watched = os.pidfd_open(pid)
        self._workers[pid] = watched
        self._selector.register(watched, selectors.EVENT_READ, lambda: self._ended(pid))
        self._say({"forked": pid})

    def _become_worker(self, module: str, descriptors: list[int]) -> None:
        try:
            os.setsid()
            self._control.close()
            self._selector.close()
            for watched in self._workers.values():
                os.close(watched)
            for target, descriptor in enumerate(descriptors):
                os.dup2(descriptor, target)
                os.close(descriptor)
            importlib.import_module(module).main(self._tell_what_was_loaded)
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(1)

    def _tell_what_was_loaded(self) -> None:
        with contextlib.suppress(Exception):
            if (data := loaded_since(self._loaded)) and len(data) < LONGEST:
                self._telling.send(data)

    def _learn(self) -> None:
        self._to_load.append(load(self._learning.recv(LONGEST)))

    def _load_some(self) -> None:
        """Load one thing that a worker had to load; whoever waits for a worker does not wait for more."""
        if self._to_load and next(self._to_load[0], self) is self:
            del self._to_load[0]
            self._loaded = loaded()
            gc.freeze()

    def _ended(self, pid: int) -> None:
        result = os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)
        assert result is not None
        self._selector.unregister(self._workers[pid])
        status = result.si_status if result.si_code == os.CLD_EXITED else -result.si_status
        self._say({"ended": pid, "status": status})

    def _release(self, pid: int) -> None:
        os.close(self._workers.pop(pid))
        os.waitpid(pid, 0)


def main() -> None:
    """Load everything, then serve."""
    control = socket.socket(fileno=int(sys.argv[1]))
    from ..registry import all_filters
    from . import session  # noqa: F401  # with MeshLab

    all_filters()
    _Server(control).serve()


if __name__ == "__main__":
    main()

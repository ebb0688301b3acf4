"""A copy of this process that does work: it has everything loaded that this one has, where a new interpreter would begin anew."""

import ctypes
import gc
import locale
import os
import subprocess
import sys
import time
import traceback
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO

from ..operating_system import this_system
from .environment import TRIM_THRESHOLD, worker_environment

_THREADS = Path("/proc/self/task")
#: of the C library's ``mallopt``
_M_TRIM_THRESHOLD = -1


def can_fork() -> bool:
    """Whether a fork of this process is sound, and gives the results of a new one.

    It is not where other threads run, as the lock that one of them holds stays locked in the copy for ever; nor on systems whose
    libraries do not survive it, nor where Python was started with names of files in another encoding than workers have.
    """
    if not this_system().can_fork or sys.getfilesystemencoding() != "utf-8":
        return False
    return len(list(_THREADS.iterdir())) == 1


class ForkedProcess:
    """A fork of this process that runs `pymeshfair.processes.worker.serve`; has what is used of `subprocess.Popen`."""

    def __init__(self, threads: int | None) -> None:
        """Fork; see `worker_environment` for `threads`."""
        pipes = [os.pipe() for _ in range(3)]
        theirs = [pipes[0][0], pipes[1][1], pipes[2][1]]
        ours = [pipes[0][1], pipes[1][0], pipes[2][0]]
        gc.freeze()  # so that both processes share the memory of these objects
        self.pid = os.fork()
        if self.pid == 0:
            _become_worker(theirs, worker_environment(threads))
        for descriptor in theirs:
            os.close(descriptor)
        self.returncode: int | None = None
        self.stdin: IO[bytes] = os.fdopen(ours[0], "wb")
        self.stdout: IO[bytes] = os.fdopen(ours[1], "rb")
        self.stderr: IO[bytes] = os.fdopen(ours[2], "rb")

    def wait(self, timeout: float | None = None) -> int:
        """Its exit status, minus a signal's number if that was the end."""
        if self.returncode is not None:
            return self.returncode
        end = None if timeout is None else time.monotonic() + timeout
        pid, status = os.waitpid(self.pid, 0 if end is None else os.WNOHANG)
        while not pid:
            if end is not None and time.monotonic() >= end:
                raise subprocess.TimeoutExpired("worker", timeout or 0.0)
            time.sleep(0.005)
            pid, status = os.waitpid(self.pid, os.WNOHANG)
        self.returncode = os.waitstatus_to_exitcode(status)
        return self.returncode


def _become_worker(pipes: list[int], environment: Mapping[str, str]) -> None:
    from .worker import serve

    try:
        os.setsid()
        for target, descriptor in enumerate(pipes):
            os.dup2(descriptor, target)
        os.closerange(3, os.sysconf("SC_OPEN_MAX"))
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

"""Features that depend on the operating system: process groups, memory limits, file locks, flushing folders to disk.

Without POSIX, as on Windows, everything works with less protection, as each method says.
"""

import contextlib
import os
import re
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

#: the environment variable that, unless it is empty, switches POSIX features off on any system
FORCE_PORTABLE = "PYMESHFAIR_PORTABLE"
_ALL = (1 << 63) - 1  # bytes; the largest memory limit that a system accepts


@dataclass(frozen=True)
class System:
    """Features of the system."""

    is_posix: bool  # Linux or macOS

    @property
    def stop_signals(self) -> tuple[str, ...]:
        """The signals that ask a process to end."""
        return ("SIGINT", "SIGTERM", "SIGHUP") if self.is_posix else ("SIGINT", "SIGTERM")

    @property
    def can_fork(self) -> bool:
        """Whether a process with loaded libraries and no threads may be forked; on macOS some frameworks forbid it."""
        return self.is_posix and sys.platform == "linux"

    def own_session(self) -> dict[str, Any]:
        """Returns arguments of `subprocess.Popen` that protect the child from Ctrl-C in the terminal."""
        if self.is_posix:
            return {"start_new_session": True}
        return {"creationflags": getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)}

    def kill(self, process: subprocess.Popen[bytes]) -> None:
        """Kills a child that was started with `own_session`, and its process group; without POSIX only the child."""
        if not self.is_posix:
            process.kill()
            return
        for kill in (os.killpg, os.kill):  # a new fork has not made its group yet
            with contextlib.suppress(ProcessLookupError, PermissionError):
                kill(process.pid, signal.SIGKILL)

    def has_ended(self, process: subprocess.Popen[bytes]) -> bool:
        """Whether a child has ended, even if another process has its pipes open; with POSIX the caller must still wait for it."""
        if not self.is_posix or not hasattr(os, "waitid"):  # macOS before Python 3.13
            return process.poll() is not None
        return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None

    def limit_memory(self, most: int | None) -> None:
        """Limits the memory of this process to `most` bytes (None: its hard limit) and disables core dumps, if the system can."""
        if not self.is_posix:
            return
        import resource

        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        # On Linux RLIMIT_DATA counts the private memory of the process; RLIMIT_AS also counts reserved addresses.
        kind = resource.RLIMIT_DATA if Path("/proc/self/status").exists() else resource.RLIMIT_AS
        with contextlib.suppress(OSError, ValueError):
            hard = resource.getrlimit(kind)[1]
            most = hard if most is None else min(most, _ALL)
            resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))

    def usable_memory(self) -> int | None:
        """The bytes that a worker may use, so that a hostile file only stops its own run; None if unknown."""
        try:
            total = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
        except (AttributeError, ValueError, OSError):
            return None
        with contextlib.suppress(OSError, ValueError):  # the limit of a container
            total = min(total, int(Path("/sys/fs/cgroup/memory.max").read_text()))
        return int(0.8 * total)  # the rest is for the system

    def peak_memory(self) -> int | None:
        """The peak memory of this process in bytes since `forget_peak_memory`; None except on Linux."""
        with contextlib.suppress(OSError):
            # The peak that getrusage reports for a child process includes the memory of its parent at the start.
            status = Path("/proc/self/status").read_text("ascii", "replace") if self.is_posix else ""
            if peak := re.search(r"^VmHWM:\s*(\d+)", status, re.MULTILINE):
                return int(peak[1]) * 1024
        return None

    def forget_peak_memory(self) -> None:
        if self.is_posix:
            with contextlib.suppress(OSError):
                Path("/proc/self/clear_refs").write_text("5", "ascii")

    def try_lock(self, file: IO[bytes], *, alone: bool) -> bool | None:
        """Tries to take an exclusive (`alone`) or shared lock of a file; returns whether it did, None if there are no locks."""
        if not self.is_posix:
            return None
        import fcntl

        try:
            fcntl.flock(file, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:  # a file system without locks
            return None
        return True

    def move_open_file(self, source: Path, target: Path) -> None:
        """Renames a new file that this process holds open; without POSIX makes an empty file `target` instead."""
        if self.is_posix:
            source.replace(target)
        else:
            target.touch()

    def flush(self, path: Path) -> None:
        """Waits until a file, or with POSIX the list of files in a folder, is on the disk."""
        if not self.is_posix and not path.is_file():
            return
        descriptor = os.open(path, os.O_RDONLY if self.is_posix else os.O_RDWR)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)

    def boot(self) -> str:
        """An id of the current boot of the machine; empty except on Linux."""
        with contextlib.suppress(OSError):
            return Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip() if self.is_posix else ""
        return ""

    def processors(self) -> int:
        """The number of processors; on Linux only those that this process may use."""
        if self.is_posix and hasattr(os, "sched_getaffinity"):
            return len(os.sched_getaffinity(0))
        return os.cpu_count() or 1


def this_system() -> System:
    """Returns the features of this machine."""
    return System(os.name == "posix" and not os.environ.get(FORCE_PORTABLE))

"""Features of single operating systems: process groups, limits of memory, locks on files, folders that reach the disk.

`this_system` gives what this machine has. Everything works without POSIX, as on Windows, but with less protection, as each method
says. The environment variable `FORCE_PORTABLE` takes POSIX away anywhere.
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

#: the environment variable that, set to anything, makes every process of a run do without POSIX
FORCE_PORTABLE = "PYMESHFAIR_PORTABLE"
_ALL = (1 << 63) - 1  # bytes; the largest limit that a system takes


@dataclass(frozen=True)
class System:
    """Features of the system that a process runs on."""

    is_posix: bool  # Linux or macOS

    @property
    def stop_signals(self) -> tuple[str, ...]:
        """The signals by which a user or the system asks a process to end."""
        return ("SIGINT", "SIGTERM", "SIGHUP") if self.is_posix else ("SIGINT", "SIGTERM")

    @property
    def can_fork(self) -> bool:
        """Whether a process may be forked that has loaded libraries and started no threads; macOS has frameworks that may not."""
        return self.is_posix and sys.platform == "linux"

    def own_session(self) -> dict[str, Any]:
        """Arguments of `subprocess.Popen` that keep Ctrl-C of the terminal from the child."""
        if self.is_posix:
            return {"start_new_session": True}
        return {"creationflags": getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)}

    def kill(self, process: subprocess.Popen[bytes]) -> None:
        """End a child that was started with `own_session`, and all that it has started; without POSIX the child alone."""
        if not self.is_posix:
            process.kill()
            return
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)

    def has_ended(self, process: subprocess.Popen[bytes]) -> bool:
        """Whether a child has ended, even if another process holds its pipes open; with POSIX it is left to be waited for."""
        if not self.is_posix or not hasattr(os, "waitid"):  # macOS before Python 3.13
            return process.poll() is not None
        return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None

    def limit_memory(self, most: int | None) -> None:
        """Hold this process to so many bytes of memory from now on, and keep it from dumping core, as far as the system can."""
        if not self.is_posix:
            return
        import resource

        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        # On Linux RLIMIT_DATA counts what is really the process's own; RLIMIT_AS also counts what is only reserved.
        kind = resource.RLIMIT_DATA if Path("/proc/self/status").exists() else resource.RLIMIT_AS
        with contextlib.suppress(OSError, ValueError):
            hard = resource.getrlimit(kind)[1]
            most = hard if most is None else min(most, _ALL)
            resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))

    def usable_memory(self) -> int | None:
        """Bytes that a worker may take, so that a hostile file stops its own run alone; None where that is not known."""
        try:
            total = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
        except (AttributeError, ValueError, OSError):
            return None
        with contextlib.suppress(OSError, ValueError):  # of a container
            total = min(total, int(Path("/sys/fs/cgroup/memory.max").read_text()))
        return int(0.8 * total)  # the rest is the system's

    def peak_memory(self) -> int | None:
        """The most bytes of memory that this process has held since it last forgot; known on Linux alone."""
        with contextlib.suppress(OSError):
            # Not getrusage: a child's begins with the memory of the process that started it.
            status = Path("/proc/self/status").read_text("ascii", "replace") if self.is_posix else ""
            if found := re.search(r"^VmHWM:\s*(\d+)", status, re.MULTILINE):
                return int(found[1]) * 1024
        return None

    def forget_peak_memory(self) -> None:
        """Begin anew to note the most memory that this process holds."""
        if self.is_posix:
            with contextlib.suppress(OSError):
                Path("/proc/self/clear_refs").write_text("5", "ascii")

    def try_lock(self, file: IO[bytes], *, alone: bool) -> bool | None:
        """Take the lock of a file without waiting, alone or with others: whether it was taken, None where there are no locks."""
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

    def move_open_file(self, file: IO[bytes], source: Path, target: Path) -> None:
        """Rename a file that this process has just made and holds open; without POSIX a second file gets the name."""
        if self.is_posix:
            source.replace(target)
        else:
            target.touch()

    def flush(self, path: Path) -> None:
        """Wait until the disk has a file, or with POSIX a folder's list of names."""
        if not self.is_posix and not path.is_file():
            return
        descriptor = os.open(path, os.O_RDONLY if self.is_posix else os.O_RDWR)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)

    def boot(self) -> str:
        """A name of the time since the machine was started; empty where the system is not Linux."""
        with contextlib.suppress(OSError):
            return Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip() if self.is_posix else ""
        return ""

    def processors(self) -> int:
        """The number of processors that this process may use; with Linux without those that the system keeps from it."""
        if self.is_posix and hasattr(os, "sched_getaffinity"):
            return len(os.sched_getaffinity(0))
        return os.cpu_count() or 1


def this_system() -> System:
    """The features of the system that this process runs on."""
    return System(os.name == "posix" and not os.environ.get(FORCE_PORTABLE))

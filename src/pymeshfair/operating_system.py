"""Features of single operating systems: process groups, limits of memory, locks on files, folders that reach the disk.

`this_system` gives what this machine has. `Portable` is the fallback, for Windows and whatever else is not POSIX: everything
works with it, but with less protection, as each method says. The environment variable `FORCE_PORTABLE` chooses it anywhere.
"""

import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import IO, Any

#: the environment variable that, set to anything, makes every process of a run use the fallback
FORCE_PORTABLE = "PYMESHFAIR_PORTABLE"


#: bytes; the largest limit that a system takes
_ALL = (1 << 63) - 1


class Portable:
    """Features of every system that Python runs on."""

    #: the signals by which a user or the system asks a process to end, as far as there are any
    stop_signals: tuple[str, ...] = ("SIGINT", "SIGTERM")

    #: whether a process may be forked that has loaded libraries and started no threads
    can_fork = False

    def own_session(self) -> dict[str, Any]:
        """Arguments of `subprocess.Popen` that keep Ctrl-C of the terminal from the child."""
        return {"creationflags": getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)}

    def kill(self, process: subprocess.Popen[bytes]) -> None:
        """End a child. The processes that it started go on."""
        process.kill()

    def has_ended(self, process: subprocess.Popen[bytes]) -> bool:
        """Whether a child has ended, even if another process holds its pipes open."""
        return process.poll() is not None

    def limit_memory(self, most: int | None) -> None:
        """Hold this process to so many bytes of memory from now on, and keep it from dumping core. Does neither."""

    def peak_memory(self) -> int | None:
        """The most bytes of memory that this process has held since it last forgot. Not known."""
        return None

    def forget_peak_memory(self) -> None:
        """Begin anew to note the most memory that this process holds. Does nothing."""

    def try_lock(self, file: IO[bytes], *, alone: bool) -> bool | None:
        """Take the lock of a file without waiting, alone or with others: whether it was taken, None where there are no locks."""
        return None

    def move_open_file(self, file: IO[bytes], source: Path, target: Path) -> None:
        """Rename a file that this process has just made and holds open; here a second file gets the name."""
        target.touch()

    def flush(self, path: Path) -> None:
        """Wait until the disk has a file. Does nothing for a folder's list of names."""
        if path.is_file():
            with path.open("r+b") as file:
                os.fsync(file.fileno())

    def boot(self) -> str:
        """A name of the time since the machine was started; here always the same."""
        return ""

    def processors(self) -> int:
        """The number of processors that this process may use; here all of the machine."""
        return os.cpu_count() or 1


class Posix(Portable):
    """Features of Linux and macOS."""

    stop_signals = ("SIGINT", "SIGTERM", "SIGHUP")
    can_fork = sys.platform == "linux"  # the frameworks of macOS do not survive it

    def own_session(self) -> dict[str, Any]:
        """As there; one signal ends the child with all that it started."""
        return {"start_new_session": True}

    def kill(self, process: subprocess.Popen[bytes]) -> None:
        """End a child that was started with `own_session`, and whatever it has started."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)

    def has_ended(self, process: subprocess.Popen[bytes]) -> bool:
        """As there; leaves the child to be waited for, so that what it started can be ended with it."""
        if not hasattr(os, "waitid"):  # macOS before Python 3.13
            return super().has_ended(process)
        return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None

    def limit_memory(self, most: int | None) -> None:
        """As there, as far as the system lets it."""
        import resource

        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        # On Linux RLIMIT_DATA counts what is really the process's own; RLIMIT_AS also counts what is only reserved.
        kind = resource.RLIMIT_DATA if Path("/proc/self/status").exists() else resource.RLIMIT_AS
        with contextlib.suppress(OSError, ValueError):
            hard = resource.getrlimit(kind)[1]
            most = hard if most is None else min(most, _ALL)
            resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))

    def peak_memory(self) -> int | None:
        """As there; known on Linux."""
        with contextlib.suppress(OSError, ValueError, IndexError):
            # Not getrusage: a child's begins with the memory of the process that started it.
            for line in Path("/proc/self/status").read_text("ascii", "replace").splitlines():
                if line.startswith("VmHWM:"):
                    return int(line.split()[1]) * 1024
        return None

    def forget_peak_memory(self) -> None:
        """As there; on Linux."""
        with contextlib.suppress(OSError):
            Path("/proc/self/clear_refs").write_text("5", "ascii")

    def try_lock(self, file: IO[bytes], *, alone: bool) -> bool | None:
        """As there."""
        import fcntl

        try:
            fcntl.flock(file, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:  # a file system without locks
            return None
        return True

    def move_open_file(self, file: IO[bytes], source: Path, target: Path) -> None:
        """Rename a file that this process has just made and holds open."""
        source.replace(target)

    def flush(self, path: Path) -> None:
        """Wait until the disk has a file or a folder's list of names."""
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)

    def boot(self) -> str:
        """As there; different after each start of Linux."""
        with contextlib.suppress(OSError):
            return Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip()
        return super().boot()

    def processors(self) -> int:
        """As there, but for those that the system keeps from this process."""
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else super().processors()


def this_system() -> Portable:
    """The features of the system that this process runs on."""
    return Portable() if os.name != "posix" or os.environ.get(FORCE_PORTABLE) else Posix()

"""What a worker may take of the machine: memory, threads, and nothing of the disk for core dumps."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from pathlib import Path


def worker_environment(threads: int | None, environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """The environment of a worker: `threads` for filters, one for linear algebra so that results do not depend on their number.

    Args:
        threads: how many threads a filter may use; None means what OMP_NUM_THREADS says, or all processors.
        environment: of the supervisor.
    """
    said = str(threads) if threads is not None else environment.get("OMP_NUM_THREADS", str(_processors()))
    changes = {"OMP_NUM_THREADS": said, "NUMBA_NUM_THREADS": said}
    changes |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    # Threads that wait should sleep: spinning ones make MeshLab's Poisson reconstruction 16 times slower on a busy machine.
    changes["OMP_WAIT_POLICY"] = environment.get("OMP_WAIT_POLICY", "PASSIVE")
    # Whatever lies in the working folder must not be imported in place of a library.
    changes["PYTHONSAFEPATH"] = "1"
    return {**environment, **changes}


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def limit_process(memory: int | None) -> None:
    """Hold this process to so many bytes of memory, where the system can, and keep it from dumping core."""
    try:
        import resource
    except ImportError:  # Windows
        return
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if memory is not None:
        # On Linux RLIMIT_DATA counts what is really the process's own; RLIMIT_AS also counts what is only reserved.
        kind = resource.RLIMIT_DATA if Path("/proc/self/status").exists() else resource.RLIMIT_AS
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(kind, (memory, memory))


def peak_memory() -> int | None:
    """The most memory that this process has held so far in bytes, or None where the system does not say."""
    with contextlib.suppress(OSError, ValueError, IndexError):
        # Not getrusage: a child's begins with the memory of the process that started it.
        for line in Path("/proc/self/status").read_text("ascii", "replace").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    return None

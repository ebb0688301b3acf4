"""The machine: what it is, how busy it is with other work, how fast its memory is, and what memory a process takes."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import platform
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pymeshfair.filters.compilation import allowed_threads, compiled, prange

#: Other work on so many processors is too much for a measurement by the clock.
QUIET = 0.5
_TRIAD_LENGTH = 16_000_000
_TICKS = os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 100


def description() -> str:
    """Processor, cores, memory and system, in a line."""
    model = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        named = [line.partition(":")[2].strip() for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        model = named[0] if named else model
    memory = ""
    if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        memory = f", {os.sysconf('SC_PHYS_PAGES') * os.sysconf('SC_PAGE_SIZE') / 2**30:.0f} GiB"
    return f"{model}, {os.cpu_count()} cores{memory}, {platform.system()}, Python {platform.python_version()}"


def busy_seconds() -> float | None:
    """Seconds of processor time that the whole machine has used since it started; None where the system does not tell."""
    path = Path("/proc/stat")
    if not path.exists():
        return None
    user, nice, system, _, _, interrupts, soft = (int(word) for word in path.read_text().split("\n", 1)[0].split()[1:8])
    return (user + nice + system + interrupts + soft) / _TICKS


def load_of_others(seconds: float = 0.3) -> float:
    """How many processors others keep busy while this process sleeps.

    The system's load average would not do: it goes on counting the block that has just been measured.
    """
    before = busy_seconds()
    if before is None:
        return os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    start = time.perf_counter()
    time.sleep(seconds)
    after = busy_seconds()
    assert after is not None
    return (after - before) / (time.perf_counter() - start)


@compiled(parallel=True)
def _triad(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64], s: float) -> None:
    for i in prange(a.shape[0]):
        a[i] = b[i] + s * c[i]


def triad_bandwidth() -> float:
    """Bytes a second of a = b + s c on long arrays, on all threads of numba: the best of ten."""
    a, b, c = np.zeros(_TRIAD_LENGTH), np.ones(_TRIAD_LENGTH), np.ones(_TRIAD_LENGTH)
    _triad(a[:10], b[:10], c[:10], 2.0)
    taken = []
    for _ in range(10):
        start = time.perf_counter()
        _triad(a, b, c, 2.0)
        taken.append(time.perf_counter() - start)
    return 24.0 * _TRIAD_LENGTH / min(taken)


def threads() -> int:
    """How many threads our kernels may use."""
    return allowed_threads()


def start_of_peak() -> float:
    """Gives freed memory back and forgets the peak so far; the megabytes that this process has now."""
    gc.collect()
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL("libc.so.6").malloc_trim(0)
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")
    return _status("VmRSS")


def peak() -> float:
    """The most megabytes since `start_of_peak`; NaN where the system does not tell."""
    return _status("VmHWM")


def _status(key: str) -> float:
    path = Path("/proc/self/status")
    if not path.exists():
        return float("nan")
    return next(float(line.split()[1]) for line in path.read_text().splitlines() if line.startswith(key)) / 1024

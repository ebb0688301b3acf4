"""The memory limit of a worker: a share of the machine's memory, or the amount that a user gives."""

import contextlib
import os
import re
from pathlib import Path

from ..errors import ParameterError

#: of all memory; the rest is the system's, so that a hostile file stops its own run and nothing else
SHARE = 0.8
_UNITS = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12, "KI": 2**10, "MI": 2**20, "GI": 2**30, "TI": 2**40}


def default_memory() -> int | None:
    """Bytes that a worker may take by default, or None where the system does not say how much there is."""
    try:
        total = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None
    with contextlib.suppress(OSError, ValueError):  # of a container
        total = min(total, int(Path("/sys/fs/cgroup/memory.max").read_text()))
    return int(SHARE * total)


def parse_memory(text: str) -> int:
    """Bytes from a text such as ``4GB``, ``500MB`` or ``2GiB``."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*([KMGT]?I?)B?", text.strip().upper())
    if match is None or match[2] not in _UNITS:
        raise ParameterError(f"{text!r} is no amount of memory; write 4GB, 500MB or 2GiB")
    size = int(float(match[1]) * _UNITS[match[2]])
    if size < 10**8:
        raise ParameterError(f"{text!r} is less than the 100 MB that MeshLab takes for itself")
    return size

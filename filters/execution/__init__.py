"""How work is done: threads, tasks, progress, and library calls that can be abandoned."""

from .abandonable import abandonable
from .progress import Progress, ignore_progress, part_of, rising
from .tasks import in_parallel
from .threads import PARTS, SERIAL_BELOW, threads_for

__all__ = [
    "PARTS",
    "SERIAL_BELOW",
    "Progress",
    "abandonable",
    "ignore_progress",
    "in_parallel",
    "part_of",
    "rising",
    "threads_for",
]

"""How work is done: threads, tasks, progress, and library calls that can be abandoned."""

from .abandonable import abandonable
from .progress import Progress, ignore_progress, part_of, rising
from .tasks import in_parallel, over_range
from .threads import threads_for

__all__ = [
    "Progress",
    "abandonable",
    "ignore_progress",
    "in_parallel",
    "over_range",
    "part_of",
    "rising",
    "threads_for",
]

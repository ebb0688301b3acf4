"""Compressed rows: lists of neighbours whose lengths come out of a first run, and which a second one writes."""

from collections.abc import Callable

import numpy as np

from ..compilation import allowed_threads
from ..execution import threads_for
from ..mesh import Ints, Longs


def compressed_rows(count: int, visit: Callable[[int, Longs, Ints], None]) -> tuple[Longs, Ints]:
    """The lists of `count` elements, those of element i between its two offsets.

    Args:
        count: the number of elements.
        visit: called twice with a number of parts that may run at once, the offsets and the neighbours. First the neighbours are
            empty, and it adds the number of neighbours of element i to ``offsets[i + 1]``; then it writes them from
            ``offsets[i]`` on.

    Returns:
        (count + 1,) int64 offsets and int32 neighbours.
    """
    offsets = np.zeros(count + 1, dtype=np.int64)
    with threads_for(count):
        # Each thread has its own marks, so there are as many parts as threads; the result does not depend on their number.
        parts = allowed_threads()
        visit(parts, offsets, np.empty(0, dtype=np.int32))
        np.cumsum(offsets, out=offsets)
        neighbours = np.empty(offsets[-1], dtype=np.int32)
        visit(parts, offsets, neighbours)
    return offsets, neighbours

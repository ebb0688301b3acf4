"""The number of threads of a compiled kernel.

Every parallel kernel writes each result from one iteration alone, so the results have the same bits for any number of threads.
Very small meshes are faster on one.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from ..compilation import single_thread

#: Kernels on fewer vertices run on one thread: waking others costs more than it saves. Above, two threads take 0.6 of the time of
#: one on a quiet machine, and on one that two other programs keep busy 1.3 times as long.
SERIAL_BELOW = 20_000


@contextmanager
def threads_for(size: int) -> Iterator[None]:
    """A context in which kernels called from this thread run on one thread if `size`, a number of vertices, is small."""
    if size >= SERIAL_BELOW:
        yield
        return
    with single_thread():
        yield

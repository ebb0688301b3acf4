"""The number of threads of a compiled kernel.

Every parallel kernel writes each result from one iteration alone, so the results have the same bits for any number of threads.
Small meshes are faster on one.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from ..compilation import single_thread

#: Kernels on fewer vertices run on one thread: waking others costs more than it saves, above all on a busy machine.
SERIAL_BELOW = 200_000


@contextmanager
def threads_for(size: int) -> Iterator[None]:
    """A context in which kernels called from this thread run on one thread if `size`, a number of vertices, is small."""
    if size >= SERIAL_BELOW:
        yield
        return
    with single_thread():
        yield

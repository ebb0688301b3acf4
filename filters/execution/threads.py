"""The number of threads of a compiled kernel.

Every parallel kernel writes each result from one iteration alone, so the results have the same bits for any number of threads.
Small meshes are faster on one.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numba

#: Kernels on fewer vertices run on one thread: waking others costs more than it saves, above all on a busy machine.
SERIAL_BELOW = 200_000

# Numba tries Intel TBB first and warns when it finds an old one, such as that in the pymeshlab wheel. OpenMP is as fast.
if "NUMBA_THREADING_LAYER" not in os.environ and "NUMBA_THREADING_LAYER_PRIORITY" not in os.environ:
    _config: Any = numba.config
    _config.THREADING_LAYER_PRIORITY = ["omp", "tbb", "workqueue"]


@contextmanager
def threads_for(size: int) -> Iterator[None]:
    """A context in which kernels called from this thread run on one thread if `size`, a number of vertices, is small."""
    if size >= SERIAL_BELOW:
        yield
        return
    allowed = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        yield
    finally:
        numba.set_num_threads(allowed)

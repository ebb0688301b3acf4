"""Whether the vertices of a mesh lie near their neighbours in memory, and whether it pays to see to it."""

import math

import numpy as np

from ..compilation import allowed_threads
from ..execution import SERIAL_BELOW
from .arrays import Ints

# A vertex and its neighbours up to this distance on both sides take a third of a second-level cache of 1 MB.
_NEAR = 8192
_SAMPLE = 20_000
# Reordering runs on one thread; measured, it takes the time that about ten sweeps lose to a bad order.
_SWEEPS_A_REORDERING_COSTS = 10


def worth_reordering(faces: Ints, n_vertices: int, sweeps: float = math.inf) -> bool:
    """Whether that many sweeps over the one-rings are faster after a reordering.

    Subdivision, decimation and merging leave vertices in an order that has little to do with place. It makes no difference to
    the result of a sweep.

    Args:
        faces: (m, 3) triangles.
        n_vertices: n.
        sweeps: how many times a kernel will visit every one-ring; by default, more often than matters.
    """
    if n_vertices < SERIAL_BELOW or len(faces) == 0 or sweeps < _SWEEPS_A_REORDERING_COSTS * allowed_threads():
        return False
    sample = faces[:: max(1, len(faces) // _SAMPLE)].astype(np.int64)
    return bool((np.abs(sample[:, 0] - sample[:, 1]) > _NEAR).mean() > 0.25)

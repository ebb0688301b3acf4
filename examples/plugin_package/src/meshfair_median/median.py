"""The median of a scalar over closed one-rings, again and again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pymeshfair.filters.compilation import compiled
from pymeshfair.filters.topology import one_rings

Floats = NDArray[np.float64]


def median_filtering(faces: NDArray[np.int32], values: Floats, *, iterations: int = 1) -> Floats:
    """s_v <- median of s_v and s_w for all neighbours w of v, for all vertices at once.

    Args:
        faces: (m, 3) triangles.
        values: (n,) scalars.
        iterations: how often; more remove larger specks. Edges of regions stay where they are.

    Returns:
        (n,) the filtered scalars; those of vertices without faces are unchanged.
    """
    rings = one_rings(faces, len(values))
    for _ in range(iterations):
        values = _medians(rings.offsets, rings.neighbours, values)
    return values


@compiled(nogil=True)
def _medians(offsets: NDArray[np.int64], neighbours: NDArray[np.int32], values: Floats) -> Floats:
    """The median of each closed one-ring; of an even number the mean of the two in the middle."""
    medians = np.empty_like(values)
    for v in range(len(values)):
        ring = np.empty(offsets[v + 1] - offsets[v] + 1)
        ring[0] = values[v]
        for k in range(offsets[v], offsets[v + 1]):
            ring[k - offsets[v] + 1] = values[neighbours[k]]
        medians[v] = np.median(ring)
    return medians

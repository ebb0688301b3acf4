"""Stray points: those far from everything, and clumps and hazes apart from the surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_finite, check_whole_number
from ..execution import Progress, ignore_progress, part_of
from ..libraries import sparse
from ..mesh import Bools, Floats
from ..neighbours import check_cloud, nearest_neighbours

#: Two points hang together if their distance is at most this many times the spacing of either.
_REACH = 2.0


def stray_points(
    points: ArrayLike,
    *,
    neighbors: int = 12,
    sparseness: float = 8.0,
    smallest_part: int = 100,
    progress: Progress = ignore_progress,
) -> Bools:
    """Which points of a cloud are not part of any surface that is dense and large enough.

    The spacing s of a point is the root mean square distance to its k nearest neighbours. A point is stray if s is more than
    `sparseness` times the median of the cloud: alone, or in a haze. Of the others, two hang together if each is among the
    neighbours of the other and their distance is at most 2 min(s_p, s_q); so a point in front of a surface does not hang
    together with it, in dense parts and in sparse ones. Connected parts of fewer than `smallest_part` points are stray too.

    The result depends neither on the unit nor on the place, nor on the order of the points.

    Args:
        points: (n, 3) finite coordinates.
        neighbors: k, from 1 to n - 1. More bridge wider gaps and take longer.
        sparseness: at least 1, in median spacings. Larger keeps sparser parts of a cloud, and denser hazes.
        smallest_part: in points. Larger removes larger clumps, and larger islands of the surface too.
        progress: called with the share of the work done.

    Returns:
        (n,) bool.

    Raises:
        FilterInputError: a parameter is out of its bounds, or coordinates are missing, NaN or infinite.
    """
    check_finite("sparseness", sparseness, least=1.0)
    cloud, k = check_cloud(points, neighbors, "neighbors")
    least = check_whole_number("smallest_part", smallest_part, least=1)
    distances, indices = nearest_neighbours(cloud, k, progress=part_of(progress, 0.0, 0.9))
    largest = distances.max(initial=0.0) or 1.0  # so that no square underflows
    spacing: Floats = largest * np.sqrt(np.mean((distances / largest) ** 2, axis=1))
    stray: Bools = spacing > sparseness * np.median(spacing)
    n = len(cloud)
    start, end = np.repeat(np.arange(n), k), indices.ravel()
    close = distances.ravel() <= _REACH * np.minimum(spacing[start], spacing[end])
    close &= ~(stray[start] | stray[end])
    reached = sparse.csr_matrix((np.ones(np.count_nonzero(close), dtype=np.int8), (start[close], end[close])), shape=(n, n))
    part = sparse.csgraph.connected_components(reached.multiply(reached.T), directed=False)[1]
    progress(1.0)
    stray |= np.bincount(part)[part] < least
    return stray

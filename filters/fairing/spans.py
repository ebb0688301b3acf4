"""The shortest spans between two loops: the edges of a band that triangulates what is between them [fuchs1977]."""

from __future__ import annotations

import numpy as np

from ..compilation import compiled
from ..execution import Progress
from ..libraries import spatial
from ..mesh import Bools, Floats, Ints

#: The most spans between two rims among which a band is searched; each takes a byte, so these are 400 MB, and 3 s.
MOST_SPANS = 400_000_000
# The number of spans between two calls of `progress`.
_SPANS_AT_A_TIME = 10_000_000


def shortest_spans(first: Floats, second: Floats, progress: Progress) -> tuple[Ints, Ints]:
    """The spans between two loops whose squared lengths have the least sum, the shortest of all spans among them.

    Args:
        first: (a, 3) one loop.
        second: (b, 3) the other, in the same direction.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (a + b,) and (a + b,) the indices of the two ends of each span, in order along the band: from one span to the next, one of
        the two increases by one, cyclically.
    """
    low = np.minimum(first.min(axis=0), second.min(axis=0))
    extent = max(float((first - low).max()), float((second - low).max())) or 1.0
    first, second = (first - low) / extent, (second - low) / extent  # so that squares stay in range
    nearest, index = spatial.cKDTree(second).query(first)
    i, j = int(nearest.argmin()), int(index[nearest.argmin()])
    path = _shortest(np.roll(first, -i, axis=0), np.roll(second, -j, axis=0), progress)
    return (path[:, 0] + i) % len(first), (path[:, 1] + j) % len(second)


def _shortest(first: Floats, second: Floats, progress: Progress) -> Ints:
    """(a + b, 2) the path of least cost through the grid of spans, from (0, 0) to before (a, b), which is (0, 0) again."""
    closed, other = (np.concatenate([loop, loop[:1]]) for loop in (first, second))
    from_first = np.empty((len(closed), len(other)), dtype=np.bool_)
    costs = np.empty(len(other))
    rows = max(1, _SPANS_AT_A_TIME // len(other))
    for start in range(0, len(closed), rows):
        progress(start / len(closed))
        _cheapest(closed, other, start, min(start + rows, len(closed)), costs, from_first)
    return _way_back(from_first)


@compiled
def _cheapest(first: Floats, second: Floats, start: int, end: int, costs: Floats, from_first: Bools) -> None:
    """Rows start to end of the grid; `costs` holds those of the row before, and afterwards those of row end - 1."""
    for i in range(start, end):
        for j in range(second.shape[0]):
            length = 0.0
            for k in range(3):
                length += (first[i, k] - second[j, k]) ** 2
            if i > 0 and (j == 0 or costs[j] <= costs[j - 1]):
                from_first[i, j] = True
                costs[j] += length
            else:
                from_first[i, j] = False
                costs[j] = length + costs[j - 1] if j > 0 else length
            # A path along all of one loop first would return to its first span, and that edge would have four triangles.
            if (i == 0 and j == second.shape[0] - 1) or (i == first.shape[0] - 1 and j == 0):
                costs[j] = np.inf


@compiled
def _way_back(from_first: Bools) -> Ints:
    """The path that led to the end of the grid."""
    i, j = from_first.shape[0] - 1, from_first.shape[1] - 1
    path = np.empty((i + j, 2), dtype=np.int32)
    for k in range(i + j - 1, -1, -1):
        if from_first[i, j]:
            i -= 1
        else:
            j -= 1
        path[k, 0], path[k, 1] = i, j
    return path

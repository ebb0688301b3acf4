"""Pairs of vertices of a rim that a patch must not join, as sorted keys."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..compilation import compiled
from ..mesh import Bools, Ints, Longs


class VertexPairs(NamedTuple):
    """Unordered pairs of the numbers 0 to size - 1."""

    size: int  # how many numbers there are
    keys: Longs  # (p,) ascending, i size + j of every pair (i, j), in both directions

    def restricted(self, chosen: Ints) -> "VertexPairs":
        """The pairs within `chosen`, distinct numbers, as places in `chosen`."""
        place = np.full(self.size, -1, dtype=np.int64)
        place[chosen] = np.arange(len(chosen))
        first, second = place[self.keys // self.size], place[self.keys % self.size]
        both = (first >= 0) & (second >= 0)
        return vertex_pairs(len(chosen), first[both], second[both])

    def among(self, chosen: Ints) -> Bools:
        """(k, k) which two of `chosen`, distinct numbers, are a pair."""
        inner = self.restricted(chosen)
        dense = np.zeros((len(chosen), len(chosen)), dtype=np.bool_)
        dense.ravel()[inner.keys] = True
        return dense

    def with_pairs(self, first: ArrayLike, second: ArrayLike) -> "VertexPairs":
        """These pairs and those of each number in `first` with the one in `second`."""
        return VertexPairs(self.size, np.union1d(self.keys, vertex_pairs(self.size, first, second).keys))

    def has(self, i: int, j: int) -> bool:
        """Whether (i, j) is one of the pairs."""
        return bool(is_pair(self, i, j))


def vertex_pairs(count: int, first: ArrayLike = (), second: ArrayLike = ()) -> VertexPairs:
    """The pairs of each number in `first`, from 0 to count - 1, with the one in `second`."""
    a, b = np.asarray(first, dtype=np.int64), np.asarray(second, dtype=np.int64)
    return VertexPairs(count, np.unique(np.concatenate([a * count + b, b * count + a])))


@compiled
def is_pair(pairs: VertexPairs, i: int, j: int) -> bool:
    """Whether (i, j) is one of the pairs."""
    key = i * pairs.size + j
    at = np.searchsorted(pairs.keys, key)
    return bool(at < pairs.keys.shape[0] and pairs.keys[at] == key)


class ForbiddenEdges(NamedTuple):
    """The edges between vertices 0 to k - 1 of its rim that a patch must not have."""

    pairs: VertexPairs  # pairs that are joined outside the patch
    apart: Bools  # (k,) the vertices of which no two may be joined
    alone: Bools  # (k,) the vertices that no flip may join with any other

    def has(self, i: int, j: int) -> bool:
        """Whether the vertices i and j of the rim must not be joined."""
        return bool(self.apart[i] and self.apart[j]) or self.pairs.has(i, j)

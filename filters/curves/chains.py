"""The chains of unbranched curves: vertices in the order in which equations on them are eliminated."""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..mesh import Bools, Ints, Longs


class Chains(NamedTuple):
    """The free vertices in the order in which they are eliminated, chain after chain.

    Attributes:
        order: (f,) int32; those of chain c are ``order[starts[c]:starts[c + 1]]``, each the neighbour of the next.
        starts: (c + 1,) int64.
        closed: (c,) bool, whether the last vertex of a chain is the neighbour of its first.
        floating: (c,) bool, whether no vertex of a chain has a fixed neighbour.
    """

    order: Ints
    starts: Longs
    closed: Bools
    floating: Bools


def trace_chains(offsets: Longs, neighbours: Ints, free: Bools) -> Chains:
    """The chains that the free vertices form.

    Args:
        offsets: the one-rings of the curves, as in `OneRings`.
        neighbours: with these.
        free: (n,) bool; none of them has more than two free neighbours. A vertex without neighbours is a chain of its own.
    """
    n = len(free)
    order, starts = np.empty(n, dtype=np.int32), np.empty(n + 1, dtype=np.int64)
    closed, floating = np.empty(n, dtype=np.bool_), np.empty(n, dtype=np.bool_)
    placed, chains = _trace(offsets, neighbours, free, order, starts, closed, floating)
    return Chains(order[:placed], starts[: chains + 1], closed[:chains], floating[:chains])


@compiled
def _trace(
    offsets: Longs, neighbours: Ints, free: Bools, order: Ints, starts: Longs, closed: Bools, floating: Bools
) -> tuple[int, int]:
    n = free.shape[0]
    done = ~free
    placed = chains = 0
    starts[0] = 0
    # First from the ends, then what is left, which is rings.
    for only_ends in (True, False):
        for i in range(n):
            if done[i]:
                continue
            inner = 0
            for k in range(offsets[i], offsets[i + 1]):
                inner += free[neighbours[k]]
            if only_ends and inner > 1:
                continue
            closed[chains], floating[chains] = not only_ends, True
            at = i
            while at >= 0:
                done[at] = True
                order[placed] = at
                placed += 1
                following = -1
                for k in range(offsets[at], offsets[at + 1]):
                    j = neighbours[k]
                    if not free[j]:
                        floating[chains] = False
                    elif not done[j] and following < 0:
                        following = j
                at = following
            chains += 1
            starts[chains] = placed
    return placed, chains

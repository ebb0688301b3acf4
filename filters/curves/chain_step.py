"""Implicit steps on unbranched curves: systems of equations solved by elimination without a subtraction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..mesh import Bools, Floats, Ints, Longs
from ..operators import Laplacian
from ..topology import OneRings

# Times the squared lengths of a mesh of ordinary size this does not overflow, and longer steps give the same result to rounding.
_LONGEST_STEP = 1e100


class ChainStep:
    """The backward Euler step (M - t C) d = t C p on unbranched curves, for the displacement d of the free vertices; others stay.

    M - t C is a network of conductances: t w_ij between neighbours, M_i from each vertex to the ground. Eliminating a vertex of a
    chain leaves such a network again. Its conductances are sums, products and quotients of positive numbers, so each is exact to
    rounding, however large t is and however long the chain. In a chain without fixed neighbour the currents sum up to 0: the
    current at its last vertex is minus the sum of those before.
    """

    def __init__(self, laplacian: Laplacian, chains: Chains, time_step: float) -> None:
        """Eliminates, for any number of right-hand sides; in time and memory proportional to the vertices.

        Args:
            laplacian: L = M^-1 C on n vertices, with positive weights.
            chains: the free vertices.
            time_step: t, at least 0, in the unit of 1 / L.
        """
        t = min(time_step, _LONGEST_STEP)
        stiffness = laplacian.stiffness
        # Divided by 1 + t all conductances stay finite. A stiffness is negative on its diagonal alone.
        self._network = _Network(
            stiffness.indptr.astype(np.int64), stiffness.indices.astype(np.int32), stiffness.data * (t / (1.0 + t))
        )
        size = len(chains.order)
        self._chains, self._shares = chains, _Shares(np.empty(size), np.zeros(size), np.empty(size), np.empty(size))
        _eliminate(self._network, laplacian.mass / (1.0 + t), chains, self._shares)

    def displacement(self, points: Floats) -> Floats:
        """(n, 3) how far the step moves the vertices; 0 for those that are not free."""
        moved = np.zeros_like(points)
        _substitute(points, self._network, self._chains, self._shares, moved)
        return moved


@compiled
def _eliminate(network: _Network, mass: Floats, chains: Chains, shares: _Shares) -> None:
    """Fills `shares`. The first vertex of a ring is eliminated last; of a chain with ends, the last."""
    order, starts, closed, _ = chains
    to_next, to_first, to_ground, resistance = shares
    for c in range(closed.shape[0]):
        start, stop = starts[c], starts[c + 1]
        first, ring = order[start], closed[c]
        ground_of_first = _ground(network, mass, order, start, stop, start, ring) if ring else 0.0
        carried, back = 0.0, 0.0
        if ring:
            back = _weight(network, order[start + 1], first)
        for k in range(start + 1 if ring else start, stop):
            ground = carried + _ground(network, mass, order, start, stop, k, ring)
            last = k == stop - 1
            onward = 0.0 if last else _weight(network, order[k], order[k + 1])
            if ring and last:
                back += _weight(network, order[k], first)
            total = ground + onward + back
            resistance[k] = 1.0 / total if total > 0.0 else 0.0
            to_next[k], to_first[k], to_ground[k] = onward * resistance[k], back * resistance[k], ground * resistance[k]
            carried = ground * to_next[k]
            ground_of_first += ground * to_first[k]
            back = onward * to_first[k] if ring else 0.0
        if ring:
            resistance[start] = 1.0 / ground_of_first if ground_of_first > 0.0 else 0.0
            to_next[start] = to_first[start] = 0.0
            to_ground[start] = 1.0


@compiled
def _ground(network: _Network, mass: Floats, order: Ints, start: int, stop: int, k: int, ring: bool) -> float:
    """The conductance from a vertex to the ground and to fixed vertices, which are alike to it."""
    offsets, columns, weights = network
    i = order[k]
    before = order[k - 1] if k > start else (order[stop - 1] if ring else -1)
    after = order[k + 1] if k + 1 < stop else (order[start] if ring else -1)
    total: float = mass[i]
    for e in range(offsets[i], offsets[i + 1]):
        j = columns[e]
        if j != i and j != before and j != after:
            total += weights[e]
    return total


@compiled
def _weight(network: _Network, i: int, j: int) -> float:
    offsets, columns, weights = network
    for e in range(offsets[i], offsets[i + 1]):
        if columns[e] == j:
            weight: float = weights[e]
            return weight
    return 0.0


@compiled
def _substitute(points: Floats, network: _Network, chains: Chains, shares: _Shares, moved: Floats) -> None:
    """The currents forwards, then the potentials backwards; `moved` holds first the ones and then the others."""
    offsets, columns, weights = network
    order, starts, closed, floating = chains
    to_next, to_first, to_ground, resistance = shares
    lost = np.zeros(3)
    for c in range(closed.shape[0]):
        start, stop = starts[c], starts[c + 1]
        for k in range(start, stop):
            i = order[k]
            for e in range(offsets[i], offsets[i + 1]):
                for d in range(3):
                    moved[i, d] += weights[e] * (points[columns[e], d] - points[i, d])
        # The first vertex of a ring and the last one of a chain with ends are the roots, which come last.
        root = start if closed[c] else stop - 1
        begin, end = (start + 1, stop) if closed[c] else (start, stop - 1)
        first, last = order[start], order[root]
        lost[:] = 0.0
        for k in range(begin, end):
            i = order[k]
            for d in range(3):
                current = moved[i, d]
                lost[d] += to_ground[k] * current
                if k + 1 < stop:
                    moved[order[k + 1], d] += to_next[k] * current
                moved[first, d] += to_first[k] * current
        for d in range(3):
            moved[last, d] = (-lost[d] if floating[c] else moved[last, d]) * resistance[root]
        for m in range(end - begin):
            k = end - 1 - m
            i = order[k]
            for d in range(3):
                potential = moved[i, d] * resistance[k] + to_first[k] * moved[first, d]
                if k + 1 < stop:
                    potential += to_next[k] * moved[order[k + 1], d]
                moved[i, d] = potential


class _Network(NamedTuple):
    """The conductances between neighbours: those of vertex i in columns[offsets[i]:offsets[i + 1]], the diagonal with them."""

    offsets: Longs
    columns: Ints
    weights: Floats


class _Shares(NamedTuple):
    """The shares of the current of each vertex in `Chains.order`, when the vertex is eliminated.

    Attributes:
        to_next: the share that goes to the next vertex.
        to_first: to the first vertex of a ring.
        to_ground: to the ground.
        resistance: one over the sum of the three conductances.
    """

    to_next: Floats
    to_first: Floats
    to_ground: Floats
    resistance: Floats


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


def trace_chains(rings: OneRings, free: Bools) -> Chains:
    """The chains that the free vertices form.

    Args:
        rings: the neighbours along the curves.
        free: (n,) bool; none of them has more than two free neighbours. A vertex without neighbours is a chain of its own.
    """
    n = len(free)
    longest = Chains(np.empty(n, np.int32), np.empty(n + 1, np.int64), np.empty(n, dtype=np.bool_), np.empty(n, dtype=np.bool_))
    placed, chains = _trace(rings, free, longest)
    return Chains(longest.order[:placed], longest.starts[: chains + 1], longest.closed[:chains], longest.floating[:chains])


@compiled
def _trace(rings: OneRings, free: Bools, traced: Chains) -> tuple[int, int]:
    """Fills `traced`; how many vertices and how many chains it holds."""
    offsets, neighbours, _ = rings
    order, starts, closed, floating = traced
    n = free.shape[0]
    done = ~free
    placed = chains = 0
    starts[0] = 0
    # First from the ends; all other chains are rings.
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

"""Steps of diffusion along curves: explicit ones, and implicit ones by elimination or, where curves branch, by a solver."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..diffusion.backward_euler import BackwardEulerStep
from ..diffusion.stencil import curve_stencil
from ..execution import Progress, part_of
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints
from ..operators import Laplacian, OperatorName, curve_laplacian
from ..topology import OneRings
from .chain_step import ChainStep
from .chains import trace_chains


def explicit_curve_steps(
    start: Floats, rings: OneRings, weights: OperatorName, steps: Sequence[float], count: int, moves: Bools, progress: Progress
) -> Floats:
    """(n, 3) where the vertices are after `count` times all of the `steps`."""
    which = np.flatnonzero(moves).astype(np.int32)
    advance = curve_stencil(start, weights, which, rings.offsets, rings.neighbours)
    now, following = start.copy(), start.copy()
    for done in range(count):
        for step in steps:
            advance(now, following, step)
            now, following = following, now
        progress((done + 1) / count)
    return now


def implicit_curve_steps(
    start: Floats,
    pairs: Ints,
    rings: OneRings,
    operator: OperatorName,
    time: float,
    count: int,
    moves: Bools,
    progress: Progress,
) -> Floats:
    """(n, 3) where the vertices are after `count` steps of that time, in the unit of one over the operator."""
    laplacian = curve_laplacian(start, pairs, operator)
    labels: Ints = sparse.csgraph.connected_components(laplacian.stiffness, directed=False)[1]
    branched = _in_branched_component(rings, moves, labels)
    chains = ChainStep(laplacian, trace_chains(rings.offsets, rings.neighbours, moves & ~branched), time)
    network = _network(laplacian, time, moves & branched, labels, count)
    diagonal = float(np.linalg.norm(np.ptp(start, axis=0))) if len(start) else 0.0
    now = start
    for done in range(count):
        moved = chains.displacement(now)
        if network is not None:
            part = part_of(progress, done / count, (done + 1) / count)
            moved = moved + network.displacement(now, np.zeros_like(now), diagonal=diagonal, progress=part)
        now = now + moved
        progress((done + 1) / count)
    return now


def _network(laplacian: Laplacian, time: float, free: Bools, labels: Ints, count: int) -> BackwardEulerStep | None:
    if not free.any():
        return None
    return BackwardEulerStep(laplacian, time, fixed=~free, components=labels, steps=count)


def _in_branched_component(rings: OneRings, moves: Bools, labels: Ints) -> Bools:
    """(n,) whether a vertex is connected with one that moves and has more than two neighbours that move."""
    running = np.concatenate([[0], np.cumsum(moves[rings.neighbours])])
    branching = moves & (running[rings.offsets[1:]] - running[rings.offsets[:-1]] > 2)
    if not branching.any():
        return np.zeros(len(moves), dtype=np.bool_)
    affected = np.zeros(int(labels.max()) + 1, dtype=np.bool_)
    affected[labels[branching]] = True
    return np.asarray(affected[labels])

"""Smooths polylines by explicit, Taubin or implicit steps; elimination solves the implicit steps on unbranched curves."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from .checks import FilterInputError, check_choice, check_finite, check_positive, check_whole_number
from .compilation import compiled
from .diffusion.explicit import checked_mu
from .diffusion.implicit import LONGEST_STEP, BackwardEulerStep, time_step_of_detail_size
from .diffusion.stencil import curve_stencil
from .execution import Progress, ignore_progress, part_of, threads_for
from .linear_solvers import CompressedRows
from .mesh import Bools, Floats, Ints, Longs, check_edges, check_points, mask_of, normalised_mesh, worth_reordering
from .operators import Laplacian, OperatorName, curve_laplacian
from .topology import OneRings, one_rings

__all__ = ["CurveBorder", "CurveMethod", "CurveWeights", "curve_smoothing"]

CurveMethod: TypeAlias = Literal["explicit", "implicit", "taubin"]
#: "uniform": w_ij = 1. "inverse_length": w_ij = 1 / |p_j - p_i|.
CurveWeights: TypeAlias = Literal["uniform", "inverse_length"]
#: "fixed": the ends of open curves stay. "free": they move towards their only neighbour, so that open curves get shorter.
CurveBorder: TypeAlias = Literal["fixed", "free"]
# Limits of the detail size on a mesh of size 1: smaller sizes smooth nothing, larger sizes everything.
_SMALLEST_SIZE, _LARGEST_SIZE = 1e-100, 1e50


def curve_smoothing(
    vertices: ArrayLike,
    edges: ArrayLike,
    *,
    method: CurveMethod = "explicit",
    weights: CurveWeights = "uniform",
    step: float = 0.5,
    mu: float = -0.53,
    pass_band: float | None = None,
    time_step: float | None = None,
    detail_size: float | None = None,
    iterations: int = 10,
    border: CurveBorder = "fixed",
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Smooths curves by diffusion, with (L p)_i = sum_j w_ij (p_j - p_i) / sum_j w_ij over the neighbours j of i [taubin1995].

    Each iteration maps p to (1 + step L) p ("explicit"), (1 + mu L)(1 + step L) p ("taubin") or (1 - t L)^-1 p ("implicit"). It
    multiplies a mode of eigenvalue -k of L by 1 - step k, (1 - step k)(1 - mu k) or 1 / (1 + t k). With uniform weights the modes
    of a closed curve of n vertices are the waves cos(2 pi m j / n) and sin(2 pi m j / n) along it, with k = 1 - cos(2 pi m / n).
    So explicit steps below 1 shrink the curve to its centroid; up to 0.5, waves with m = 1 fade last. Taubin steps keep its size.

    A mesh may have any number of curves, and curves may branch. A duplicate edge counts once, an edge from a vertex to itself not
    at all. An edge of length 0 has the weight of an edge with a millionth of the mean length.

    Args:
        vertices: (n, 3) coordinates. A coordinate that is equal at all vertices keeps every bit.
        edges: (e, 2) pairs of vertices, in any order and direction.
        method: the kind of step. "implicit" smooths strongly in one step.
        weights: "uniform" evens out the distances of vertices along the curve. "inverse_length" does not move the vertices of a
            straight line, however uneven their distances; without a detail size, vertices that are very near each other hardly
            move. "explicit" and "taubin" update the weights in each step; "implicit" takes the weights of the input.
        step: lambda, for "explicit" and "taubin", above 0 and at most 1. Larger is smoother; above 0.5 zigzags fade less.
        mu: for "taubin", the step back, below -step. Nearer to -step is smoother.
        pass_band: for "taubin", k_PB = 1/step + 1/mu, above 0, below 1/step and at most 2; replaces mu. Smaller is smoother.
        time_step: t, for "implicit", a number without unit, at least 0. Larger is smoother; every value is stable.
        detail_size: for "implicit" with "inverse_length", instead of `time_step`: the wavelength, in mesh units, whose amplitude
            all iterations together halve. L is then the second derivative by arc length; the mass of a vertex is half the length
            of its edges, and t = (2^(1 / iterations) - 1) (detail_size / 2 pi)^2. Larger is smoother.
        iterations: number of steps, or of pairs of steps. More are smoother; with a detail size they make the cut-off sharper.
        border: policy for the ends of open curves, the vertices with one neighbour; see `CurveBorder`.
        movable: (n,) bool, which vertices may move, None for all. Fixed vertices still count as neighbours.
        progress: called after every iteration; may raise to stop.

    Returns:
        (n, 3) float64. These vertices keep every bit: those without edges, those that are not `movable`, and fixed ends.
        "implicit" is exact to rounding on curves where no moving vertex has more than two moving neighbours, and to 1e-10 of the
        bounding-box diagonal on branching curves.

    Raises:
        FilterInputError: not a mesh of edges, or a parameter that is out of range, missing or does not fit the others.
        UnstableStepError: Taubin steps would amplify the finest detail.
        ConvergenceError: the equations of branching curves cannot be solved.
    """
    points = check_points(vertices)
    check_choice("method", method, CurveMethod)
    check_choice("weights", weights, CurveWeights)
    check_choice("border", border, CurveBorder)
    count = check_whole_number("iterations", iterations, least=0)
    mesh = normalised_mesh(points, check_edges(edges, len(points)), movable)
    rings = one_rings(mesh.cells, len(mesh))
    sweeps = math.inf if method == "implicit" else count * (2 if method == "taubin" else 1)
    if worth_reordering(mesh.cells, len(mesh), sweeps):
        # The vertices of each unbranched chain are stored next to each other.
        simple = np.diff(rings.offsets) <= 2
        mesh = mesh.in_order(np.concatenate([trace_chains(rings, simple).order, np.flatnonzero(~simple).astype(np.int32)]))
        rings = one_rings(mesh.cells, len(mesh))
    moves = np.diff(rings.offsets) > (1 if border == "fixed" else 0)
    if mesh.movable is not None:
        moves &= mesh.movable
    with threads_for(len(mesh)):
        if method == "implicit":
            time, operator = _time_and_operator(weights, time_step, detail_size, mesh.scale, count)
            laplacian = curve_laplacian(mesh.points, mesh.cells, operator)
            now = implicit_curve_steps(mesh.points, laplacian, rings, time, count, moves, progress)
        else:
            if time_step is not None or detail_size is not None:
                raise FilterInputError(f"time_step and detail_size are for the method 'implicit'; {method!r} takes a step")
            steps = _steps(method, step, mu, pass_band)
            advance = curve_stencil(mesh.points, weights, moves.view(np.uint8), rings[:2])
            now, following = mesh.points.copy(), mesh.points.copy()
            for done in range(count):
                for length in steps:
                    advance(now, following, length)
                    now, following = following, now
                progress((done + 1) / count)
    return mesh.restored(now)


def _steps(method: CurveMethod, step: float, mu: float, pass_band: float | None) -> tuple[float, ...]:
    if method == "taubin":
        return step, checked_mu(step, mu, pass_band)
    check_positive("step", step, most=1.0, note="; for stronger smoothing take more iterations or 'implicit'")
    return (step,)


def _time_and_operator(
    weights: CurveWeights, time_step: float | None, detail_size: float | None, scale: float, iterations: int
) -> tuple[float, OperatorName]:
    """Returns the time step on the normalised mesh, and the name of the operator."""
    if (time_step is None) == (detail_size is None):
        raise FilterInputError("the method 'implicit' takes either a time_step or a detail_size")
    if detail_size is not None:
        if weights != "inverse_length":
            raise FilterInputError("uniform weights do not depend on lengths: give a time_step, or take 'inverse_length'")
        check_positive("detail_size", detail_size)
        # Scaled before it is squared, so that the square neither overflows nor underflows.
        size = min(max(detail_size * scale, _SMALLEST_SIZE), _LARGEST_SIZE)
        return time_step_of_detail_size(size, iterations=iterations), "scale_dependent"
    assert time_step is not None
    check_finite("time_step", time_step, least=0.0)
    return time_step, weights


def implicit_curve_steps(
    start: Floats, laplacian: Laplacian, rings: OneRings, time: float, count: int, moves: Bools, progress: Progress
) -> Floats:
    """Returns (n, 3) the vertices after `count` steps, each of which solves (M - t C) d = t C p for the displacement d.

    L = M^-1 C with masses M and the stiffness matrix C; t has the inverse unit of L. Elimination solves chains without branches:
    M - t C is a network of conductances, t w_ij between neighbours, and M_i from each vertex to the ground. Eliminating a vertex
    of a chain leaves a smaller network. Its conductances are sums, products and quotients of positive numbers, so each is exact
    to rounding for any t and any length of the chain. If no vertex of a chain has a fixed neighbour, the currents t C p sum to 0.
    Then the current into the vertex eliminated last is minus the sum of the currents from all other vertices to the ground.
    """
    labels = laplacian.components()
    branched = _in_branched_component(rings, moves, labels)
    chains, t, stiffness = trace_chains(rings, moves & ~branched), min(time, LONGEST_STEP), laplacian.stiffness
    # The division by 1 + t keeps all conductances finite. Entries of C off the diagonal are not negative.
    conductances = CompressedRows(stiffness.indptr, stiffness.indices, stiffness.data * (t / (1.0 + t)))
    shares = np.zeros((4, len(chains.order)))
    _eliminate(conductances, laplacian.mass / (1.0 + t), chains, shares)
    free = moves & branched
    network = BackwardEulerStep(laplacian, time, fixed=~free, components=labels, solves=count) if free.any() else None
    diagonal = float(np.linalg.norm(np.ptp(start, axis=0))) if len(start) else 0.0
    now = start
    for done in range(count):
        moved = np.zeros_like(now)
        _substitute(now, conductances, chains, shares, moved)
        if network is not None:
            part = part_of(progress, done / count, (done + 1) / count)
            moved = moved + network.displacement(now, None, diagonal=diagonal, progress=part)
        now = now + moved
        progress((done + 1) / count)
    return now


def _in_branched_component(rings: OneRings, moves: Bools, labels: Ints) -> Bools:
    """Returns (n,) whether the component of each vertex contains a moving vertex with more than two moving neighbours."""
    running = np.concatenate([[0], np.cumsum(moves[rings.neighbours])])
    branching = moves & (running[rings.offsets[1:]] - running[rings.offsets[:-1]] > 2)
    return np.asarray(mask_of(labels[branching], int(labels.max(initial=-1)) + 1)[labels])


@compiled
def _eliminate(network: CompressedRows, mass: Floats, chains: Chains, shares: Floats) -> None:
    """Eliminates the vertices of each chain in their order, but the first vertex of a ring last; fills the rows of `shares`.

    A column belongs to a vertex. Its first three rows have the shares of the vertex's current that go to the next vertex, to the
    first vertex of the ring and to the ground. The fourth row is 1 over the sum of the vertex's conductances, its resistance.
    """
    order, starts, closed, _ = chains
    to_next, to_first, to_ground, resistance = shares[0], shares[1], shares[2], shares[3]
    for c in range(closed.shape[0]):
        start, stop = starts[c], starts[c + 1]
        first, ring = order[start], closed[c]
        ground_of_first = _ground(network, mass, order, start, stop, start, ring) if ring else 0.0
        carried, back = 0.0, _weight(network, order[start + 1], first) if ring else 0.0
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
def _ground(network: CompressedRows, mass: Floats, order: Ints, start: int, stop: int, k: int, ring: bool) -> float:
    """Returns the conductance from vertex `order[k]` to the ground; its neighbours outside the chain count as ground."""
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
def _weight(network: CompressedRows, i: int, j: int) -> float:
    offsets, columns, weights = network
    for e in range(offsets[i], offsets[i + 1]):
        if columns[e] == j:
            return float(weights[e])
    return 0.0


@compiled
def _substitute(points: Floats, network: CompressedRows, chains: Chains, shares: Floats, moved: Floats) -> None:
    """Passes currents forwards, then potentials backwards; `moved` gets the currents, then the potentials (the displacements)."""
    offsets, columns, weights = network
    order, starts, closed, floating = chains
    to_next, to_first, to_ground, resistance = shares[0], shares[1], shares[2], shares[3]
    lost = np.zeros(3)
    for c in range(closed.shape[0]):
        start, stop = starts[c], starts[c + 1]
        for k in range(start, stop):
            i = order[k]
            for e in range(offsets[i], offsets[i + 1]):
                for d in range(3):
                    moved[i, d] += weights[e] * (points[columns[e], d] - points[i, d])
        # The root is the vertex that is eliminated last: the first vertex of a ring, the last vertex of an open chain.
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


class Chains(NamedTuple):
    """The free vertices, chain after chain."""

    order: Ints  # (f,) int32; chain k has the vertices ``order[starts[k]:starts[k + 1]]``, each the neighbour of the next
    starts: Longs  # (c + 1,) int64
    closed: Bools  # (c,) bool, whether the last vertex of a chain is the neighbour of its first
    floating: Bools  # (c,) bool, whether no vertex of a chain has a fixed neighbour


@compiled
def trace_chains(rings: OneRings, free: Bools) -> Chains:
    """Returns the chains of (n,) free vertices, none of which has more than two free neighbours."""
    offsets, neighbours, _ = rings
    n = free.shape[0]
    order, starts = np.empty(n, dtype=np.int32), np.zeros(n + 1, dtype=np.int64)
    closed, floating = np.empty(n, dtype=np.bool_), np.empty(n, dtype=np.bool_)
    done = ~free
    placed = chains = 0
    # The first pass starts at ends; all remaining chains are rings.
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
    return Chains(order[:placed], starts[: chains + 1], closed[:chains], floating[:chains])

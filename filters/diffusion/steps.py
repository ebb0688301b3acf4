"""Kernels of one explicit diffusion step, over one-rings and stars.

Each kernel takes the points of one moment and writes those of the next for the vertices that move, all at once as the paper's
equation says: out_i = p_i + step (L p)_i. The others, 0 in `moves`, keep what `out` holds.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ..compilation import compiled, prange
from ..mesh import Bools, Floats, Ints, Longs
from ..operators import halved_cotangents, mixed_share
from ..topology import CLOSED, OPEN, Kinds, Stars

# Indices are taken as unsigned numbers: for signed ones the compiler adds the test whether they count from the end.
_U: Any = np.uint64
#: the sum of the weights' sizes; the mixed Voronoi area; MeshLab's sum of the doubled weights, plus one
NORMALISED, BY_AREA, MESHLAB = 0, 1, 2
#: Vertices whose stars are worked on together; their edges stay in the first cache.
_BLOCK = 64


class Rings(NamedTuple):
    """The neighbours that count for each vertex i: ``neighbours[offsets[i]:offsets[i + 1]]``.

    Parallel kernels take the two arrays: with the tuple these short loops take 6 % longer.
    """

    offsets: Longs  # (n + 1,) int64
    neighbours: Ints  # int32


@compiled(parallel=True)
def uniform_step(points: Floats, out: Floats, moves: Kinds, offsets: Longs, neighbours: Ints, step: float) -> None:
    """Towards the mean of the one-ring."""
    for i in prange(moves.shape[0]):
        if moves[i]:
            start, stop = _U(offsets[i]), _U(offsets[i + 1])
            x = y = z = 0.0
            k = start
            while k + _U(1) < stop:  # two at a time: half of the branches, which are what takes time
                j = _U(neighbours[k])
                x += points[j, 0]
                y += points[j, 1]
                z += points[j, 2]
                j = _U(neighbours[k + _U(1)])
                x += points[j, 0]
                y += points[j, 1]
                z += points[j, 2]
                k += _U(2)
            if k < stop:
                j = _U(neighbours[k])
                x += points[j, 0]
                y += points[j, 1]
                z += points[j, 2]
            share = step / np.int64(stop - start)
            out[i, 0] = points[i, 0] + (share * x - step * points[i, 0])
            out[i, 1] = points[i, 1] + (share * y - step * points[i, 1])
            out[i, 2] = points[i, 2] + (share * z - step * points[i, 2])


@compiled(parallel=True)
def weighted_step(
    points: Floats, out: Floats, moves: Kinds, offsets: Longs, neighbours: Ints, weights: Floats, shares: Floats
) -> None:
    """By the sum of weights times edges, times the vertex's share, which holds the step and one over the mass."""
    for i in prange(moves.shape[0]):
        if moves[i]:
            px, py, pz = points[i, 0], points[i, 1], points[i, 2]
            x = y = z = 0.0
            for k in range(_U(offsets[i]), _U(offsets[i + 1])):
                j = _U(neighbours[k])
                x += weights[k] * (points[j, 0] - px)
                y += weights[k] * (points[j, 1] - py)
                z += weights[k] * (points[j, 2] - pz)
            out[i, 0] = px + shares[i] * x
            out[i, 1] = py + shares[i] * y
            out[i, 2] = pz + shares[i] * z


@compiled(parallel=True)
def length_step(
    points: Floats, out: Floats, moves: Kinds, offsets: Longs, neighbours: Ints, step: float, shortest: float, by_arc_length: bool
) -> float:
    """By the sum of edges over their lengths: over the sum of inverse lengths, or (`by_arc_length`) over half that of lengths.

    Edges shorter than `shortest` count as that long. Returns Gershgorin's bound of the spectrum of -L, by arc length.
    """
    bound = 0.0
    for i in prange(moves.shape[0]):
        if moves[i]:
            row = _pull(points, out, _U(i), neighbours, _U(offsets[i]), _U(offsets[i + 1]), step, shortest, by_arc_length)
            bound = max(bound, row)
    return bound


@compiled
def _pull(
    points: Floats,
    out: Floats,
    i: int,
    neighbours: Ints,
    start: int,
    stop: int,
    step: float,
    shortest: float,
    by_arc_length: bool,
) -> float:
    px, py, pz = points[i, 0], points[i, 1], points[i, 2]
    x = y = z = inverses = lengths = 0.0
    for k in range(start, stop):
        j = _U(neighbours[k])
        dx, dy, dz = points[j, 0] - px, points[j, 1] - py, points[j, 2] - pz
        length = max(math.sqrt(dx * dx + dy * dy + dz * dz), shortest)
        weight = 1.0 / length
        x += weight * dx
        y += weight * dy
        z += weight * dz
        inverses += weight
        lengths += length
    share = 2.0 * step / lengths if by_arc_length else step / inverses
    out[i, 0] = px + share * x
    out[i, 1] = py + share * y
    out[i, 2] = pz + share * z
    return 4.0 * inverses / lengths


@compiled(parallel=True)
def sum_ring_lengths(points: Floats, offsets: Longs, neighbours: Ints, sums: Floats) -> None:
    """For every vertex the sum of the lengths of its edges, into `sums`."""
    for i in prange(sums.shape[0]):
        total = 0.0
        for k in range(_U(offsets[i]), _U(offsets[i + 1])):
            j = _U(neighbours[k])
            dx, dy, dz = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            total += math.sqrt(dx * dx + dy * dy + dz * dz)
        sums[i] = total


@compiled
def _share(rule: int, step: float, total: float, size: float, area: float) -> float:
    """The factor of the weighted sum of edges; 0 where the operator is not defined."""
    if rule == NORMALISED:
        return step / size if size > 0.0 else 0.0
    if rule == BY_AREA:
        return step / area if area > 0.0 else 0.0
    return 2.0 / (2.0 * total + 1.0) if total > 0.0 else 0.0


@compiled(parallel=True)
def star_step(points: Floats, out: Floats, kinds: Kinds, offsets: Longs, neighbours: Ints, rule: int, step: float) -> float:
    """A step of the vertices with closed and open stars, whose neighbours are in the order of a walk round or across.

    Returns Gershgorin's bound of the spectrum of -L, by area.
    """
    bound, n = 0.0, kinds.shape[0]
    for block in prange((n + _BLOCK - 1) // _BLOCK):
        first, last = block * _BLOCK, min((block + 1) * _BLOCK, n)
        bound = max(bound, _move_block(points, out, kinds, first, last, offsets, neighbours, rule, step))
    return bound


@compiled(error_model="numpy")
def _move_block(
    points: Floats,
    out: Floats,
    kinds: Kinds,
    first: int,
    last: int,
    offsets: Longs,
    neighbours: Ints,
    rule: int,
    step: float,
) -> float:
    """A step of the vertices from `first` to `last`."""
    # The edges of one star after the other, the first of each once more at its end.
    edges = np.empty((6, offsets[last] - offsets[first] + last - first))
    x, y, z, squares, at_u, at_v = edges[0], edges[1], edges[2], edges[3], edges[4], edges[5]
    at = _U(0)
    for i in range(_U(first), _U(last)):
        if kinds[i] == CLOSED or kinds[i] == OPEN:
            start = at
            px, py, pz = points[i, 0], points[i, 1], points[i, 2]
            for k in range(_U(offsets[i]), _U(offsets[i + _U(1)])):
                j = _U(neighbours[k])
                dx, dy, dz = points[j, 0] - px, points[j, 1] - py, points[j, 2] - pz
                x[at], y[at], z[at], squares[at] = dx, dy, dz, dx * dx + dy * dy + dz * dz
                at += _U(1)
            x[at], y[at], z[at], squares[at] = x[start], y[start], z[start], squares[start]
            at += _U(1)
    # Of each edge u and the next, v. Square roots and divisions of several at a time: most of the work.
    for u in range(max(at, _U(1)) - _U(1)):
        v = u + _U(1)
        at_u[u], at_v[u] = halved_cotangents(x[u], y[u], z[u], squares[u], x[v], y[v], z[v], squares[v])
    bound, at = 0.0, _U(0)
    for i in range(_U(first), _U(last)):
        if kinds[i] == CLOSED or kinds[i] == OPEN:
            end = at + _U(offsets[i + _U(1)] - offsets[i]) - _U(1)
            row = _move(points, out, i, kinds[i] == CLOSED, x, y, z, squares, at_u, at_v, at, end, rule, step)
            bound = max(bound, row)
            at = end + _U(2)
    return bound


@compiled(error_model="numpy")
def _move(
    points: Floats,
    out: Floats,
    i: int,
    closed: bool,
    x: Floats,
    y: Floats,
    z: Floats,
    squares: Floats,
    at_u: Floats,
    at_v: Floats,
    first: int,
    last: int,
    rule: int,
    step: float,
) -> float:
    """Moves a vertex by the edges of its star, from `first` to `last`."""
    sx = sy = sz = total = size = area = 0.0
    # An edge has a weight from each of its two triangles: `weight` is that from the triangle before it.
    weight = at_u[last] if closed else 0.0
    for u in range(first, last + _U(1)):
        if u < last:
            weight += at_v[u]
        elif closed:
            weight += at_v[last]
        sx += weight * x[u]
        sy += weight * y[u]
        sz += weight * z[u]
        total += weight
        size += abs(weight)
        weight = at_u[u]
    if rule == BY_AREA:
        if closed:
            v = last + _U(1)
            area += mixed_share(x[last], y[last], z[last], squares[last], x[v], y[v], z[v], squares[v])
        for u in range(first, last):
            v = u + _U(1)
            area += mixed_share(x[u], y[u], z[u], squares[u], x[v], y[v], z[v], squares[v])
    share = _share(rule, step, total, size, area)
    out[i, 0] = points[i, 0] + share * sx
    out[i, 1] = points[i, 1] + share * sy
    out[i, 2] = points[i, 2] + share * sz
    return (total + size) / area if area > 0.0 else 0.0


@compiled
def irregular_step(points: Floats, out: Floats, star: Stars, moves: Bools, rule: int, step: float) -> float:
    """As `star_step`, for those of the irregular vertices that move."""
    _, offsets, neighbours, irregular, end_offsets, ends = star
    bound = 0.0
    for m in range(irregular.shape[0]):
        if not moves[m]:
            continue
        i = irregular[m]
        start, stop = offsets[i], offsets[i + 1]
        weights = np.zeros(stop - start)
        area = 0.0
        for k in range(end_offsets[m], end_offsets[m + 1], 2):
            a, b = neighbours[ends[k]], neighbours[ends[k + 1]]
            ux, uy, uz = points[a, 0] - points[i, 0], points[a, 1] - points[i, 1], points[a, 2] - points[i, 2]
            vx, vy, vz = points[b, 0] - points[i, 0], points[b, 1] - points[i, 1], points[b, 2] - points[i, 2]
            uu = ux * ux + uy * uy + uz * uz
            vv = vx * vx + vy * vy + vz * vz
            at_a, at_b = halved_cotangents(ux, uy, uz, uu, vx, vy, vz, vv)
            weights[ends[k + 1] - start] += at_a
            weights[ends[k] - start] += at_b
            area += mixed_share(ux, uy, uz, uu, vx, vy, vz, vv)
        total = weights.sum()
        size = np.abs(weights).sum()
        share = _share(rule, step, total, size, area)
        for c in range(3):
            change = 0.0
            for k in range(start, stop):
                change += weights[k - start] * (points[neighbours[k], c] - points[i, c])
            out[i, c] = points[i, c] + share * change
        if area > 0.0:
            bound = max(bound, (total + size) / area)
    return bound


@compiled(parallel=True)
def element_bound(points: Floats, faces: Ints) -> float:
    """A bound of the spectrum of -L by area: the largest eigenvalue of a single triangle's own M^-1 C.

    The operator's stiffness and areas are sums over the triangles, so that no eigenvalue of the whole lies above those of the
    parts [irons1971]. It is exact on a lattice of equilateral triangles, where Gershgorin's bound is 4/3 of the truth.
    """
    bound = 0.0
    for f in prange(faces.shape[0]):
        bound = max(bound, _largest_eigenvalue(points, faces[f, 0], faces[f, 1], faces[f, 2]))
    return bound


@compiled
def _largest_eigenvalue(points: Floats, a: int, b: int, c: int) -> float:
    if a == b or b == c or c == a:
        return 0.0
    wa, wb, wc, ma, mb, mc = _element(points, a, b, c)
    if ma == 0.0 or mb == 0.0 or mc == 0.0:
        return np.inf if wa != 0.0 or wb != 0.0 or wc != 0.0 else 0.0
    trace = (wb + wc) / ma + (wc + wa) / mb + (wa + wb) / mc
    minors = (wa * wb + wb * wc + wc * wa) * (1.0 / (ma * mb) + 1.0 / (mb * mc) + 1.0 / (mc * ma))
    return 0.5 * (trace + math.sqrt(max(trace * trace - 4.0 * minors, 0.0)))


@compiled
def _element(points: Floats, a: int, b: int, c: int) -> tuple[float, float, float, float, float, float]:
    """The halved cotangents at the three corners, and the mixed area of each."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    dx, dy, dz = vx - ux, vy - uy, vz - uz
    uu, vv, dd = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, dx * dx + dy * dy + dz * dz
    at_b, at_c = halved_cotangents(ux, uy, uz, uu, vx, vy, vz, vv)
    _, at_a = halved_cotangents(dx, dy, dz, dd, -ux, -uy, -uz, uu)
    of_a = mixed_share(ux, uy, uz, uu, vx, vy, vz, vv)
    of_b = mixed_share(dx, dy, dz, dd, -ux, -uy, -uz, uu)
    of_c = mixed_share(-vx, -vy, -vz, vv, -dx, -dy, -dz, dd)
    return at_a, at_b, at_c, of_a, of_b, of_c

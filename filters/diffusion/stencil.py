"""Explicit steps of an operator on a mesh: the choice of vertices that move, the kernels, and a bound of the spectrum.

Each kernel writes out_i = p_i + step (L p)_i for the vertices that it moves. MeshLab's rule has no step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, TypeAlias

import numpy as np

from ..checks import FilterInputError, check_choice
from ..compilation import compiled, prange
from ..mesh import Bools, Floats, Index, Ints, Longs, NormalisedMesh, mask_of
from ..operators import (
    CURVE_OPERATOR,
    OPERATOR_NAMES,
    SHORTEST_EDGE,
    Laplacian,
    OperatorName,
    build_laplacian,
    curve_laplacian,
    halved_cotangents,
    mixed_share,
)
from ..topology import BORDER_POLICIES, CLOSED, IRREGULAR, NO_STAR, OPEN, BorderPolicy, Kinds, Stars, one_rings

#: "euler": p + step (L p). "meshlab": MeshLab's rule, which includes the vertex in the mean.
UpdateRule: TypeAlias = Literal["euler", "meshlab"]
UPDATE_RULES: tuple[UpdateRule, ...] = ("euler", "meshlab")
#: Takes the points before the step, an array for the points after the step, and the step. Returns an upper bound of the spectrum
#: of -L: a step of at most 2 / bound amplifies no mode; after a longer step the points are undefined.
Advance: TypeAlias = Callable[[Floats, Floats, float], float]
#: The offsets, (n + 1,) int64, and the neighbours, int32: vertex i has the neighbours ``neighbours[offsets[i]:offsets[i + 1]]``.
#: Parallel kernels take the two arrays one by one: with the tuple their short loops take 6 % longer.
Rings: TypeAlias = tuple[Longs, Ints]
#: The divisor of the operator: the sum of absolute weights; the mixed Voronoi area; MeshLab's sum of doubled weights, plus one.
NORMALISED, BY_AREA, MESHLAB = 0, 1, 2
#: Vertices in a block; the edges of their stars stay in the first-level cache.
_BLOCK = 64


def explicit_stencil(
    mesh: NormalisedMesh, star: Stars, operator: OperatorName, *, border: BorderPolicy, update: UpdateRule
) -> Advance:
    """Returns the step of `operator`; weights are those of the current points, or of the input on clouds and for "robust"."""
    check_choice("operator", operator, OPERATOR_NAMES)
    check_choice("update", update, UPDATE_RULES)
    if update == "meshlab" and operator not in ("uniform", "cotangent"):
        raise FilterInputError(f"MeshLab's update rule is defined for the operators 'uniform' and 'cotangent', not {operator!r}")
    if len(mesh.cells_in_vertices) == 0 and len(mesh) > 0:
        free = np.ones(len(mesh), dtype=np.bool_) if mesh.movable is None else mesh.movable
        return _assembled(build_laplacian(mesh.points, mesh.cells, operator), free.view(np.uint8))
    check_choice("border", border, BORDER_POLICIES)
    none = np.uint8(NO_STAR)
    inside = star.kinds if mesh.movable is None else np.where(mesh.movable, star.kinds, none)
    on_curve = np.empty(0, dtype=np.uint8)
    edges = np.empty((0, 2), dtype=np.int32) if border == "free" else star.border_edges()
    if len(edges):
        at_border = mask_of(edges, len(mesh))
        inside, on_curve = np.where(at_border, none, inside), np.where(at_border, inside, none)
    if update == "euler":
        surface = _surface(mesh, operator, star, inside)
    elif operator == "cotangent":
        surface = _cotangent(star, inside, MESHLAB)
    else:
        counts = star.face_counts().astype(np.float64)  # an interior edge counts twice, because it has two faces
        surface = _of_meshlab(inside, (star.offsets, star.neighbours), counts, 1.0)
    if border == "fixed" or not on_curve.any():
        return surface
    rings = one_rings(edges, len(mesh))[:2]
    if update == "euler":
        curve = curve_stencil(mesh.points, operator, on_curve, rings)
    else:
        curve = _of_meshlab(on_curve, rings, np.ones(len(rings[1])), 2.0)
    return lambda now, out, step: max(surface(now, out, step), curve(now, out, step))


def _surface(mesh: NormalisedMesh, operator: OperatorName, star: Stars, kinds: Kinds) -> Advance:
    rings = star.offsets, star.neighbours
    if operator == "uniform":
        return _uniform(kinds, rings)
    if operator == "inverse_length" or operator == "scale_dependent":
        return _lengths(mesh.points, kinds, rings, operator == "scale_dependent")
    if operator == "cotangent":
        return _cotangent(star, kinds, NORMALISED)
    if operator == "laplace_beltrami":
        stencil = _cotangent(star, kinds, BY_AREA)

        def advance(now: Floats, out: Floats, step: float) -> float:
            bound = stencil(now, out, step)
            # The sharper bound costs a pass over the triangles.
            return bound if step * bound <= 2.0 else min(bound, float(_element_bound(now, mesh.cells)))

        return advance
    return _assembled(build_laplacian(mesh.points, mesh.cells, operator), kinds)


def curve_stencil(points: Floats, operator: OperatorName, moves: Kinds, rings: Rings) -> Advance:
    """Returns the step of the `CURVE_OPERATOR` of `operator` on polylines with the neighbours `rings`."""
    if CURVE_OPERATOR[operator] == "uniform":
        return _uniform(moves, rings)
    if operator == "robust":
        ends = np.repeat(np.arange(len(points), dtype=np.int32), np.diff(rings[0]))
        edges = np.column_stack([ends, rings[1]])[ends < rings[1]]
        return _assembled(curve_laplacian(points, edges, operator), moves)
    return _lengths(points, moves, rings, CURVE_OPERATOR[operator] == "scale_dependent")


def _uniform(moves: Kinds, rings: Rings) -> Advance:
    def advance(now: Floats, out: Floats, step: float) -> float:
        _uniform_step(now, out, moves, *rings, step)
        return 2.0

    return advance


def _lengths(points: Floats, moves: Kinds, rings: Rings, by_arc_length: bool) -> Advance:
    sums = np.empty(len(points))
    _sum_ring_lengths(points, *rings, sums)
    mean = float(sums.sum()) / max(len(rings[1]), 1)
    shortest = SHORTEST_EDGE * mean if mean > 0.0 else 1.0

    def advance(now: Floats, out: Floats, step: float) -> float:
        bound = _length_step(now, out, moves, *rings, step, shortest, by_arc_length)
        return float(bound) if by_arc_length else 2.0

    return advance


def _cotangent(star: Stars, kinds: Kinds, rule: int) -> Advance:
    irregular = kinds[star.irregular] == IRREGULAR

    def advance(now: Floats, out: Floats, step: float) -> float:
        bound = _star_step(now, out, kinds, star.offsets, star.neighbours, rule, step)
        if len(irregular):
            bound = max(bound, _irregular_step(now, out, star, irregular, rule, step))
        return float(bound) if rule == BY_AREA else 2.0

    return advance


def _assembled(laplacian: Laplacian, moves: Kinds) -> Advance:
    stiffness, inverse_mass, bound = laplacian.stiffness, laplacian.inverse_mass, laplacian.spectral_bound()
    rings = stiffness.indptr.astype(np.int64), stiffness.indices.astype(np.int32)

    def advance(now: Floats, out: Floats, step: float) -> float:
        if step * bound > 2.0:
            return bound
        # The diagonal is among the entries and does no harm: it multiplies p_i - p_i.
        _weighted_step(now, out, moves, *rings, stiffness.data, step * inverse_mass)
        return bound

    return advance


def _of_meshlab(moves: Kinds, rings: Rings, counts: Floats, weight: float) -> Advance:
    """Returns the step from p to (weight p + sum c_j p_j) / (weight + sum c_j), c the `counts`; `weight` is 1, on borders 2."""
    totals = np.concatenate([[0.0], np.cumsum(counts)])
    shares = 1.0 / (totals[rings[0][1:]] - totals[rings[0][:-1]] + weight)

    def advance(now: Floats, out: Floats, step: float) -> float:
        _weighted_step(now, out, moves, *rings, counts, shares)
        return 2.0

    return advance


@compiled(parallel=True)
def _uniform_step(points: Floats, out: Floats, moves: Kinds, offsets: Longs, neighbours: Ints, step: float) -> None:
    for i in prange(moves.shape[0]):
        if moves[i]:
            start, stop = Index(offsets[i]), Index(offsets[i + 1])
            x = y = z = 0.0
            k = start
            while k + Index(1) < stop:  # two at a time, to halve the branches, which take most of the time
                j = Index(neighbours[k])
                x += points[j, 0]
                y += points[j, 1]
                z += points[j, 2]
                j = Index(neighbours[k + Index(1)])
                x += points[j, 0]
                y += points[j, 1]
                z += points[j, 2]
                k += Index(2)
            if k < stop:
                j = Index(neighbours[k])
                x += points[j, 0]
                y += points[j, 1]
                z += points[j, 2]
            share = step / np.int64(stop - start)
            out[i, 0] = points[i, 0] + (share * x - step * points[i, 0])
            out[i, 1] = points[i, 1] + (share * y - step * points[i, 1])
            out[i, 2] = points[i, 2] + (share * z - step * points[i, 2])


@compiled(parallel=True)
def _weighted_step(
    points: Floats, out: Floats, moves: Kinds, offsets: Longs, neighbours: Ints, weights: Floats, shares: Floats
) -> None:
    """Moves each vertex by the weighted sum of its edge vectors, times its number in `shares`."""
    for i in prange(moves.shape[0]):
        if moves[i]:
            px, py, pz = points[i, 0], points[i, 1], points[i, 2]
            x = y = z = 0.0
            for k in range(Index(offsets[i]), Index(offsets[i + 1])):
                j = Index(neighbours[k])
                x += weights[k] * (points[j, 0] - px)
                y += weights[k] * (points[j, 1] - py)
                z += weights[k] * (points[j, 2] - pz)
            out[i, 0] = px + shares[i] * x
            out[i, 1] = py + shares[i] * y
            out[i, 2] = pz + shares[i] * z


@compiled(parallel=True)
def _length_step(
    points: Floats, out: Floats, moves: Kinds, offsets: Longs, neighbours: Ints, step: float, shortest: float, by_arc_length: bool
) -> float:
    """Moves by `step` (sum of unit edges) / q, q the sum of inverse lengths, or with `by_arc_length` half the sum of lengths."""
    bound = 0.0
    for i in prange(moves.shape[0]):
        if moves[i]:
            px, py, pz = points[i, 0], points[i, 1], points[i, 2]
            x = y = z = inverses = lengths = 0.0
            for k in range(Index(offsets[i]), Index(offsets[i + 1])):
                j = Index(neighbours[k])
                dx, dy, dz = points[j, 0] - px, points[j, 1] - py, points[j, 2] - pz
                length = max(math.sqrt(dx * dx + dy * dy + dz * dz), shortest)
                weight = 1.0 / length
                x += weight * dx
                y += weight * dy
                z += weight * dz
                inverses += weight
                lengths += length
            share = 2.0 * step / lengths if by_arc_length else step / inverses
            out[i, 0], out[i, 1], out[i, 2] = px + share * x, py + share * y, pz + share * z
            bound = max(bound, 4.0 * inverses / lengths)
    return bound


@compiled(parallel=True)
def _sum_ring_lengths(points: Floats, offsets: Longs, neighbours: Ints, sums: Floats) -> None:
    for i in prange(sums.shape[0]):
        total = 0.0
        for k in range(Index(offsets[i]), Index(offsets[i + 1])):
            j = Index(neighbours[k])
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
def _star_step(points: Floats, out: Floats, kinds: Kinds, offsets: Longs, neighbours: Ints, rule: int, step: float) -> float:
    """Moves vertices with closed or open stars, whose neighbours are in order; returns Gershgorin's bound of -L for `BY_AREA`."""
    bound, n = 0.0, kinds.shape[0]
    for block in prange((n + _BLOCK - 1) // _BLOCK):
        first, last = block * _BLOCK, min((block + 1) * _BLOCK, n)
        bound = max(bound, _move_block(points, out, kinds, first, last, offsets, neighbours, rule, step))
    return bound


@compiled(error_model="numpy")
def _move_block(
    points: Floats, out: Floats, kinds: Kinds, first: int, last: int, offsets: Longs, neighbours: Ints, rule: int, step: float
) -> float:
    """Moves the vertices from `first` to `last` - 1; returns the bound of `_star_step`."""
    # The edges of all stars in turn. The first edge of each star is repeated at the end of the star.
    edges = np.empty((6, offsets[last] - offsets[first] + last - first))
    x, y, z, squares, at_u, at_v = edges[0], edges[1], edges[2], edges[3], edges[4], edges[5]
    at = Index(0)
    for i in range(Index(first), Index(last)):
        if kinds[i] == CLOSED or kinds[i] == OPEN:
            start = at
            px, py, pz = points[i, 0], points[i, 1], points[i, 2]
            for k in range(Index(offsets[i]), Index(offsets[i + Index(1)])):
                j = Index(neighbours[k])
                dx, dy, dz = points[j, 0] - px, points[j, 1] - py, points[j, 2] - pz
                x[at], y[at], z[at], squares[at] = dx, dy, dz, dx * dx + dy * dy + dz * dz
                at += Index(1)
            x[at], y[at], z[at], squares[at] = x[start], y[start], z[start], squares[start]
            at += Index(1)
    # u is an edge, v the next edge. In a separate loop the processor runs several square roots and divisions at a time.
    for u in range(max(at, Index(1)) - Index(1)):
        v = u + Index(1)
        at_u[u], at_v[u] = halved_cotangents(x[u], y[u], z[u], squares[u], x[v], y[v], z[v], squares[v])
    bound, start = 0.0, Index(0)
    for i in range(Index(first), Index(last)):
        if kinds[i] == CLOSED or kinds[i] == OPEN:
            closed, end = kinds[i] == CLOSED, start + Index(offsets[i + Index(1)] - offsets[i]) - Index(1)
            sx = sy = sz = total = size = area = 0.0
            # The weight of an edge is a sum over its two triangles; `weight` starts with the triangle before the edge.
            weight = at_u[end] if closed else 0.0
            for u in range(start, end + Index(1)):
                if u < end:
                    weight += at_v[u]
                elif closed:
                    weight += at_v[end]
                sx += weight * x[u]
                sy += weight * y[u]
                sz += weight * z[u]
                total += weight
                size += abs(weight)
                weight = at_u[u]
            if rule == BY_AREA:
                if closed:
                    v = end + Index(1)
                    area += mixed_share(x[end], y[end], z[end], squares[end], x[v], y[v], z[v], squares[v])
                for u in range(start, end):
                    v = u + Index(1)
                    area += mixed_share(x[u], y[u], z[u], squares[u], x[v], y[v], z[v], squares[v])
                if area > 0.0:
                    bound = max(bound, (total + size) / area)
            share = _share(rule, step, total, size, area)
            out[i, 0], out[i, 1], out[i, 2] = points[i, 0] + share * sx, points[i, 1] + share * sy, points[i, 2] + share * sz
            start = end + Index(2)
    return bound


@compiled
def _irregular_step(points: Floats, out: Floats, star: Stars, moves: Bools, rule: int, step: float) -> float:
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
def _element_bound(points: Floats, faces: Ints) -> float:
    """Bounds the spectrum of -L for `BY_AREA` by the largest eigenvalue that -M^-1 C has on a single triangle.

    Stiffness and areas are sums over the triangles, so no eigenvalue of the mesh is above the largest of a triangle [irons1971].
    The bound is exact on a lattice of equilateral triangles, where Gershgorin's bound is 4/3 of the largest eigenvalue.
    """
    bound = 0.0
    for f in prange(faces.shape[0]):
        if faces[f, 0] != faces[f, 1] and faces[f, 1] != faces[f, 2] and faces[f, 2] != faces[f, 0]:
            bound = max(bound, _largest_eigenvalue(points, faces[f, 0], faces[f, 1], faces[f, 2]))
    return bound


@compiled
def _largest_eigenvalue(points: Floats, a: int, b: int, c: int) -> float:
    """The largest eigenvalue of one triangle, from the halved cotangents w and the mixed areas m of its corners."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    dx, dy, dz = vx - ux, vy - uy, vz - uz
    uu, vv, dd = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, dx * dx + dy * dy + dz * dz
    wb, wc = halved_cotangents(ux, uy, uz, uu, vx, vy, vz, vv)
    _, wa = halved_cotangents(dx, dy, dz, dd, -ux, -uy, -uz, uu)
    ma = mixed_share(ux, uy, uz, uu, vx, vy, vz, vv)
    mb = mixed_share(dx, dy, dz, dd, -ux, -uy, -uz, uu)
    mc = mixed_share(-vx, -vy, -vz, vv, -dx, -dy, -dz, dd)
    if ma == 0.0 or mb == 0.0 or mc == 0.0:
        return np.inf if wa != 0.0 or wb != 0.0 or wc != 0.0 else 0.0
    trace = (wb + wc) / ma + (wc + wa) / mb + (wa + wb) / mc
    minors = (wa * wb + wb * wc + wc * wa) * (1.0 / (ma * mb) + 1.0 / (mb * mc) + 1.0 / (mc * ma))
    return 0.5 * (trace + math.sqrt(max(trace * trace - 4.0 * minors, 0.0)))

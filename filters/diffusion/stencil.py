"""Explicit steps of an operator on a mesh: the vertices that move, their kernel, and a bound of the spectrum."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ..checks import FilterInputError, check_choice
from ..mesh import Bools, Floats, NormalisedMesh, mask_of
from ..operators import CURVE_OPERATOR, OPERATOR_NAMES, SHORTEST_EDGE, Laplacian, OperatorName, build_laplacian, curve_laplacian
from ..topology import BORDER_POLICIES, IRREGULAR, NO_STAR, BorderPolicy, Kinds, Stars, one_rings
from .steps import (
    BY_AREA,
    MESHLAB,
    NORMALISED,
    Rings,
    element_bound,
    irregular_step,
    length_step,
    star_step,
    sum_ring_lengths,
    uniform_step,
    weighted_step,
)

#: "euler": p + step (L p). "meshlab": MeshLab's own rule, which averages the vertex in.
UpdateRule: TypeAlias = Literal["euler", "meshlab"]
UPDATE_RULES: tuple[UpdateRule, ...] = ("euler", "meshlab")
#: Takes the points of one moment, an array that receives those of the next, and the step; vertices that do not move keep what the
#: array holds. Returns an upper bound of the spectrum of -L: a step of at most 2 / bound amplifies no mode, and what a longer one
#: has written is of no use.
Advance: TypeAlias = Callable[[Floats, Floats, float], float]


def explicit_stencil(
    mesh: NormalisedMesh,
    star: Stars,
    operator: OperatorName,
    *,
    border: BorderPolicy,
    update: UpdateRule = "euler",
) -> Advance:
    """The step of `operator` on a mesh, its weights taken from the current points ("robust": from those of the mesh).

    Args:
        mesh: n points and triangles, or no triangles for a point cloud. Only what the operator needs of it is computed.
        star: the stars of its triangles.
        operator: see `build_laplacian`.
        border: see `BorderPolicy`.
        update: "meshlab" for the operators "uniform" and "cotangent" alone; the step is then not used.

    Raises:
        FilterInputError: an unknown name, or a combination that does not exist.
    """
    check_choice("operator", operator, OPERATOR_NAMES)
    check_choice("update", update, UPDATE_RULES)
    if update == "meshlab" and operator not in ("uniform", "cotangent"):
        raise FilterInputError(f"MeshLab's update rule knows the operators 'uniform' and 'cotangent', not {operator!r}")
    if len(mesh.cells_in_vertices) == 0 and len(mesh) > 0:
        if operator != "robust":
            raise FilterInputError(f"operator {operator!r} needs triangles and there are none; for a point cloud take 'robust'")
        free = np.ones(len(mesh), dtype=np.bool_) if mesh.movable is None else mesh.movable
        return _assembled(build_laplacian(mesh.points, mesh.cells, operator), free.view(np.uint8))
    moving = moving_vertices(star, border, mesh.movable)
    if update == "euler":
        surface = _surface(mesh, operator, star, moving.surface)
    elif operator == "cotangent":
        surface = _cotangent(star, moving.surface, MESHLAB)
    else:
        counts = star.face_counts().astype(np.float64)  # an interior edge counts twice, for it has two faces
        surface = _of_meshlab(moving.surface, Rings(star.offsets, star.neighbours), counts, 1.0)
    if moving.curve is None:
        return surface
    moves, rings = moving.curve
    if update == "euler":
        curve = curve_stencil(mesh.points, operator, moves, rings)
    else:
        curve = _of_meshlab(moves, rings, np.ones(len(rings.neighbours)), 2.0)
    return lambda now, out, step: max(surface(now, out, step), curve(now, out, step))


def _surface(mesh: NormalisedMesh, operator: OperatorName, star: Stars, kinds: Kinds) -> Advance:
    rings = Rings(star.offsets, star.neighbours)
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
            if step * bound <= 2.0:
                return bound
            # The sharper bound costs a pass over the triangles: only where it can make a difference.
            return min(bound, float(element_bound(now, mesh.cells)))

        return advance
    return _assembled(build_laplacian(mesh.points, mesh.cells, operator), kinds)


def curve_stencil(points: Floats, operator: OperatorName, moves: Kinds, rings: Rings) -> Advance:
    """The step on polylines of the operator that `CURVE_OPERATOR` names for `operator`.

    Args:
        points: (n, 3) coordinates of ordinary size.
        operator: see `build_laplacian`; the weights are taken from the current points, for "robust" from `points`.
        moves: (n,) uint8, 0 for vertices that stay.
        rings: the neighbours of all n vertices along the polylines.
    """
    if CURVE_OPERATOR[operator] == "uniform":
        return _uniform(moves, rings)
    if operator == "robust":
        ends = np.repeat(np.arange(len(points), dtype=np.int32), np.diff(rings.offsets))
        edges = np.column_stack([ends, rings.neighbours])[ends < rings.neighbours]
        return _assembled(curve_laplacian(points, edges, operator), moves)
    return _lengths(points, moves, rings, CURVE_OPERATOR[operator] == "scale_dependent")


def _uniform(moves: Kinds, rings: Rings) -> Advance:
    def advance(now: Floats, out: Floats, step: float) -> float:
        uniform_step(now, out, moves, *rings, step)
        return 2.0

    return advance


def _lengths(points: Floats, moves: Kinds, rings: Rings, by_arc_length: bool) -> Advance:
    sums = np.empty(len(points))
    sum_ring_lengths(points, *rings, sums)
    mean = float(sums.sum()) / max(len(rings.neighbours), 1)
    shortest = SHORTEST_EDGE * mean if mean > 0.0 else 1.0

    def advance(now: Floats, out: Floats, step: float) -> float:
        bound = length_step(now, out, moves, *rings, step, shortest, by_arc_length)
        return float(bound) if by_arc_length else 2.0

    return advance


def _cotangent(star: Stars, kinds: Kinds, rule: int) -> Advance:
    irregular = kinds[star.irregular] == IRREGULAR

    def advance(now: Floats, out: Floats, step: float) -> float:
        bound = star_step(now, out, kinds, star.offsets, star.neighbours, rule, step)
        if len(irregular):
            bound = max(bound, irregular_step(now, out, star, irregular, rule, step))
        return float(bound) if rule == BY_AREA else 2.0

    return advance


def _assembled(laplacian: Laplacian, moves: Kinds) -> Advance:
    stiffness, inverse_mass, bound = laplacian.stiffness, laplacian.inverse_mass, laplacian.spectral_bound()
    rings = Rings(stiffness.indptr.astype(np.int64), stiffness.indices.astype(np.int32))

    def advance(now: Floats, out: Floats, step: float) -> float:
        if step * bound > 2.0:
            return bound
        # The diagonal is among the entries and does no harm: it multiplies p_i - p_i.
        weighted_step(now, out, moves, *rings, stiffness.data, step * inverse_mass)
        return bound

    return advance


def _of_meshlab(moves: Kinds, rings: Rings, counts: Floats, own: float) -> Advance:
    """(own p + sum c_j p_j) / (own + sum c_j), the vertex itself counted once on surfaces and twice on borders."""
    totals = np.concatenate([[0.0], np.cumsum(counts)])
    shares = 1.0 / (totals[rings.offsets[1:]] - totals[rings.offsets[:-1]] + own)

    def advance(now: Floats, out: Floats, step: float) -> float:
        weighted_step(now, out, moves, *rings, counts, shares)
        return 2.0

    return advance


class MovingVertices(NamedTuple):
    """The vertices that move, by the neighbours that count for them."""

    surface: Kinds  # (n,) the kind of the star of those that move with their whole star, `NO_STAR` of all others
    #: (n,) the same of those that move with their neighbours on the border, and these of all n; None where none does
    curve: tuple[Kinds, Rings] | None


def moving_vertices(stars: Stars, border: BorderPolicy, movable: Bools | None) -> MovingVertices:
    """The vertices of a mesh that move, by the neighbours that count for them.

    Args:
        stars: the star of every vertex.
        border: what vertices on an edge with exactly one face do.
        movable: (n,) which vertices may move; None for all. The others are seen, and vertices that no face uses never move.

    Raises:
        FilterInputError: an unknown policy.
    """
    check_choice("border", border, BORDER_POLICIES)
    n = len(stars.kinds)
    edges = np.empty((0, 2), dtype=np.int32) if border == "free" else stars.border_edges()
    kinds = stars.kinds if movable is None else np.where(movable, stars.kinds, np.uint8(NO_STAR))
    if len(edges) == 0:
        return MovingVertices(kinds, None)
    on_border = mask_of(edges, n)
    inside, curve = np.where(on_border, np.uint8(NO_STAR), kinds), np.where(on_border, kinds, np.uint8(NO_STAR))
    if border == "fixed" or not curve.any():
        return MovingVertices(inside, None)
    rings = one_rings(edges, n)
    return MovingVertices(inside, (curve, Rings(rings.offsets, rings.neighbours)))

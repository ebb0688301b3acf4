"""Smoothing by an energy: the surface that trades the square of its curvature against the distance from where it was."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ..checks import ConvergenceError, FilterInputError, check_choice, check_positive
from ..execution import Progress, ignore_progress, rising, threads_for
from ..libraries import sparse
from ..mesh import Bools, Floats, bounding_box, check_mesh, normalised_mesh, spikes, worth_reordering
from ..operators import curve_laplacian
from ..topology import BORDER_POLICIES, BorderPolicy, border_edges
from .bending_energy import BendingEnergy
from .surface_operator import SurfaceOperator, evened_operator, surface_operator

# Between these fourth roots of weights, on a mesh of size 1, lies all that differs from a weight of infinity or of 0.
_SMALLEST_ROOT, _LARGEST_ROOT = 1e-6, 1e25


def weight_of_detail_size(detail_size: float) -> float:
    """The weight w = (2 pi / l)^4 with which `bilaplacian_smoothing` halves a wave of length l.

    Args:
        detail_size: l, in mesh units. Larger is smoother.

    Returns:
        w, in one over the fourth power of mesh units; 0 or infinity where no number is so small or large.
    """
    check_positive("detail_size", detail_size)
    with np.errstate(over="ignore", under="ignore"):
        return float((np.float64(2.0 * math.pi) / detail_size) ** 4)


def bilaplacian_smoothing(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    detail_size: float | None = None,
    weight: float | None = None,
    feature_weights: ArrayLike | None = None,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    on_irregular: Callable[[int], object] = lambda count: None,
    progress: Progress = ignore_progress,
) -> Floats:
    """The minimiser p' of sum_i A_i (W_i |L p'_i|^2 + w |p'_i - p_i|^2): (S M^-1 W S + w M) p' = w M p [nealen2006].

    A wave of frequency omega = 2 pi / l keeps w / (w + omega^4) of its amplitude: against an implicit step, longer waves keep
    more and shorter ones less. One linear system and no time to march; the area shrinks much less than by diffusion. L is the
    Laplace-Beltrami operator of the input, taken at the vertices inside the surface; S = -C with C its stiffness, M its mass.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        detail_size: l, in mesh units, the wavelength that comes out with half its amplitude: w = (2 pi / l)^4. Larger is
            smoother.
        weight: w, above 0, in one over the fourth power of mesh units, instead of `detail_size`. Larger stays closer to the
            input, which infinity returns.
        feature_weights: (n,) W, from 0, usually at most 1. Smaller smooths less: where W is 0 the surface may bend at no cost,
            and along a line of such vertices it keeps a ridge. See `feature_weights`. None is 1 everywhere.
        border: "fixed": border vertices stay. "along": the border is smoothed as a curve by the same energy first, then the
            interior between it. "free": border vertices follow the interior and their own old places.
        movable: (n,) bool, which vertices may move, None for all. The others stay and are seen by those that do.
        on_irregular: called with the number of vertices in components whose triangles are so uneven that the energy throws
            vertices out, if there are any: they are smoothed by their connectivity alone, see `evened_operator`.
        progress: called every few solver steps with the share that is done, which does not fall; may raise to stop. Up to 3 s
            pass between two calls at 100,000 vertices, while factors are made; less on larger meshes, which do without.

    Returns:
        (n, 3) float64. Vertices that do not move keep every bit. The others are solved for to about 1e-10 of the diagonal.

    Raises:
        FilterInputError: not a mesh, not exactly one of `detail_size` and `weight`, or a parameter out of range; or a vertex that
            would be moved by more than twice the diagonal.
        ConvergenceError: the equations cannot be solved.
    """
    points, triangles = check_mesh(vertices, faces)
    _check_weight(detail_size, weight)
    features = _checked_features(feature_weights, len(points))
    check_choice("border", border, BORDER_POLICIES)
    mesh = normalised_mesh(points, triangles, movable)
    if worth_reordering(mesh.cells, len(mesh)):
        mesh = mesh.by_place()
    moves = np.ones(len(mesh), dtype=np.bool_) if mesh.movable is None else mesh.movable
    if not moves.any() or len(triangles) == 0:
        progress(1.0)
        return points.copy()
    start, triangles, features = mesh.points, mesh.cells, features[mesh.used]
    w = _scaled_weight(detail_size, weight, mesh.scale)
    low, high = bounding_box(start)  # not of those that move, which may be one
    diagonal = float(np.linalg.norm(high - low))
    if diagonal == 0.0:
        progress(1.0)
        return points.copy()

    def minimiser(operator: SurfaceOperator, even: Bools) -> Floats:
        # A border vertex has no whole star to take a Laplacian on; without one, where nothing else holds a border, it is free.
        bending = np.where(at_border & ~(even & (border == "free")), 0.0, features / operator.mass)
        quadratic = BendingEnergy(operator.dirichlet, operator.mass, bending, w)
        return quadratic.minimiser(start, prescribed, inside, diagonal, rising(progress, 0.1, 1.0))

    edges = border_edges(triangles)
    at_border = np.zeros(len(start), dtype=np.bool_)
    at_border[edges] = True
    displacement = np.zeros_like(start)
    with threads_for(len(start)):
        if border == "along" and (at_border & moves).any():
            curve = curve_laplacian(start, edges, "laplace_beltrami")
            inverse = curve.inverse_mass
            mass = np.where(curve.mass > 0.0, curve.mass, 1.0)
            quadratic = BendingEnergy(sparse.csr_matrix(-curve.stiffness), mass, inverse * features, w)
            # A curve is done before much has happened on the surface.
            displacement = quadratic.minimiser(start, displacement, moves & at_border, diagonal, rising(progress, 0.0, 0.1))
        inside = moves if border == "free" else moves & ~at_border
        operator = surface_operator(start, triangles)
        even, prescribed = np.zeros(len(start), dtype=np.bool_), displacement
        thrown = ~even
        try:
            displacement = minimiser(operator, even)
            thrown = spikes(start, start + displacement, diagonal)
        except ConvergenceError:
            pass  # then nobody knows where the trouble is
        if thrown.any():
            operator, even = evened_operator(operator, triangles, thrown)
            displacement = minimiser(operator, even)
            on_irregular(int(even.sum()))
    progress(1.0)
    return mesh.restored(start + displacement)


def _check_weight(detail_size: float | None, weight: float | None) -> None:
    if (detail_size is None) == (weight is None):
        raise FilterInputError(f"give either detail_size or weight, got detail_size={detail_size} and weight={weight}")
    if detail_size is not None:
        check_positive("detail_size", detail_size)
    if weight is not None and weight != math.inf:
        check_positive("weight", weight, note=": without it nothing keeps the surface where it is")


def _scaled_weight(detail_size: float | None, weight: float | None, scale: float) -> float:
    """The weight on a mesh that is `scale` times as large, between two numbers that neither overflow nor vanish."""
    if detail_size is not None:
        scaled = max(float(detail_size) * float(scale), 1.0 / _LARGEST_ROOT)
        root = min(max(2.0 * math.pi / scaled, _SMALLEST_ROOT), _LARGEST_ROOT)
        return root**4
    assert weight is not None
    return min(max(math.sqrt(math.sqrt(weight)) / scale, _SMALLEST_ROOT), _LARGEST_ROOT) ** 4


def _checked_features(feature_weights: ArrayLike | None, n: int) -> Floats:
    if feature_weights is None:
        return np.ones(n)
    values = np.asarray(feature_weights, dtype=np.float64)
    if values.shape != (n,) or not (np.isfinite(values) & (values >= 0.0)).all():
        raise FilterInputError(f"feature_weights must be {n} finite values of at least 0, one a vertex, got shape {values.shape}")
    return values

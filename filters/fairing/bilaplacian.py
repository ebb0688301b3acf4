"""Bi-Laplacian smoothing: minimises squared curvature plus the weighted squared distance from the input [nealen2006]."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..checks import ConvergenceError, FilterInputError, check_choice, check_positive
from ..denoising.normal_filtering import filter_face_normals
from ..execution import Progress, ignore_progress, rising, threads_for
from ..geometry import angles_between
from ..libraries import sparse
from ..linear_solvers import (
    Cholesky,
    SmoothedAggregation,
    conjugate_gradients,
    laplacian_power,
    preconditioned_norm,
    refined_solution,
)
from ..mesh import Bools, Floats, Longs, check_mesh, mask_of, normalised_mesh, spikes, worth_reordering
from ..operators import curve_laplacian
from ..topology import BORDER_POLICIES, BorderPolicy, border_edges, face_adjacency
from .region import SurfaceOperator, evened_operator, surface_operator

# Limits of the fourth root of the weight w, for a mesh of size 1: a weight outside them has the effect of 0 or of infinity.
_SMALLEST_ROOT, _LARGEST_ROOT = 1e-6, 1e25
# A matrix of up to `_FACTORISED` rows is factorised if its least feature weight (free border: 0) is below `_EVEN` x the largest.
_EVEN, _FACTORISED = 0.05, 400_000
# A root mean square error below this share of the diagonal of a component does not count.
_ENOUGH = 1e-12
# Between refinements, conjugate gradients reduce the residual to the share `_INNER`, in at most `_MOST_ITERATIONS` steps.
_INNER, _MOST_ITERATIONS = 1e-7, 200
# Factors are quicker than multigrid up to `_QUICK_FACTORS` rows; up to `_MOST_ROWS` they take over if multigrid stalls.
_QUICK_FACTORS, _MOST_ROWS = 150_000, 3_000_000
# The range kernel of `feature_weights` keeps ridges of 45 degrees sharp and removes noise of a tenth of an edge length. A kernel
# twice as wide would remove noise of a fifth of an edge length, but blur such ridges.
_RANGE, _ITERATIONS = 0.25, 10
# The least feature weight: above 0, so that sharp ridges do not keep all their noise.
_LEAST = 1e-4
# Multigrid cycles for one inverse of H, see `InnerSolver`. With one cycle, detail sizes of many edges take twice the steps.
_CYCLES = 2


def weight_of_detail_size(detail_size: float) -> float:
    """Returns the weight w = (2 pi / l)^4 with which `bilaplacian_smoothing` halves a wave of length l.

    Args:
        detail_size: l, in mesh units. Larger is smoother.

    Returns:
        w, in one over the fourth power of mesh units; 0 or infinity if w is out of the range of numbers.
    """
    check_positive("detail_size", detail_size)
    with np.errstate(over="ignore", under="ignore"):
        return float((np.float64(2.0 * math.pi) / detail_size) ** 4)


def bilaplacian_smoothing(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    detail_size: float,
    feature_weights: ArrayLike | None = None,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    on_irregular: Callable[[int], object] = lambda count: None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Minimises sum_i A_i (W_i |L p'_i|^2 + w |p'_i - p_i|^2) over p': (S M^-1 W S + w M) p' = w M p [nealen2006].

    A wave of length 2 pi / omega keeps w / (w + omega^4) of its amplitude. Compared with an implicit step of diffusion, waves
    longer than l keep more, shorter waves less, and the area shrinks much less. L is the input's Laplace-Beltrami operator at
    inner vertices, C its stiffness and S = -C; A are vertex areas, M = diag(A).

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        detail_size: l, in mesh units, the wavelength that keeps half of its amplitude: w = (2 pi / l)^4. Larger is smoother.
        feature_weights: (n,) W, from 0, usually at most 1. Smaller smooths less: where W is 0 the surface may bend at no cost,
            and along a line of such vertices it keeps a ridge. See `feature_weights`. None is 1 everywhere.
        border: "fixed": border vertices stay. "along": the border is smoothed first, as a curve, by the same energy; then it
            stays while the interior is smoothed. "free": border vertices move with the interior, and stay near their old places.
        movable: (n,) bool, which vertices may move, None for all. Fixed vertices still count as neighbours.
        on_irregular: called if very uneven triangles make spikes or equations that cannot be solved. Then the components with
            spikes (or all) are smoothed by connectivity alone, see `evened_operator`; the argument is their number of vertices.
        progress: called every few solver steps with the share that is done, which does not fall; may raise to stop. At 100,000
            vertices, up to 3 s may pass between two calls.

    Returns:
        (n, 3) float64. Fixed vertices keep every bit. The others have an error of about 1e-10 of the diagonal.

    Raises:
        FilterInputError: not a mesh, a parameter out of range, or a vertex that would be moved by more than twice the diagonal.
        ConvergenceError: the equations cannot be solved.
    """
    points, triangles = check_mesh(vertices, faces)
    size = check_positive("detail_size", detail_size)
    features = _checked_features(feature_weights, len(points))
    check_choice("border", border, BORDER_POLICIES)
    mesh = normalised_mesh(points, triangles, movable)
    if worth_reordering(mesh.cells, len(mesh)):
        mesh = mesh.by_place()
    moves = np.ones(len(mesh), dtype=np.bool_) if mesh.movable is None else mesh.movable
    diagonal = mesh.diagonal if moves.any() and len(triangles) else 0.0
    start, triangles, features = mesh.points, mesh.cells, features[mesh.used]
    w = min(max(2.0 * math.pi / max(size * mesh.scale, 1.0 / _LARGEST_ROOT), _SMALLEST_ROOT), _LARGEST_ROOT) ** 4
    if diagonal == 0.0:
        progress(1.0)
        return points.copy()

    def minimiser(operator: SurfaceOperator, even: Bools) -> Floats:
        # A border vertex has no closed star for a Laplacian: bending costs 0 there, except on an evened component's free border.
        bending = np.where(at_border & ~(even & (border == "free")), 0.0, features / operator.mass)
        return BendingEnergy(operator.dirichlet, operator.mass, bending, w).minimiser(start, prescribed, inside, diagonal, report)

    report = rising(progress, 0.1, 1.0)  # for both solutions, so that the share does not fall
    edges = border_edges(triangles)
    at_border = mask_of(edges, len(start))
    displacement = np.zeros_like(start)
    with threads_for(len(start)):
        if border == "along" and (at_border & moves).any():
            curve = curve_laplacian(start, edges, "laplace_beltrami")
            mass = np.where(curve.mass > 0.0, curve.mass, 1.0)
            quadratic = BendingEnergy(sparse.csr_matrix(-curve.stiffness), mass, curve.inverse_mass * features, w)
            displacement = quadratic.minimiser(start, displacement, moves & at_border, diagonal, rising(progress, 0.0, 0.1))
        inside = moves if border == "free" else moves & ~at_border
        operator = surface_operator(start, triangles)
        even, prescribed = np.zeros(len(start), dtype=np.bool_), displacement
        spiky = ~even
        try:
            displacement = minimiser(operator, even)
            spiky = spikes(start, start + displacement, diagonal)
        except ConvergenceError:
            pass  # the failing component is unknown: all vertices count as spikes
        if spiky.any():
            operator, even = evened_operator(operator, triangles, spiky)
            displacement = minimiser(operator, even)
            on_irregular(int(even.sum()))
    progress(1.0)
    return mesh.restored(start + displacement)


def _checked_features(feature_weights: ArrayLike | None, n: int) -> Floats:
    if feature_weights is None:
        return np.ones(n)
    values = np.asarray(feature_weights, dtype=np.float64)
    if values.shape != (n,) or not (np.isfinite(values) & (values >= 0.0)).all():
        raise FilterInputError(f"feature_weights must be {n} finite values >= 0, one per vertex, got shape {values.shape}")
    return values


class BendingEnergy(NamedTuple):
    """The energy p'^T S B S p' + w (p' - p)^T M (p' - p), B = M^-1 W."""

    dirichlet: sparse.csr_matrix  # S
    mass: Floats  # the diagonal of M
    bending: Floats  # the diagonal of B
    weight: float  # w

    def minimiser(self, points: Floats, prescribed: Floats, free: Bools, diagonal: float, progress: Progress) -> Floats:
        """Returns the (n, 3) displacements of all vertices: the minimiser at free vertices, `prescribed` elsewhere."""
        if not free.any():
            return prescribed
        # Division by the sum of typical values of both terms keeps the system finite for every w.
        typical = float(self.mass[free].mean())
        unit = 1.0 / (1.0 / typical + self.weight * typical)
        columns = self.dirichlet if free.all() else sparse.csr_matrix(self.dirichlet[:, free])
        data = self.mass[free] * (self.weight * unit)
        bending = self.bending * unit
        matrix = sparse.csr_matrix(columns.T @ sparse.csr_matrix(sparse.diags_array(bending) @ columns))
        matrix.setdiag(matrix.diagonal() + data)
        start = points + prescribed
        moved = prescribed.copy()

        def residual(displacement: Floats) -> Floats:
            moved[free] = displacement
            force = laplacian_power(self.dirichlet, bending, 2, start, moved - prescribed)[free]
            return np.asarray(-force - data[:, None] * displacement)

        # Translating a component without fixed vertices does not bend it, so its mean displacement is 0.
        count, labels = sparse.csgraph.connected_components(self.dirichlet, directed=False)
        anchored = np.bincount(labels[~free], minlength=count) > 0
        loose = np.where(anchored[labels[free]], -1, labels[free])
        floating = FloatingComponents.of(loose, data, count)
        enough = _ENOUGH * _smallest_norm(start[free], data, labels[free], count)
        inner = columns if free.all() else columns[free]
        quick = InnerSolver(matrix, inner, self.mass[free], self.weight, unit, floating, enough, progress)
        # If the weights vary much, the preconditioner is poor, and factors of the whole matrix are faster.
        uneven = float((self.bending * self.mass)[free].min()) < _EVEN * float((self.bending * self.mass)[free].max())
        methods: list[InnerSolver | None] = [quick, None]
        if uneven and len(data) <= _FACTORISED:
            methods.reverse()
        for method in methods:
            try:
                moved[free] = refined_solution(
                    matrix, residual, np.zeros((len(data), 3)), extent=diagonal, solve=method, progress=progress
                ).values
                break
            except ConvergenceError:
                if method is methods[-1]:
                    raise
        return moved


def _smallest_norm(points: Floats, data: Floats, labels: Longs, count: int) -> float:
    """Returns the least energy norm of moving a component by its diagonal: sqrt(sum of its `data`) times the diagonal."""
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, labels, points)
    np.maximum.at(high, labels, points)
    sums = np.bincount(labels, data, count)
    has_mass = sums > 0.0
    return float((np.linalg.norm(high[has_mass] - low[has_mass], axis=1) * np.sqrt(sums[has_mass])).min())


class FloatingComponents(NamedTuple):
    """Components without a fixed vertex: their displacements have the mean 0."""

    labels: Longs  # (f,) the component of each free vertex, -1 if the component has a fixed vertex
    mass: Floats  # (f,) the mass of each free vertex
    masses: Floats  # (components + 1,) first the mass of all vertices with the label -1, then the mass of each component

    @classmethod
    def of(cls, labels: Longs, mass: Floats, count: int) -> FloatingComponents:
        masses = np.bincount(labels + 1, mass, count + 1)
        return cls(labels, mass, np.where(masses > 0.0, masses, 1.0))

    def centred(self, values: Floats) -> Floats:
        """Subtracts from the values the mass-weighted mean of each floating component."""
        if not (self.labels >= 0).any():
            return values
        return values - self._spread(self._sums(self.mass[:, None] * values))

    def balanced(self, forces: Floats) -> Floats:
        """The transpose of `centred`: subtracts the sum of the forces of each component, distributed by mass."""
        if not (self.labels >= 0).any():
            return forces
        return forces - self.mass[:, None] * self._spread(self._sums(forces))

    @property
    def _is_one(self) -> bool:
        return len(self.masses) == 2 and bool((self.labels >= 0).all())

    def _sums(self, values: Floats) -> Floats:
        if self._is_one:
            return np.asarray(values.sum(axis=0) / self.masses[1])
        sums = np.stack([np.bincount(self.labels + 1, column, len(self.masses)) for column in values.T], axis=1)
        sums[0] = 0.0
        return np.asarray(sums / self.masses[:, None])

    def _spread(self, means: Floats) -> Floats:
        return means if self._is_one else np.asarray(means[self.labels + 1])


class InnerSolver:
    """Solves the system to about seven digits, for iterative refinement; the first call prepares the preconditioner.

    The conjugate gradients are preconditioned by the inverse of H M^-1 H = S M^-1 S + 2 sqrt(w) S + w M, H = S + sqrt(w) M,
    scaled by `unit`. If W is 1, H M^-1 H lies between one and two times the energy's matrix for any w: a dozen steps are enough.
    As H is of second order, its factors take a third of the time and memory that factors of the energy's matrix take. On large
    meshes two multigrid cycles approximate the inverse of H; then three times the steps are needed, but half the memory.
    """

    def __init__(
        self,
        matrix: sparse.csr_matrix,
        dirichlet: sparse.csr_matrix,
        mass: Floats,
        weight: float,
        unit: float,
        floating: FloatingComponents,
        enough: float,
        progress: Progress,
    ) -> None:
        """Takes the energy's matrix; an error whose energy norm is below `enough` does not count."""
        self._matrix, self._dirichlet, self._masses, self._unit = matrix, dirichlet, mass, unit
        self._root, self._floating, self._enough, self._progress = math.sqrt(weight), floating, enough, progress
        #: H, kept while multigrid approximates its inverse; the factors of H do not need it
        self._half: sparse.csr_matrix | None = None
        self._inverse: Cholesky | SmoothedAggregation | None = None

    def __call__(self, right_side: Floats) -> Floats:
        b = self._floating.balanced(right_side)
        while True:
            target = max(_INNER * preconditioned_norm(self._matrix, b, self._precondition), self._enough)
            descent = conjugate_gradients(
                self._matrix,
                b,
                target=target,
                max_iterations=_MOST_ITERATIONS,
                precondition=self._precondition,
                progress=lambda share: self._progress(0.5 + 0.4 * share),
            )
            if descent.norm <= target or self._half is None or len(b) > _MOST_ROWS:
                return self._floating.centred(descent.values)
            self._half, self._inverse = None, Cholesky(self._half, progress=self._progress)

    def _prepare(self) -> None:
        size = 1.0 / (1.0 + self._root)
        half = sparse.csr_matrix(self._dirichlet * size)
        half.setdiag(half.diagonal() + self._masses * (self._root * size))
        self._between = (self._masses * (size * size / self._unit))[:, None]
        if half.shape[0] <= _QUICK_FACTORS:
            self._inverse = Cholesky(half, progress=self._progress)
        else:
            self._half, self._inverse = half, SmoothedAggregation(half, progress=lambda _: self._progress(0.0))

    def _precondition(self, residual: Floats) -> Floats:
        if self._inverse is None:
            self._prepare()
        half_way = self._solved(self._floating.balanced(residual))
        half_way *= self._between
        return self._floating.centred(self._solved(half_way))

    def _solved(self, b: Floats) -> Floats:
        if isinstance(self._inverse, SmoothedAggregation):
            return self._inverse.iterated(np.ascontiguousarray(b), _CYCLES)
        assert self._inverse is not None
        return self._inverse.solve(b)


def feature_weights(
    vertices: ArrayLike, faces: ArrayLike, *, feature_angle: float = 20.0, progress: Progress = ignore_progress
) -> Floats:
    """Returns W_i = max(1e-4, 1 / (1 + (a_i / a)^8)), a_i the largest angle between filtered normals across an edge at i.

    Weights for `bilaplacian_smoothing`. The face normals are filtered bilaterally [zheng2011], because curvature of a noisy
    surface is mostly noise. The filter removes noise of up to a tenth of an edge length. It keeps ridges and part of stronger
    noise. The 8th power makes the weight nearly 1 at half the angle a, and nearly 0 at twice a.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        feature_angle: a, in degrees, between 0 and 180. Smaller also keeps gentler ridges, and noise.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (n,) from 1e-4 to 1; 1 at vertices without two adjacent faces.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    if not 0.0 < feature_angle < 180.0:
        raise FilterInputError(f"feature_angle is {feature_angle}: it must be between 0 and 180 degrees")
    if not len(triangles):
        return np.ones(len(points))
    normals = filter_face_normals(points, triangles, range_sigma=_RANGE, normal_iterations=_ITERATIONS, progress=progress)
    pairs, shared = face_adjacency(triangles)
    angles = angles_between(normals[pairs[:, 0]], normals[pairs[:, 1]])
    sharpest = np.zeros(len(points))
    for end in (0, 1):
        np.maximum.at(sharpest, shared[:, end], angles)
    return _weights(sharpest / math.radians(feature_angle), 8)


def scalar_feature_weights(values: ArrayLike, *, half: float) -> Floats:
    """Returns W_i = max(1e-4, 1 / (1 + (v_i / half)^2)) for values such as curvatures or scalars that a user has painted.

    Args:
        values: (n,) finite values; their signs do not matter.
        half: the size of a value whose weight is 1/2, above 0. Smaller protects more vertices from smoothing.

    Raises:
        FilterInputError: values that are not finite, or a parameter out of range.
    """
    sizes = np.asarray(values, dtype=np.float64)
    if sizes.ndim != 1 or not np.isfinite(sizes).all():
        raise FilterInputError(f"values must be finite, one per vertex, got shape {sizes.shape}")
    check_positive("half", half)
    return _weights(sizes / half, 2)


def _weights(sizes: Floats, power: int) -> Floats:
    with np.errstate(over="ignore"):
        return np.maximum(_LEAST, 1.0 / (1.0 + np.abs(sizes) ** power))

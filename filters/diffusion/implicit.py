"""Implicit fairing [desbrun1999]: backward Euler steps of the diffusion equation, stable at any length."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..checks import ConvergenceError, FilterInputError, check_choice, check_finite, check_positive, check_whole_number
from ..execution import Progress, ignore_progress, part_of, threads_for
from ..geometry import vertex_normals_by_area
from ..libraries import optimize, sparse
from ..linear_solvers import SpdSolver
from ..mesh import Bools, Floats, Ints, Longs, NormalisedMesh, check_mesh, mask_of, normalised_mesh, worth_reordering
from ..operators import Laplacian, OperatorName, build_laplacian, curve_laplacian, mixed_voronoi_areas
from ..topology import BORDER_POLICIES, BorderPolicy, connected_components, proper_faces, stars

ImplicitOperator: TypeAlias = Literal["uniform", "inverse_length", "scale_dependent", "cotangent", "robust"]
#: C is the stiffness matrix, M the mass matrix. "linear": C and M of the input for all steps. "mean_curvature": both are built
#: anew for every step. "conformalized": C of the input, M built anew.
Flow: TypeAlias = Literal["linear", "mean_curvature", "conformalized"]
#: The root mean square error that the solver leaves in the coordinates, as a share of the bounding-box diagonal.
TOLERANCE = 1e-10
# Longer time steps are cut to this: the result is the same to rounding, and products with squared lengths do not overflow.
LONGEST_STEP = 1e100
_ROUNDING = 2.0**-47  # the relative rounding error of a diagonal entry
# A volume is a sum of signed tetrahedra. Below this share of the sum of their sizes it is rounding, as for a flat double sheet.
_LEAST_VOLUME = 1e-9
# The largest factor by which a component is scaled: larger factors would magnify the solver's error, 1e-10 diagonals, too much.
_LARGEST_GROWTH = 1e3
# How often `dimensions_restored` adds back the loss, the motion along normals; and how often it smooths the loss before that.
_TIMES, _PASSES = 2, 2
_SOLVES = _TIMES * _PASSES


def time_step_of_detail_size(detail_size: float, iterations: int = 1, *, keep_dimensions: bool = False) -> float:
    """Returns the time step t, in squared mesh units, with which implicit steps together halve waves of length `detail_size`.

    A wave of length l has the frequency omega = 2 pi / l. Each step multiplies its amplitude by s = 1 / (1 + t omega^2), so
    t = (2^(1 / iterations) - 1) (l / 2 pi)^2. With `keep_dimensions` the factor is 1 - (1 - s) (1 - s^2)^2, and t is longer.
    The factors hold for "cotangent" and "robust" on a surface that is smooth at this scale, and for "scale_dependent" on curves.

    Args:
        detail_size: l, in mesh units. Larger is smoother.
        iterations: number of steps. More steps cut off more sharply.
        keep_dimensions: as for `implicit_fairing`.

    Raises:
        FilterInputError: a parameter out of range.
    """
    check_positive("detail_size", detail_size)
    if not 1e-150 < detail_size < 1e150:
        raise FilterInputError(f"detail_size {detail_size:g} has a square out of the range of numbers: scale the mesh first")
    check_whole_number("iterations", iterations, least=1, note="; together they halve waves of the detail size")
    excess = math.expm1(math.log(2.0) / iterations)
    if keep_dimensions:
        excess = 1.0 / share_with_dimensions(1.0 / (1.0 + excess)) - 1.0
    return excess * (detail_size / (2.0 * math.pi)) ** 2


def implicit_fairing(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    operator: ImplicitOperator = "cotangent",
    time_step: float,
    iterations: int = 1,
    flow: Flow = "linear",
    preserve_volume: bool = False,
    keep_dimensions: bool = False,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Returns the surface after `iterations` diffusion steps of length t; each solves (M - t C) p' = M p [desbrun1999].

    A step multiplies modes with eigenvalue -k of L = M^-1 C by 1 / (1 + t k). As t grows, a closed component shrinks to its
    M-weighted centroid, which stays, and a component with fixed vertices tends to a discrete minimal surface. Every t is stable.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles. Without faces and with the operator "robust" the vertices are a point cloud.
        operator: "cotangent": the Laplace-Beltrami operator with mixed Voronoi areas. It moves vertices along the normal and does
            not depend on the triangulation; obtuse triangles are fine, and components of triangles without area stay as they
            are. "robust": the same for slivers, non-manifold meshes and point clouds. "scale_dependent", "inverse_length" and
            "uniform" depend on the triangulation; see `build_laplacian`.
        time_step: t, from 0. Larger is smoother. In squared mesh units, or without a unit for "uniform" and "inverse_length"; see
            `time_step_of_detail_size`.
        iterations: number of steps. n steps of length t cut off more sharply than one of length n t.
        flow: "linear" keeps the operator of the input, which is quickest. "mean_curvature" follows the surface: in short
            steps of total time T a sphere's radius r becomes sqrt(r^2 - 4 T); thin parts pinch off. "conformalized" keeps angles
            of the input as weights: no necks pinch off, and closed surfaces without handles tend to a sphere [kazhdan2012].
        preserve_volume: after every step, scale each component about the centroid of its surface back to its volume. This needs
            a coherently oriented component without border whose vertices may all move; other components are not scaled. Not for
            point clouds.
        keep_dimensions: after every step, undo the part of the motion along the normals that neighbours share, on open surfaces
            too. Balls keep their radius and limbs their thickness; see `dimensions_restored`. Not for point clouds.
        border: "fixed": border vertices stay. "along": first a step of the same t smooths the border as a curve, see
            `curve_laplacian`; then the interior is solved with the new border prescribed. Together these two parts are the
            backward Euler step of the flow in which border vertices depend only on border neighbours. "free": border vertices are
            like any other, and the border shrinks.
        movable: (n,) bool, which vertices may move, None for all. Fixed vertices still count as neighbours.
        progress: called every few solver steps with the share that is done; may raise to stop.

    Returns:
        (n, 3) float64. Fixed vertices keep every bit: those not `movable` or on a fixed border, and those that no face of a mesh
        uses. All others have an M-weighted root mean square error of about 1e-10 of the bounding-box diagonal, and up to 1e-9 if
        t is more than a million squared edges. Deterministic, for any number of threads.

    Raises:
        FilterInputError: not a mesh, a parameter out of range, or a volume that nearly vanishes and cannot be preserved.
        ConvergenceError: the equations cannot be solved.
    """
    points, triangles = check_mesh(vertices, faces)
    check_choice("operator", operator, ImplicitOperator)
    check_choice("flow", flow, Flow)
    check_choice("border", border, BORDER_POLICIES)
    check_finite("time_step", time_step, least=0.0)
    steps = check_whole_number("iterations", iterations, least=0)
    needing = {f"operator {operator!r}": operator != "robust", "keep_dimensions": keep_dimensions}
    for name, is_on in (needing | {"preserve_volume": preserve_volume}).items():
        if is_on and len(points) and not len(triangles):
            raise FilterInputError(f"{name} needs triangles and there are none; for a point cloud take operator 'robust' alone")
    mesh = normalised_mesh(points, triangles, movable)
    if operator != "robust" and worth_reordering(mesh.cells, len(mesh)):
        mesh = mesh.by_place()
    t = time_step if operator in ("uniform", "inverse_length") else time_step * mesh.scale * mesh.scale
    with threads_for(len(mesh)):
        solves = (steps if flow == "linear" else 1) * (1 + _SOLVES * keep_dimensions)
        process = _Flow(mesh, "laplace_beltrami" if operator == "cotangent" else operator, t, solves, flow, border)
        volumes = enclosed_volumes(mesh.points, mesh.cells, process.components, mesh.movable) if preserve_volume else None
        now = mesh.points
        for done in range(steps):
            part = part_of(progress, done / steps, (done + 1) / steps)
            if keep_dimensions:
                smooth = process.step(now, part_of(part, 0.0, 0.6))
                now = dimensions_restored(now, smooth, mesh.cells, process.smoothed, part_of(part, 0.6, 1.0))
            else:
                now = process.step(now, part)
            if volumes is not None:
                now = restore_volumes(now, volumes)
            progress((done + 1) / steps)
    return mesh.restored(now)


class _Flow:
    """Time steps of one length on one mesh: builds C and M as the `Flow` requires, and solves."""

    def __init__(
        self, mesh: NormalisedMesh, operator: OperatorName, time_step: float, solves: int, flow: Flow, border: BorderPolicy
    ) -> None:
        points, self._faces = mesh.points, mesh.cells
        self._operator, self._time_step, self._solves, self._flow = operator, time_step, solves, flow
        self._diagonal = mesh.diagonal
        self._border_edges = stars(self._faces, len(points)).border_edges()
        self._along = border == "along" and len(self._border_edges) > 0
        on_border = mask_of(self._border_edges, len(points)) & (border != "free")
        fixed = np.zeros(len(points), dtype=np.bool_) if mesh.movable is None else ~mesh.movable
        self._fixed, self._fixed_on_curve = fixed | on_border, fixed | ~on_border
        self.components = connected_components(self._faces, len(points))[0]
        self._curve: Laplacian | None = None
        self._surface: Laplacian | None = None
        self._systems: list[BackwardEulerStep] = []

    def step(self, points: Floats, progress: Progress) -> Floats:
        if not self._systems or self._flow != "linear":
            self._systems = self._build(points)
        return self.smoothed(points, progress)

    def smoothed(self, points: Floats, progress: Progress) -> Floats:
        """Applies one step to (n, d) coordinates or values at the vertices, with the operators of the last `step`."""
        moved: Floats | None = None
        count = len(self._systems)
        for k, system in enumerate(self._systems):
            part = part_of(progress, k / count, (k + 1) / count)
            moved = system.displacement(points, moved, diagonal=self._diagonal, progress=part)
        return points if moved is None else points + moved

    def _build(self, points: Floats) -> list[BackwardEulerStep]:
        systems = []
        t, solves = self._time_step, self._solves
        if self._along:
            self._curve = self._updated(self._curve, curve_laplacian(points, self._border_edges, self._operator))
            components = self._curve.components()
            systems.append(BackwardEulerStep(self._curve, t, fixed=self._fixed_on_curve, components=components, solves=solves))
        if self._flow == "conformalized" and self._surface is not None and self._operator == "laplace_beltrami":
            # Does the same as `_updated`, without building a stiffness that is not used.
            self._surface = Laplacian(self._surface.stiffness, mixed_voronoi_areas(points, self._faces))
        else:
            self._surface = self._updated(self._surface, build_laplacian(points, self._faces, self._operator))
        components = self.components if len(self._faces) else self._surface.components()
        systems.append(BackwardEulerStep(self._surface, t, fixed=self._fixed, components=components, solves=solves))
        return systems

    def _updated(self, previous: Laplacian | None, new: Laplacian) -> Laplacian:
        if previous is None or self._flow == "mean_curvature":
            return new
        return Laplacian(previous.stiffness, new.mass)


class BackwardEulerStep:
    """Solves (M - t C) p' = M p for the displacement d = p' - p: (M - t C) d = t C p.

    Divided by 1 + t, the matrix is a mean of M and -C and stays finite for every t. It is positive definite if each component has
    a fixed vertex or mass. A component without fixed vertices floats: C ignores its translation, so for large t the matrix is
    nearly singular. But its equations add up to sum_i M_i d_i = 0. The solution is shifted to satisfy this: the centroid stays.

    The error e satisfies sum_i M_i |e_i|^2 <= ||e||_A^2, with ||e||_A the energy norm of A = M - t C, because -C is semidefinite.
    The solver reduces ||e||_A to `TOLERANCE` times diagonal sqrt(sum_i M_i), the norm of a shift by the bounding-box diagonal.
    """

    def __init__(self, laplacian: Laplacian, time_step: float, *, fixed: Bools, components: Ints, solves: int = 1) -> None:
        """Takes L on n vertices, t in the unit of 1 / L, and the number of solves; `components` are labels from 0, -1 for none.

        The displacement of the (n,) `fixed` vertices is prescribed. So is that of vertices whose edges all have weight 0, and of
        components without mass, which the equation does not determine.
        """
        t = min(time_step, LONGEST_STEP)
        self._stiffness, self._stiffness_share = laplacian.stiffness, t / (1.0 + t)
        coupled = (components >= 0) & (laplacian.stiffness.diagonal() < 0.0)
        labels = np.where(coupled, components, 0)
        masses = np.bincount(labels, weights=laplacian.mass * coupled, minlength=1)
        free = coupled & ~fixed & (masses[labels] > 0.0)
        self._free = slice(None) if free.all() else np.flatnonzero(free)
        self._mass, self._solves = laplacian.mass[self._free] / (1.0 + t), solves
        self._floating = _Floating.among(labels[self._free], labels[coupled & ~free], self._mass)
        self._solver = self._assemble() if len(self._mass) else None

    def displacement(self, points: Floats, prescribed: Floats | None, *, diagonal: float, progress: Progress) -> Floats:
        """Returns the (n, d) displacement of (n, d) points; that of fixed points is `prescribed`, or 0 if this is None."""
        start = points if prescribed is None else points + prescribed
        extent = float(np.ptp(start, axis=0).max()) if self._solver else 0.0
        if self._solver is None or extent <= TOLERANCE * diagonal:
            # No vertex may move, or the surface is already a point, to rounding.
            return np.zeros_like(points) if prescribed is None else prescribed
        try:
            return self._solve(self._solver, start, prescribed, extent, diagonal, progress)
        except ConvergenceError:
            # Slivers have large weights of both signs, whose rounding makes the matrix indefinite. Without the negative weights
            # the matrix is diagonally dominant, and so semidefinite.
            positive = without_negative_weights(self._stiffness)
            if positive is self._stiffness:
                raise
            self._stiffness = positive
            self._solver = self._assemble()
            return self._solve(self._solver, start, prescribed, extent, diagonal, progress)

    def _assemble(self) -> SpdSolver:
        """Assembles A = M - t C, divided by 1 + t."""
        stiffness = self._stiffness
        if not isinstance(self._free, slice):
            stiffness = stiffness[self._free][:, self._free]
        entries = stiffness.data * -self._stiffness_share, stiffness.indices, stiffness.indptr
        matrix = sparse.csr_matrix(entries, shape=stiffness.shape)
        # Raising the diagonal by its rounding error outweighs the rounding errors of the row: A stays positive definite.
        matrix.setdiag(matrix.diagonal() * (1.0 + _ROUNDING) + self._mass)
        return SpdSolver(matrix, solves=self._solves)

    def _solve(
        self, solver: SpdSolver, start: Floats, prescribed: Floats | None, extent: float, diagonal: float, progress: Progress
    ) -> Floats:
        force = (self._stiffness_share * (self._stiffness @ start))[self._free]
        reference = diagonal * float(np.sqrt(self._mass.sum()))
        moved = solver.solve(force, tolerance=TOLERANCE, reference=reference, progress=progress).values
        moved -= self._floating.means(moved, self._mass)
        # Diffusion moves no point out of the bounding box, except a little where weights are negative.
        if not np.abs(moved).max() <= 2.0 * extent:
            raise ConvergenceError("the solution leaves the bounding box: the matrix is not positive definite to rounding")
        if isinstance(self._free, slice):
            return moved
        displacement = np.zeros_like(start) if prescribed is None else prescribed.copy()
        displacement[self._free] = moved
        return displacement


def without_negative_weights(stiffness: sparse.csr_matrix) -> sparse.csr_matrix:
    """Returns C with negative weights set to 0, and a diagonal with which rows sum to 0; C itself if no weight is negative."""
    rows = np.repeat(np.arange(stiffness.shape[0]), np.diff(stiffness.indptr))
    negative = (stiffness.data < 0.0) & (stiffness.indices != rows)
    if not negative.any():
        return stiffness
    positive = stiffness.copy()
    positive.data[negative] = 0.0
    positive.setdiag(0.0)
    positive.setdiag(-np.asarray(positive.sum(axis=1)).ravel())
    return positive


class _Floating(NamedTuple):
    """The components of the free vertices; those without fixed vertices float."""

    component: Longs  # (f,) the component of every free vertex, from 0
    weight: Floats  # one over the mass of each component, 0 for those with a fixed vertex

    @classmethod
    def among(cls, free_labels: Ints, fixed_labels: Ints, mass: Floats) -> _Floating:
        labels, component = np.unique(free_labels, return_inverse=True)
        total = np.bincount(component, weights=mass, minlength=len(labels))
        floats = (total > 0.0) & ~np.isin(labels, fixed_labels)
        return cls(component, np.divide(1.0, total, out=np.zeros(len(labels)), where=floats))

    def means(self, values: Floats, mass: Floats) -> Floats:
        """(f, d) the mass-weighted mean of the values over each free vertex's component; 0 for components with a fixed vertex."""
        weighted = mass[:, None] * values
        if len(self.weight) == 1:
            return np.broadcast_to(weighted.sum(axis=0) * self.weight[0], values.shape)
        sums = [np.bincount(self.component, weights=column, minlength=len(self.weight)) * self.weight for column in weighted.T]
        return np.column_stack(sums)[self.component]


class Volumes(NamedTuple):
    """The components that enclose a volume."""

    faces: Ints  # (f, 3) their triangles
    component: Longs  # (f,) the component of each triangle, from 0
    vertex_component: Longs  # (n,) the component of each vertex, -1 outside of these components
    volumes: Floats  # the signed volume of each component, in the cubed unit of the points


def enclosed_volumes(points: Floats, faces: Ints, components: Ints, movable: Bools | None) -> Volumes:
    """Measures the volumes of the closed components that have only movable vertices.

    A component is closed if its faces run through every edge equally often in both directions; edges may be non-manifold.
    """
    proper = faces[proper_faces(faces)]
    n, count = len(points), int(components.max(initial=-1)) + 1
    start, end = proper.ravel(), np.roll(proper, -1, axis=1).ravel()
    runs = np.where(start < end, 1, -1), (np.minimum(start, end), np.maximum(start, end))
    balance = sparse.coo_matrix(runs, shape=(n, n)).tocsr().tocoo()
    whole = np.ones(count, dtype=np.bool_)
    whole[components[balance.row[balance.data != 0]]] = False
    if movable is not None:
        whole[components[~movable & (components >= 0)]] = False
    labels = np.where(whole, np.cumsum(whole) - 1, -1)
    vertex_component = np.where(components >= 0, labels[components], -1) if count else np.full(n, -1)
    chosen = proper[vertex_component[proper[:, 0]] >= 0]
    enclosing = Volumes(chosen, vertex_component[chosen[:, 0]], vertex_component, np.zeros(int(whole.sum())))
    return enclosing._replace(volumes=_measure(points, enclosing)[0])


def restore_volumes(points: Floats, original: Volumes) -> Floats:
    """Scales each component whose original volume is not 0 back to this volume, about the centroid of its surface."""
    volumes, centroids = _measure(points, original)
    former = original.volumes
    with np.errstate(divide="ignore", invalid="ignore"):
        growth = np.where(former == 0.0, 1.0, np.cbrt(former / volumes))
    lost = np.flatnonzero(~((growth > 0.0) & (growth <= _LARGEST_GROWTH)))
    if len(lost):
        left = volumes[lost[0]] / former[lost[0]]
        raise FilterInputError(
            f"preserve_volume: a step leaves only {left:.3g} of the volume of a closed component, too little to scale it back "
            f"({len(lost)} such components): take a shorter time step, or more steps with flow='conformalized'"
        )
    inside = original.vertex_component >= 0
    component = original.vertex_component[inside]
    result = points.copy()
    result[inside] += (points[inside] - centroids[component]) * (growth[component] - 1.0)[:, None]
    return result


def _measure(points: Floats, volumes: Volumes) -> tuple[Floats, Floats]:
    """Returns the volumes, 0 if they are only rounding, and the centroids of the surfaces."""

    def per_component(values: Floats) -> Floats:
        return np.asarray(np.bincount(volumes.component, weights=values, minlength=len(volumes.volumes)), dtype=np.float64)

    a, b, c = (points[volumes.faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    total = np.maximum(per_component(areas), np.finfo(float).tiny)
    middles = (a + b + c) / 3.0
    centroids = np.column_stack([per_component(areas * middles[:, k]) / total for k in range(3)])
    # Relative to the centroid, because far from the origin the parts would be large and cancel.
    centre = centroids[volumes.component]
    parts = np.einsum("ij,ij->i", a - centre, np.cross(b - centre, c - centre)) / 6.0
    sums = per_component(parts)
    return np.where(np.abs(sums) > _LEAST_VOLUME * per_component(np.abs(parts)), sums, 0.0), centroids


def dimensions_restored(
    before: Floats, after: Floats, faces: Ints, smoothed: Callable[[Floats, Progress], Floats], progress: Progress
) -> Floats:
    """Undoes, along the normals, the part of a smoothing step's motion that neighbouring vertices share.

    The loss is h = (p - p') . n, with the normals n of the smoothed points p'. Lost shape makes h vary slowly, lost noise makes h
    change its sign from vertex to vertex. So S, the smoothing of the step, removes the noise from h: p'' = p' + S(S(h)) n, done
    twice, as in twicing [tukey1977]. A sphere, whose h is constant, gets its radius back. If S leaves the share s of a wave on a
    plane, the share 1 - (1 - s) (1 - s^2)^2 remains.

    `smoothed` is S for (n, 1) values. A vertex stays if the step has not moved it and S leaves its loss at 0.
    """
    for time in range(_TIMES):
        normals = vertex_normals_by_area(after, faces)
        loss = np.einsum("ij,ij->i", before - after, normals)[:, None]
        for solve in range(time * _PASSES, (time + 1) * _PASSES):
            loss = smoothed(loss, part_of(progress, solve / _SOLVES, (solve + 1) / _SOLVES))
        after = after + loss * normals
    return after


def share_with_dimensions(amplitude: float) -> float:
    """Solves 1 - (1 - s) (1 - s^2)^2 = amplitude for s, the share of a wave that a step leaves before dimensions are restored."""
    return float(optimize.brentq(lambda s: 1.0 - (1.0 - s) * (1.0 - s**_PASSES) ** _TIMES - amplitude, 0.0, 1.0, xtol=1e-15))

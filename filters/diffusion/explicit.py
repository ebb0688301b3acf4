"""Explicit smoothing: Euler steps of the diffusion equation, Taubin's pairs of steps, and the removal of spikes."""

import math
from collections.abc import Callable
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..checks import FilterInputError, UnstableStepError, check_choice, check_finite, check_positive, check_whole_number
from ..execution import Progress, ignore_progress, threads_for
from ..geometry import angles_between, face_normals
from ..libraries import sparse
from ..mesh import Bools, Floats, NormalisedMesh, Whole, check_mesh, mask_of, normalised_mesh, worth_reordering
from ..operators import OperatorName
from ..topology import BorderPolicy, border_edges, border_vertices, edge_face_counts, edges, faces_across, stars
from .stencil import Advance, UpdateRule, explicit_stencil

#: The operators without a unit. Their spectrum lies in [-2, 0], so that lambda, mu and the pass band mean the same on all meshes.
TaubinOperator: TypeAlias = Literal["uniform", "inverse_length", "cotangent"]
_SPIKE_PASSES = 10  # The largest number of passes to remove spikes. A pass removes only the highest spike of a one-ring.
#: One iteration. Its arguments are its number (from 0), the points, and an array to overwrite that already holds the fixed
#: vertices. It returns the new points and the array that the next iteration may overwrite.
Iteration: TypeAlias = Callable[[int, Floats, Floats], tuple[Floats, Floats]]


def explicit_smoothing(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    operator: OperatorName = "uniform",
    step: float = 0.5,
    iterations: int = 10,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    update: UpdateRule = "euler",
    whole: Whole | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Repeats p_i <- p_i + step (L p)_i for all vertices at once [taubin1995, desbrun1999].

    Each step multiplies the mode of eigenvalue -k of L by 1 - step k. Closed surfaces shrink, unlike with `taubin_fairing`.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles. Without faces and with the operator "robust" the vertices are a point cloud.
        operator: the Laplace operator L; see `build_laplacian`. Weights are computed anew for every step, except for "robust".
        step: larger is smoother. For "uniform", "inverse_length" and "cotangent" the share of the way to the neighbours' mean,
            above 0 and at most 1. For the other operators a time in squared mesh units, stable up to 2 / rho with rho the largest
            eigenvalue of -L. The check replaces rho by Gershgorin's upper bound; for "laplace_beltrami" by the largest
            eigenvalue of a single triangle [irons1971] if that is smaller.
        iterations: number of steps. More steps smooth more.
        border: what border vertices do; see `BorderPolicy`.
        movable: (n,) bool, which vertices may move, None for all. Fixed vertices still count as neighbours.
        update: "euler", the equation above; or "meshlab", the rule of MeshLab's Laplacian Smooth, for "uniform" and
            "cotangent": p_i <- (p_i + sum_j w_ij p_j) / (1 + sum_j w_ij) with w_ij the number of faces at the edge, or the sum of
            the cotangents opposite it; along borders (2 p_i + p_prev + p_next) / 4. `step` is not used. Negative cotangents are
            kept, but a vertex stays if its w_ij sum to 0 or less.
        whole: the mesh of which `faces` are a part; None if they are all of it. If vertices and faces keep its order, a
            vertex with `iterations` rings of faces around it gets the same bits as in the whole. For "uniform" and "cotangent".
        progress: called after every step.

    Returns:
        (n, 3) float64. Fixed vertices keep every bit: those without a face (not in clouds), not `movable`, or on a fixed border.
        Deterministic, for any number of threads.

    Raises:
        FilterInputError: not a mesh, no faces (except for "robust"), too few points in a cloud, a parameter out of range.
        UnstableStepError: at the start or after some shrinking, the step exceeds the largest stable step, which the error names.
    """
    normalised = operator in get_args(TaubinOperator)
    if update == "euler":
        check_positive("step", step, most=1.0 if normalised else None, note=f", for the operator {operator!r}")
    surface = explicit_surface(vertices, faces, operator, border, movable, iterations, whole, steps=1, update=update)
    scale = surface.mesh.scale
    scaled = step if normalised else step * scale * scale

    def euler(done: int, now: Floats, free: Floats) -> tuple[Floats, Floats]:
        bound = surface.advance(now, free, scaled)
        if not normalised and scaled * bound > 2.0:
            when = "" if done == 0 else f" after {done} iterations, which have shrunk the surface"
            raise UnstableStepError(
                f"step {step:g} is longer than the largest stable one of operator {operator!r} on this mesh, {{}} squared "
                f"mesh units{when}: take that or less (the shortest edges and the thinnest triangles decide; repairing them "
                "helps), or implicit fairing, which is stable for any step",
                largest_stable=2.0 / bound / scale / scale,
            )
        return free, now

    return surface.iterated(euler, iterations, progress)


class ExplicitSurface(NamedTuple):
    """A mesh prepared for explicit iterations."""

    mesh: NormalisedMesh  # normalised, its points in the order of the stencil
    advance: Advance

    def iterated(self, iteration: Iteration, iterations: int, progress: Progress) -> Floats:
        now = self.mesh.new_points()
        free = now.copy()
        with threads_for(len(now)):
            for done in range(iterations):
                now, free = iteration(done, now, free)
                progress((done + 1) / iterations)
        del free  # makes room for the result
        return self.mesh.restored(now)


def explicit_surface(
    vertices: ArrayLike,
    faces: ArrayLike,
    operator: OperatorName,
    border: BorderPolicy,
    movable: ArrayLike | None,
    iterations: int,
    whole: Whole | None,
    *,
    steps: int,
    update: UpdateRule = "euler",
) -> ExplicitSurface:
    """Prepares a mesh for iterations of `steps` steps each, and reorders it if that is faster."""
    points, triangles = check_mesh(vertices, faces)
    count = check_whole_number("iterations", iterations, least=0)
    mesh = normalised_mesh(points, triangles, movable, whole)
    # No reordering for "robust", which a library assembles in the order of the faces. A cotangent step counts as two sweeps.
    sweeps = steps * count * (2 if operator in ("cotangent", "laplace_beltrami") else 1)
    if operator != "robust" and worth_reordering(mesh.cells, len(mesh), sweeps):
        mesh = mesh.by_place()
    star = stars(mesh.numbered_cells(), len(mesh), names=mesh.order)
    with threads_for(len(mesh)):
        return ExplicitSurface(mesh, explicit_stencil(mesh, star, operator, border=border, update=update))


def taubin_fairing(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    operator: TaubinOperator = "uniform",
    step: float = 0.5,
    mu: float = -0.53,
    pass_band: float | None = None,
    iterations: int = 10,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    whole: Whole | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Replaces p by (1 + mu L)(1 + step L) p, `iterations` times: a low-pass filter that does not shrink [taubin1995].

    `transfer_function` gives the factor on a mode of eigenvalue -k of L: about 1 below the pass band k_PB = 1/step + 1/mu, and
    falling above it. With the operator "uniform" this is MeshLab's Taubin Smooth, with two exceptions. MeshLab
    includes a border vertex itself in the mean of its two border neighbours, and so moves it two thirds as far as "along". At a
    non-manifold edge MeshLab counts each end as a neighbour of the other end once per face.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        operator: the Laplace operator L; weights are computed anew for every step.
        step: lambda, above 0. Larger is smoother.
        mu: the step back, below -step. A mu nearer to -step narrows the pass band, and so smooths more.
        pass_band: k_PB, above 0, below 1/step, at most 2; sets mu = 1 / (k_PB - 1/step). Smaller is smoother; usual: 0.01 to 0.1.
        iterations: number of pairs of steps. More pairs damp more, but only above the pass band.
        border: what border vertices do; see `BorderPolicy`.
        movable: (n,) bool, which vertices may move, None for all. Fixed vertices still count as neighbours.
        whole: the mesh of which `faces` are a part; None if they are all of it. If vertices and faces keep its order, a
            vertex with 2 `iterations` rings of faces around it gets the same bits as in the whole. For "uniform" and "cotangent".
        progress: called after every pair of steps.

    Returns:
        (n, 3) float64. Fixed vertices keep every bit: those without a face, those not `movable`, those on a fixed border.
        Deterministic, for any number of threads.

    Raises:
        FilterInputError: not a mesh, no faces, or a parameter out of range.
        UnstableStepError: (1 - step k)(1 - mu k) is below -1 for k = 2 (k = 3/2 with "uniform" on a whole mesh whose edges all
            have two faces), so the finest detail would grow. The error names the largest stable step for the same mu / step.
    """
    check_choice("operator", operator, TaubinOperator)
    try:
        mu = checked_mu(step, mu, pass_band)
    except UnstableStepError:
        if operator != "uniform" or whole is not None or not (edge_face_counts(check_mesh(vertices, faces)[1])[1] == 2).all():
            raise
        # If every edge has two triangles, -L is a mean over triangles, each with eigenvalues of at most 3/2.
        mu = checked_mu(step, mu, pass_band, largest_eigenvalue=1.5)
    surface = explicit_surface(vertices, faces, operator, border, movable, iterations, whole, steps=2)

    def back_and_forth(_: int, now: Floats, free: Floats) -> tuple[Floats, Floats]:
        surface.advance(now, free, step)
        surface.advance(free, now, mu)
        return now, free

    return surface.iterated(back_and_forth, iterations, progress)


def meshlab_taubin_smooth(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    step: float = 0.5,
    mu: float = -0.53,
    iterations: int = 10,
    whole: Whole | None = None,
) -> Floats:
    """Reproduces MeshLab's Taubin Smooth up to rounding, on meshes without edges of more than two faces [taubin1995].

    Like MeshLab it rounds the factors to single precision. A border vertex with b border edges moves b / (b + 1) times as far as
    in `taubin_fairing`. Arguments and results are as there, but `step` and `mu` are not checked.
    """
    surface = explicit_surface(vertices, faces, "uniform", "along", None, iterations, whole, steps=2)
    border, count = np.unique(border_edges(surface.mesh.numbered_cells()), return_counts=True)
    share = (count / (count + 1.0))[:, None]

    def back_and_forth(_: int, now: Floats, free: Floats) -> tuple[Floats, Floats]:
        for factor in (step, mu):
            surface.advance(now, free, float(np.float32(factor)))
            free[border] = now[border] + share * (free[border] - now[border])
            now, free = free, now
        return now, free

    return surface.iterated(back_and_forth, iterations, ignore_progress)


def checked_mu(step: float, mu: float, pass_band: float | None, *, largest_eigenvalue: float = 2.0) -> float:
    """Returns mu for `pass_band` if given, else `mu`; refuses a step that would amplify the mode of `largest_eigenvalue`."""
    check_positive("step", step)
    if pass_band is not None:
        mu = mu_of_pass_band(pass_band, step)
    if not (math.isfinite(mu) and mu < -step):
        raise FilterInputError(
            f"mu is {mu}: it must be below -step, {-step}, as the step back is the longer one, for example {-1.06 * step:g}"
        )
    if 1.0 / step + 1.0 / mu > 2.0 + 1e-9:  # the pass band reaches beyond all frequencies
        nearer = mu_of_pass_band(0.1, step)
        raise FilterInputError(
            f"step {step:g} with mu {mu:g} makes all details grow: take a mu nearer to -step, for example {nearer:.4g} "
            "(pass_band=0.1)"
        )
    largest = largest_stable_step(mu / step, largest_eigenvalue)
    if step > largest:
        raise UnstableStepError(
            f"step {step:g} with mu {mu:g} makes the finest detail grow: take a step of at most {{}} and mu in proportion",
            largest_stable=largest,
        )
    return mu


def transfer_function(k: ArrayLike, *, step: float, mu: float, iterations: int) -> NDArray[np.float64]:
    """Returns ((1 - step k)(1 - mu k))^iterations, the factor of a mode of eigenvalue -k [taubin1995].

    Args:
        k: any shape; from 0 to 2 for a normalised operator.
        step: lambda.
        mu: the step back; 0 gives the response of explicit steps.
        iterations: number of pairs of steps.
    """
    values = np.asarray(k, dtype=np.float64)
    return ((1.0 - step * values) * (1.0 - mu * values)) ** iterations


def mu_of_pass_band(pass_band: float, step: float) -> float:
    """Returns mu = 1 / (k_PB - 1/step), for which `transfer_function` is 1 at k_PB; k_PB is above 0 and below 1/step."""
    if not 0.0 < pass_band < 1.0 / step:
        raise FilterInputError(
            f"pass_band is {pass_band}: it must be above 0, below 1/step = {1.0 / step:g}; 0.01 to 0.1 is usual"
        )
    return 1.0 / (pass_band - 1.0 / step)


def largest_stable_step(ratio: float, largest_eigenvalue: float) -> float:
    """The largest step for which (1 - step k)(1 - mu k) >= -1 at the largest eigenvalue k of -L, with mu = ratio * step.

    With r = -ratio, x = step k is the positive root of r x^2 + (1 - r) x - 2 = 0.
    """
    r = -ratio
    return (r - 1.0 + math.sqrt((r - 1.0) ** 2 + 8.0 * r)) / (2.0 * r * largest_eigenvalue)


def remove_spikes(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    steepness: float = 1.5,
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> tuple[Floats, Bools]:
    """Moves the tips of spikes to the mean m of their neighbours.

    With the neighbours j of vertex i, m = mean p_j and s^2 = mean |p_j - m|^2, vertex i is the tip of a spike if
    |p_i - m| > k s, with k the `steepness`, and if no neighbour is farther from its own mean m than vertex i. It is no
    tip if a move to m raises the sum of the angles between its faces and the faces across the edges opposite to it, as at the
    apex of a cone. All tips move at once; this repeats until none is left, at most ten times. A pyramid over a regular polygon
    has the steepness height / radius: k = 1.5 is a tip with an angle of 67 degrees between opposite edges.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        steepness: k, from 0. Larger removes only thinner spikes; below 1, corners of cubes may be removed too.
        movable: (n,) bool, which vertices may move, None for all.
        progress: called with the share that is done; may raise to stop.

    Returns:
        vertices: (n, 3) float64; all but the tips keep every bit. Border vertices are never tips.
        spikes: (n,) bool, the tips.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    steep = check_finite("steepness", steepness, least=0.0)
    mesh = normalised_mesh(*check_mesh(vertices, faces), movable)
    points, pairs = mesh.points.copy(), edges(mesh.cells)
    n = len(points)
    spikes = np.zeros(n, dtype=np.bool_)
    rows, columns = np.concatenate([pairs, pairs[:, ::-1]]).T
    neighbours = sparse.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(n, n))
    degrees = np.maximum(np.bincount(rows, minlength=n), 1)[:, None]
    allowed = ~border_vertices(mesh.cells, n)
    allowed &= True if mesh.movable is None else mesh.movable
    across = np.roll(faces_across(mesh.cells), -1, axis=1)  # the face across the edge opposite to each corner
    for done in range(_SPIKE_PASSES):
        progress(done / _SPIKE_PASSES)
        means = (neighbours @ points) / degrees
        # The shorter formula sum |p_j|^2 - d |m|^2, with d neighbours, would lose the digits of small one-rings.
        spread = np.bincount(rows, ((points[columns] - means[rows]) ** 2).sum(axis=1), minlength=n) / degrees[:, 0]
        heights = np.linalg.norm(points - means, axis=1)
        highest = heights.copy()
        np.maximum.at(highest, rows, heights[columns])
        tips = allowed & (heights > steep * np.sqrt(spread)) & (heights >= highest) & (heights > 0.0)
        corners = np.nonzero(tips[mesh.cells] & (across >= 0))
        normals = (face_normals(p, mesh.cells) for p in (points, np.where(tips[:, None], means, points)))
        before, after = (angles_between(n[corners[0]], n[across[corners]]) for n in normals)
        tips &= np.bincount(mesh.cells[corners], after - before, minlength=n) <= 0.0
        if not tips.any():
            break
        points[tips] = means[tips]
        spikes |= tips
    progress(1.0)
    return mesh.restored(points), mask_of(mesh.used[spikes], len(mesh.vertices))

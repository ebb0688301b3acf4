"""Implicit fairing: backward Euler steps of the diffusion equation, stable however long."""

import math
from typing import Literal, TypeAlias, get_args

from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice, check_whole_number
from ..execution import Progress, ignore_progress, part_of, threads_for
from ..mesh import Floats, check_mesh, normalised_mesh, worth_reordering
from ..topology import BORDER_POLICIES, BorderPolicy, stars
from .dimensions import dimensions_restored, share_with_dimensions
from .flows import FLOWS, Flow, ImplicitFlow
from .volume import enclosed_volumes, restore_volumes

__all__ = ["Flow", "ImplicitOperator", "implicit_fairing", "time_step_of_detail_size"]

#: "cotangent" is Laplace-Beltrami here: C the cotangent stiffness, M the mixed Voronoi areas.
ImplicitOperator: TypeAlias = Literal["uniform", "inverse_length", "scale_dependent", "cotangent", "robust"]
IMPLICIT_OPERATORS: tuple[ImplicitOperator, ...] = get_args(ImplicitOperator)

_WITHOUT_UNIT = ("uniform", "inverse_length")


def time_step_of_detail_size(detail_size: float, iterations: int = 1, *, keep_dimensions: bool = False) -> float:
    """The time step t with which `iterations` implicit steps halve a wave of that length.

    A wave of length l has omega = 2 pi / l, and each step multiplies its amplitude by s = 1 / (1 + t omega^2), so
    t = (2^(1 / iterations) - 1) (l / 2 pi)^2. Where dimensions are kept it is 1 - (1 - s) (1 - s^2)^2 instead, and t longer. For
    the operators "cotangent", "robust" and "scale_dependent" on a surface that is smooth at that scale.

    Args:
        detail_size: l, in mesh units. Larger is smoother: shorter waves come out with less than half, longer ones with more.
        iterations: number of steps. More cut off more sharply.
        keep_dimensions: as for `implicit_fairing`.

    Returns:
        t, in squared mesh units.
    """
    if not (math.isfinite(detail_size) and detail_size > 0.0):
        raise FilterInputError(f"detail_size {detail_size} is not finite and above 0")
    if not 1e-150 < detail_size < 1e150:
        raise FilterInputError(f"detail_size {detail_size:g} has no square among the numbers; scale the mesh first")
    check_whole_number("iterations", iterations, least=1, note=", if a detail size is to be halved by them")
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
    """Solves (M - t C) p' = M p: the surface after a diffusion time t in one stable step [desbrun1999].

    A mode of eigenvalue -k of L = M^-1 C is multiplied by 1 / (1 + t k). As t grows, a closed component tends to its centroid,
    which it keeps (weighted by M), and one with fixed vertices to a discrete minimal surface. No t is unstable.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles. With none of them and the operator "robust" the vertices are a point cloud.
        operator: "cotangent": the Laplace-Beltrami operator with mixed Voronoi areas. It moves vertices along the normal and does
            not depend on how the surface is triangulated; obtuse triangles are fine, components of triangles without area stay
            as they are. "robust": the same for slivers, non-manifold meshes and point clouds. "scale_dependent",
            "inverse_length" and "uniform" see the triangulation; see `build_laplacian`.
        time_step: t, from 0. Larger is smoother. In squared mesh units, or without a unit for "uniform" and "inverse_length"; see
            `time_step_of_detail_size`.
        iterations: number of steps. n of length t cut off more sharply than one of length n t.
        flow: "linear" smooths the coordinates by the operator of the input, quickest since the system stays the same.
            "mean_curvature" follows the surface: a sphere of radius r0 shrinks by r^2 = r0^2 - 4 t, and thin parts pinch off.
            "conformalized" keeps the angles of the input as weights: no necks pinch, and closed surfaces without handles tend to
            a sphere [kazhdan2012].
        preserve_volume: scale every component about the centroid of its surface, after every step, so that it keeps its volume.
            Only components without border, coherently oriented, all of whose vertices may move; others are left as they come out.
        keep_dimensions: after every step give back along the normals what the surroundings have lost in common, on open surfaces
            too: balls keep their radius and limbs their thickness; see `dimensions_restored`. Of a wave of which a step leaves
            the share s it then leaves 1 - (1 - s) (1 - s^2)^2. Not for point clouds.
        border: "fixed": border vertices stay. "along": the border is smoothed as a curve by a step of its own, of the same t,
            with the operator that `CURVE_OPERATOR` names; then the interior is solved for between the new borders. That is
            the backward Euler step of the flow in which border vertices see only their neighbours on the border. "free":
            border vertices are like any other and the border draws in.
        movable: (n,) bool, which vertices may move, None for all. The others stay where they are and are seen by those that do.
        progress: called every few solver steps with the share that is done; may raise to stop.

    Returns:
        (n, 3) float64. Vertices that do not move keep every bit: those that no face uses, that are not `movable`, or on a fixed
        border. The others are solved for to an error of about 1e-10 of the bounding-box diagonal, root mean square weighted by
        M, and of up to 1e-9 where t is more than a million squared edges. Deterministic, for any number of threads.

    Raises:
        FilterInputError: not a mesh, a parameter out of range, or too little left of a volume that is to be preserved.
        ConvergenceError: the equations cannot be solved.
    """
    points, triangles = check_mesh(vertices, faces)
    check_choice("operator", operator, IMPLICIT_OPERATORS)
    check_choice("flow", flow, FLOWS)
    check_choice("border", border, BORDER_POLICIES)
    if not (math.isfinite(time_step) and time_step >= 0.0):
        raise FilterInputError(f"time_step {time_step} is not finite and at least 0")
    steps = check_whole_number("iterations", iterations, least=0)
    if keep_dimensions and len(points) and not len(triangles):
        raise FilterInputError("keep_dimensions needs triangles, whose normals it moves vertices along: a point cloud has none")
    mesh = normalised_mesh(points, triangles, movable)
    reorder = operator != "robust" and worth_reordering(mesh.cells, len(mesh))
    if reorder:
        mesh = mesh.by_place()
    edges = stars(mesh.cells, len(mesh)).border_edges()
    t = time_step if operator in _WITHOUT_UNIT else time_step * mesh.scale * mesh.scale
    with threads_for(len(mesh)):
        process = ImplicitFlow(
            mesh.points,
            mesh.cells,
            "laplace_beltrami" if operator == "cotangent" else operator,
            time_step=t,
            steps=steps,
            flow=flow,
            border=border,
            border_edges=edges,
            movable=mesh.movable,
        )
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

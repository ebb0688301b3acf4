"""Bilateral filters of vertex positions: along the vertex normal [fleishman2003], and by the planes of triangles [jones2003].

Both move a vertex to a weighted mean of the places that its neighbours predict for it. A space kernel weights by their distance,
a range kernel by how far the predicted place is from the vertex: predictions from across a feature are far off, and count little.
Any M-estimator serves as either kernel. The papers' exp(-x^2 / (2 s^2)) is the kernel "gaussian" with sigma = sqrt(2) s.
"""

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_choice, check_whole_number
from ..execution import Progress, ignore_progress, threads_for
from ..geometry import mean_edge_length
from ..mesh import Floats, Ints, NormalisedMesh, check_mesh, normalised_mesh
from ..robust import KernelName
from ..topology import BORDER_POLICIES, BorderPolicy, border_vertices, one_rings, referenced_vertices, ring_ends
from .neighbour_weights import REACH, Term, range_term, space_term
from .triangle_predictors import heights_of_corners, mollified, predicted, triangles_in_cells
from .vertex_heights import HeightNeighbours, bilateral_step, heights_of_rings

#: What `bilateral_jones` can do on borders: the planes of triangles predict no curve, so that there is no "along".
JonesBorder: TypeAlias = Literal["fixed", "free"]

# Shares of the sigma of 95 % efficiency, the best of a few over noisy models with known truth. The heights of one-rings have the
# noise of both ends and of the normal; those of a triangle's own corners are less than of the other vertices within reach.
_SHARE_OF_RINGS = 0.5
_SHARE_OF_CORNERS = 2.0


def bilateral_fleishman(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    range_kernel: KernelName = "gaussian",
    space_kernel: KernelName = "gaussian",
    range_sigma: float | None = None,
    space_sigma: float | None = None,
    iterations: int = 2,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """p_i <- p_i + n_i sum_j f(|p_j - p_i|) g(h_ij) h_ij / sum_j f g with h_ij = n_i . (p_j - p_i), repeatedly [fleishman2003].

    f is the space, g the range kernel, n_i the mean of the normals around i weighted by area. The sums go over the vertices that
    are within sqrt(2) `space_sigma` and joined to i by edges between such vertices; i itself is not among them, since kernels
    such as "l1" would have it outweigh all others. All vertices move at once, each along its normal, so that triangles keep
    their shape, but closed surfaces shrink a little with each step.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles, oriented alike: a vertex around which the normals cancel stays.
        range_kernel: g; kernels whose psi returns to 0 ("tukey", "gaussian", the truncated ones) keep features best.
        space_kernel: f.
        range_sigma: scale of g in mesh units. Larger flattens larger features. None: from the median height of neighbours in the
            input, a robust estimate of their noise, right where most of the surface is smooth.
        space_sigma: scale of f in mesh units. Larger averages over more; the time grows with its square. None: sqrt(2) mean
            edges, the paper's sigma_c being one mean edge.
        iterations: steps. More are smoother and shrink more; the time is proportional.
        border: "along": border vertices see the border alone, still along the normals of their faces; see `BorderPolicy`.
        movable: (n,) bool, which vertices may move, None for all. The others stay where they are and are seen by those that do.
        progress: called after every step.

    Returns:
        (n, 3) float64. Vertices that do not move keep every bit: those that no face uses, that are not `movable`, on a fixed
        border, or with nothing within reach. Deterministic, for any number of threads.

    Raises:
        FilterInputError: not a mesh, no such kernel or policy, a scale or number out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    steps = check_whole_number("iterations", iterations)
    check_choice("border", border, BORDER_POLICIES)
    mesh = normalised_mesh(points, triangles, movable)
    with threads_for(len(mesh)):
        around = _height_neighbours(mesh, border)
        space = space_term(space_kernel, space_sigma, mesh.scale, REACH * mean_edge_length(mesh.points, mesh.cells))
        heights = heights_of_rings(mesh.points, around)
        height = range_term(range_kernel, range_sigma, mesh.scale, heights, _SHARE_OF_RINGS)
        now, following = mesh.points.copy(), mesh.points.copy()
        for iteration in range(steps if _acts(space, height) else 0):
            bilateral_step(now, following, around, space, height)
            now, following = following, now
            progress((iteration + 1) / steps)
    return mesh.restored(now)


def bilateral_jones(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    range_kernel: KernelName = "gaussian",
    space_kernel: KernelName = "gaussian",
    range_sigma: float | None = None,
    space_sigma: float | None = None,
    border: JonesBorder = "free",
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Replace p by sum_q a_q f(|c_q - p|) g(|P_q(p) - p|) P_q(p) / sum_q a_q f g over the triangles q, once [jones2003].

    a_q is the area of q, c_q its centre, P_q the projection to the plane through c_q. The normals of these planes are mollified:
    they are those of the mesh with each vertex at sum a_q f'(|c_q - p|) c_q / sum a_q f', where f' is f with half the sigma. The
    sums go over the triangles with centres within sqrt(2) sigma, found by place: neither a manifold nor a connected mesh is
    needed, but of two sheets that near to each other only the range kernel keeps one from seeing the other.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles; their orientation makes no difference.
        range_kernel: g; kernels whose psi returns to 0 ("tukey", "gaussian", the truncated ones) keep features best.
        space_kernel: f, also for the mollification.
        range_sigma: scale of g in mesh units. Larger flattens larger features. None: from the median distance of the corners of
            triangles from their mollified planes.
        space_sigma: scale of f in mesh units. Larger averages over more; the time grows with its square. None: 2 mean edges,
            which is sqrt(2) in the paper's normalisation.
        border: "fixed" or "free".
        movable: (n,) bool, which vertices may move, None for all. The others stay where they are and are seen by those that do.
        progress: called after the mollification and at the end.

    Returns:
        (n, 3) float64. Vertices that do not move keep every bit: those that no face uses, that are not `movable`, on a fixed
        border, or with nothing within reach. Deterministic, for any number of threads.

    Raises:
        FilterInputError: not a mesh, no such kernel or policy, or a scale out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    check_choice("border", border, JonesBorder)
    mesh = normalised_mesh(points, triangles, movable)
    start, triangles = mesh.points, mesh.cells
    with threads_for(len(mesh)):
        space = space_term(space_kernel, space_sigma, mesh.scale, 2.0 * mean_edge_length(start, triangles))
        narrow = Term(space.code, space.sigma / 2.0)
        shape = start
        if narrow.sigma > 0.0:
            everywhere = np.arange(len(mesh), dtype=np.int32)
            shape = mollified(start, everywhere, triangles_in_cells(start, triangles, REACH * narrow.sigma), narrow)
        progress(0.3)
        heights = heights_of_corners(start, triangles, shape)
        height = range_term(range_kernel, range_sigma, mesh.scale, heights, _SHARE_OF_CORNERS)
        now = start
        if _acts(space, height):
            near = triangles_in_cells(start, triangles, REACH * space.sigma, shape)
            now = predicted(start, _moving(mesh, border), near, space, height)
    progress(1.0)
    return mesh.restored(now)


def _moving(mesh: NormalisedMesh, border: BorderPolicy) -> Ints:
    """The points that move."""
    moves = referenced_vertices(mesh.cells, len(mesh))
    if mesh.movable is not None:
        moves &= mesh.movable
    if border == "fixed":
        moves &= ~border_vertices(mesh.cells, len(mesh))
    return np.flatnonzero(moves).astype(np.int32)


def _height_neighbours(mesh: NormalisedMesh, border: BorderPolicy) -> HeightNeighbours:
    faces, n = mesh.cells, len(mesh)
    rings = one_rings(faces, n)
    curves = rings.along_border()
    on_curve = np.diff(curves.offsets) > 0 if border == "along" else np.zeros(n, dtype=np.bool_)
    return HeightNeighbours(
        _moving(mesh, border),
        rings.offsets,
        rings.neighbours,
        on_curve,
        curves.offsets,
        curves.neighbours,
        *ring_ends(faces, n),
    )


def _acts(space: Term, height: Term) -> bool:
    return space.sigma > 0.0 and height.sigma > 0.0

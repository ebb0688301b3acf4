"""Bilateral filters of vertex positions: along the vertex normal [fleishman2003], and by the planes of triangles [jones2003].

Both move a vertex to a weighted mean of the positions that its neighbours predict. The space kernel weights by the distance of
the neighbour, the range kernel by the distance of the prediction: predictions from across a feature are far off and count little.
Each kernel is the weight of an M-estimator. The papers' exp(-x^2 / (2 s^2)) is the kernel "gaussian" with sigma = sqrt(2) s.
"""

import math
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice, check_positive, check_whole_number
from ..compilation import compiled, prange
from ..execution import Progress, ignore_progress, threads_for
from ..geometry import cross_product, cross_products, mean_edge_length, unit_vectors
from ..mesh import Bools, Floats, Ints, Longs, NormalisedMesh, check_mesh, mask_of, normalised_mesh
from ..robust import KERNEL_CODES, KERNEL_NAMES, SIGMA_IN_DEVIATIONS, KernelName, kernel_weight, robust_deviation
from ..topology import BORDER_POLICIES, BorderPolicy, border_vertices, one_rings, referenced_vertices, ring_ends

#: `BorderPolicy` without "along": planes of triangles do not predict the curve of the border.
JonesBorder: TypeAlias = Literal["fixed", "free"]

#: Radius of a space kernel in units of its sigma: the distance 2 s at which the papers cut off their Gaussian.
REACH = math.sqrt(2.0)
# Automatic range sigmas as multiples of the sigma of 95 % efficiency, the best of a few tried on models with noise. Below 1 for
# neighbours, whose heights have the noise of two vertices and a normal. Above 1 for triangle corners: their heights are small.
_SHARE_OF_RINGS = 0.5
_SHARE_OF_CORNERS = 2.0
# Squares of sigmas above `_EXTREME` or below 1 / `_EXTREME` could be out of the range of float64.
_EXTREME = 1e150
# These count as rounding errors: a sum of normals times areas, if at most `_CANCELLED` times the summed areas; and the area of a
# mollified triangle, if at most `_CANCELLED` times its area before. Vectors up to `_SMALLEST` have no direction.
_CANCELLED, _SMALLEST = 1e-8, 1e-100
# The most blocks of vertices in a step; each block has its own work arrays of n entries.
_BLOCKS = 32
# The largest number of cells along an axis: the index of a cell stays below 2^63.
_MOST_CELLS = 2**20


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
    """Moves vertices along their normals: p_i <- p_i + n_i sum_j f(|p_j - p_i|) g(h_ij) h_ij / sum_j f g [fleishman2003].

    h_ij = n_i . (p_j - p_i) is the height of j, f the space kernel, g the range kernel, n_i the area-weighted normal of i. The
    sums go over the vertices that a path of edges connects with i, if the whole path is within sqrt(2) `space_sigma` of i. The
    sums leave out j = i: kernels such as "l1" would give i nearly all of the weight. All vertices move at once. Moving along
    normals keeps the shape of triangles, but each step shrinks closed surfaces a little.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles, consistently oriented. A vertex stays if the normals around it cancel out.
        range_kernel: g; kernels whose psi returns to 0 ("tukey", "gaussian", the truncated ones) keep features best.
        space_kernel: f.
        range_sigma: scale of g in mesh units. Larger flattens larger features. None: from the median |h_ij| of input edges.
        space_sigma: scale of f in mesh units. Larger averages over more; the time grows with its square. None: sqrt(2) mean
            edges, so that the paper's sigma_c is one mean edge.
        iterations: number of steps. More steps smooth and shrink more.
        border: "along" averages border vertices over the border alone, but moves them along their normals; see `BorderPolicy`.
        movable: (n,) bool, which vertices may move, None for all. Fixed vertices still count as neighbours.
        progress: called after every step.

    Returns:
        (n, 3) float64. Vertices that are unused, not `movable`, on a fixed border or without neighbours in reach keep every bit.

    Raises:
        FilterInputError: not a mesh, no such kernel or policy, a scale or number out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    steps = check_whole_number("iterations", iterations)
    check_choice("border", border, BORDER_POLICIES)
    mesh = normalised_mesh(points, triangles, movable)
    with threads_for(len(mesh)):
        around = _HeightNeighbours.of(mesh, border)
        space = space_term(space_kernel, space_sigma, mesh.scale, REACH * mean_edge_length(mesh.points, mesh.cells))
        heights = np.zeros(len(around.neighbours))
        _heights(mesh.points, around, heights)
        counted = np.repeat(mask_of(around.moving, len(mesh)), np.diff(around.offsets))
        height = range_term(range_kernel, range_sigma, mesh.scale, heights[counted], _SHARE_OF_RINGS)
        now, following = mesh.points.copy(), mesh.points.copy()
        for iteration in range(steps if min(space.sigma, height.sigma) > 0.0 else 0):
            _step(now, following, around, space, height)
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
    """Moves each vertex p once, to the weighted mean of its projections P_q(p) onto the planes of triangles q [jones2003].

    The mean is sum_q a_q f(|c_q - p|) g(|P_q(p) - p|) P_q(p) / sum_q a_q f g, with a_q the area and c_q the centre of q. The
    plane of q goes through c_q. Its normal is mollified: it is the normal of q after each vertex has moved to the mean
    sum_q a_q f'(|c_q - p|) c_q / sum_q a_q f', where f' is f with half the sigma. The sums go over the triangles with centres
    within sqrt(2) times the sigma of f or f'. The mesh need not be manifold or connected. Only g keeps two close sheets apart.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles; their orientation makes no difference.
        range_kernel: g; see `bilateral_fleishman`.
        space_kernel: f, also for the mollification.
        range_sigma: scale of g in mesh units. Larger flattens larger features. None: from the median distance of the corners of
            triangles from their mollified planes.
        space_sigma: scale of f in mesh units. Larger averages over more; the time grows with its square. None: 2 mean edges,
            so that the paper's sigma_f is sqrt(2) mean edges.
        border: "fixed" or "free".
        movable: (n,) bool, which vertices may move, None for all. Triangles of fixed vertices still count.
        progress: called after the mollification and at the end.

    Returns:
        (n, 3) float64. Vertices that are unused, not `movable`, on a fixed border or without triangles in reach keep every bit.

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
            near = _Triangles.of(start, triangles, REACH * narrow.sigma, start)
            shape = _estimated(start, np.arange(len(mesh), dtype=np.int32), near, narrow, None)
        progress(0.3)
        normals, areas = _mollified(start, shape, triangles)
        corners = start[triangles[areas > 0.0]]
        heights = np.einsum("fkc,fc->fk", corners - corners.mean(axis=1, keepdims=True), normals[areas > 0.0]).ravel()
        height = range_term(range_kernel, range_sigma, mesh.scale, heights, _SHARE_OF_CORNERS)
        now = start
        if min(space.sigma, height.sigma) > 0.0:
            near = _Triangles.of(start, triangles, REACH * space.sigma, shape)
            now = _estimated(start, _moving(mesh, border), near, space, height)
    progress(1.0)
    return mesh.restored(now)


class Term(NamedTuple):
    """The number of a kernel, and its scale in the unit of the coordinates."""

    code: int
    sigma: float


def space_term(kernel: KernelName, sigma: float | None, scale: float, automatic: float) -> Term:
    """Returns the space kernel for coordinates that are `scale` times as large as the mesh; sigma None means `automatic`."""
    check_choice("space_kernel", kernel, KERNEL_NAMES)
    return Term(KERNEL_CODES[kernel], _scaled("space_sigma", sigma, scale, automatic))


def range_term(kernel: KernelName, sigma: float | None, scale: float, heights: Floats, share: float) -> Term:
    """Returns the range kernel, see `space_term`; sigma None means `share` times the sigma of 95 % efficiency for `heights`."""
    check_choice("range_kernel", kernel, KERNEL_NAMES)
    deviation = robust_deviation(heights) if sigma is None and len(heights) else 0.0
    if deviation < np.finfo(np.float64).eps:
        deviation = 0.0
    return Term(KERNEL_CODES[kernel], _scaled("range_sigma", sigma, scale, share * SIGMA_IN_DEVIATIONS[kernel] * deviation))


def _scaled(name: str, sigma: float | None, scale: float, automatic: float) -> float:
    if sigma is None:
        return automatic
    scaled = check_positive(name, sigma, note="; None takes it from the input") * scale
    if not 1.0 / _EXTREME < scaled < _EXTREME:
        raise FilterInputError(f"{name} {sigma} is far too small or too large for the input; None takes it from the input")
    return scaled


def _moving(mesh: NormalisedMesh, border: BorderPolicy) -> Ints:
    moves = referenced_vertices(mesh.cells, len(mesh))
    if mesh.movable is not None:
        moves &= mesh.movable
    if border == "fixed":
        moves &= ~border_vertices(mesh.cells, len(mesh))
    return np.flatnonzero(moves).astype(np.int32)


class _HeightNeighbours(NamedTuple):
    """The moving vertices, the one-rings that lead to all vertices within reach, and the `ring_ends` that give the normals."""

    moving: Ints
    offsets: Longs
    neighbours: Ints
    on_curve: Bools  # (n,) which vertices average over the border alone
    curve_offsets: Longs
    curve_neighbours: Ints
    end_offsets: Longs
    ends: Ints

    @staticmethod
    def of(mesh: NormalisedMesh, border: BorderPolicy) -> "_HeightNeighbours":
        rings = one_rings(mesh.cells, len(mesh))
        curves = rings.along_border()
        on_curve = (np.diff(curves.offsets) > 0) & (border == "along")
        return _HeightNeighbours(_moving(mesh, border), *rings[:2], on_curve, *curves[:2], *ring_ends(mesh.cells, len(mesh)))


@compiled(parallel=True)
def _heights(points: Floats, around: _HeightNeighbours, heights: Floats) -> None:
    moving, offsets, neighbours = around.moving, around.offsets, around.neighbours
    for m in prange(moving.shape[0]):
        i = moving[m]
        x, y, z = _normal(points, i, around)
        for k in range(offsets[i], offsets[i + 1]):
            j = neighbours[k]
            heights[k] = x * (points[j, 0] - points[i, 0]) + y * (points[j, 1] - points[i, 1]) + z * (points[j, 2] - points[i, 2])


@compiled(parallel=True)
def _step(points: Floats, out: Floats, around: _HeightNeighbours, space: Term, height: Term) -> None:
    moving = around.moving
    count = moving.shape[0]
    blocks = min(_BLOCKS, 1 + count // 1024)
    for block in prange(blocks):
        seen = np.full(points.shape[0], -1, dtype=np.int32)
        queue = np.empty(points.shape[0], dtype=np.int32)
        for m in range(block * count // blocks, (block + 1) * count // blocks):
            i = moving[m]
            x, y, z = _normal(points, i, around)
            mean = _mean_height(points, i, (x, y, z), around, seen, queue, space, height)
            out[i, 0] = points[i, 0] + mean * x
            out[i, 1] = points[i, 1] + mean * y
            out[i, 2] = points[i, 2] + mean * z


@compiled
def _normal(points: Floats, i: int, around: _HeightNeighbours) -> tuple[float, float, float]:
    """Returns the unit normal of the faces around i, weighted by area, or 0 if their normals cancel out."""
    end_offsets, ends = around.end_offsets, around.ends
    x = y = z = size = 0.0
    for k in range(end_offsets[i], end_offsets[i + 1], 2):
        a, b, c = cross_product(points, i, ends[k], ends[k + 1])
        x, y, z = x + a, y + b, z + c
        size += abs(a) + abs(b) + abs(c)
    length = math.sqrt(x * x + y * y + z * z)
    if length <= max(_CANCELLED * size, _SMALLEST):
        return 0.0, 0.0, 0.0
    return x / length, y / length, z / length


@compiled
def _mean_height(
    points: Floats,
    i: int,
    normal: tuple[float, float, float],
    around: _HeightNeighbours,
    seen: Ints,
    queue: Ints,
    space: Term,
    term: Term,
) -> float:
    """Returns the weighted mean height of the vertices within reach of i (breadth first); `seen` and `queue` have n entries."""
    offsets, neighbours = around.offsets, around.neighbours
    if around.on_curve[i]:
        offsets, neighbours = around.curve_offsets, around.curve_neighbours
    reach = (REACH * space.sigma) ** 2
    px, py, pz = points[i, 0], points[i, 1], points[i, 2]
    x, y, z = normal
    total = sum_of_heights = 0.0
    queue[0], seen[i] = i, i
    first, last = 0, 1
    while first < last:
        v = queue[first]
        first += 1
        for k in range(offsets[v], offsets[v + 1]):
            j = neighbours[k]
            if seen[j] == i:
                continue
            seen[j] = i
            dx, dy, dz = points[j, 0] - px, points[j, 1] - py, points[j, 2] - pz
            squared = dx * dx + dy * dy + dz * dz
            if squared > reach:
                continue
            height = x * dx + y * dy + z * dz
            share = kernel_weight(space.code, math.sqrt(squared), space.sigma) * kernel_weight(term.code, height, term.sigma)
            total += share
            sum_of_heights += share * height
            queue[last] = j
            last += 1
    return sum_of_heights / total if total > 0.0 else 0.0


class _Triangles(NamedTuple):
    """The triangles with an area, sorted by grid cell: any block of 3 x 3 x 3 cells is 9 runs of triangles, each along z."""

    centres: Floats  # (m, 3)
    normals: Floats  # (m, 3) unit normals
    areas: Floats  # (m,)
    keys: Longs  # (m,) the cell index of each triangle, ascending
    low: Floats  # (3,) the lowest corner of the grid
    size: float  # the side of a cell
    shape: Longs  # (3,) the number of cells along the axes

    @staticmethod
    def of(points: Floats, faces: Ints, reach: float, shape_of: Floats) -> "_Triangles":
        """Returns the triangles of a mesh in cells of at least `reach`; normals are those of `_mollified`."""
        normals, areas = _mollified(points, shape_of, faces)
        whole = np.flatnonzero(areas > 0.0)
        centres = points[faces].mean(axis=1)[whole]
        low, high = (centres.min(axis=0), centres.max(axis=0)) if len(centres) else (np.zeros(3), np.zeros(3))
        size = max(reach, float((high - low).max(initial=0.0)) / (_MOST_CELLS - 3), _SMALLEST)
        low = low - size  # an empty layer of cells all around
        shape = ((high - low) / size).astype(np.int64) + 2
        cells = ((centres - low) / size).astype(np.int64)
        keys = (cells[:, 0] * shape[1] + cells[:, 1]) * shape[2] + cells[:, 2]
        order = np.argsort(keys, kind="stable")
        return _Triangles(centres[order], normals[whole][order], areas[whole][order], keys[order], low, size, shape)


def _mollified(points: Floats, shape: Floats, faces: Ints) -> tuple[Floats, Floats]:
    """Returns (m, 3) unit normals at the points `shape`, or at `points` if collapsed in `shape`; and (m,) areas at `points`."""
    own, vectors = cross_products(points, faces), cross_products(shape, faces)
    lengths = np.linalg.norm(own, axis=1)
    collapsed = np.linalg.norm(vectors, axis=1) <= _CANCELLED * lengths
    return unit_vectors(np.where(collapsed[:, None], own, vectors)), np.where(lengths > _SMALLEST, lengths, 0.0) / 2.0


def _estimated(points: Floats, moving: Ints, triangles: _Triangles, space: Term, height: Term | None) -> Floats:
    """Returns (n, 3) points, the `moving` ones at the mean of their projections or, with `height` None, of triangle centres."""
    out = points.copy()
    _estimate(points, out, moving, triangles, space, height or space, height is None)
    return out


# This search saves a fifth of the time of `_estimate` compared with numpy's, which also handles NaN.
@compiled
def _first_not_below(keys: Longs, key: int) -> int:
    start, stop = 0, keys.shape[0]
    while start < stop:
        middle = (start + stop) // 2
        if keys[middle] < key:
            start = middle + 1
        else:
            stop = middle
    return start


@compiled(parallel=True)
def _estimate(points: Floats, out: Floats, rows: Ints, triangles: _Triangles, space: Term, term: Term, to_centres: bool) -> None:
    centres, normals, areas, keys, low, size, shape = triangles
    reach = (REACH * space.sigma) ** 2
    for m in prange(rows.shape[0]):
        i = rows[m]
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        # A vertex may lie outside the grid of the centres.
        cx = min(max(np.int64((px - low[0]) / size), 0), shape[0] - 1)
        cy = min(max(np.int64((py - low[1]) / size), 0), shape[1] - 1)
        cz = min(max(np.int64((pz - low[2]) / size), 0), shape[2] - 1)
        total = x = y = z = 0.0
        for gx in range(max(cx - 1, 0), min(cx + 2, shape[0])):
            for gy in range(max(cy - 1, 0), min(cy + 2, shape[1])):
                column = (gx * shape[1] + gy) * shape[2]
                at = _first_not_below(keys, column + max(cz - 1, 0))
                end = column + min(cz + 1, shape[2] - 1)
                while at < keys.shape[0] and keys[at] <= end:
                    dx, dy, dz = centres[at, 0] - px, centres[at, 1] - py, centres[at, 2] - pz
                    squared = dx * dx + dy * dy + dz * dz
                    if squared <= reach:
                        share = areas[at] * kernel_weight(space.code, math.sqrt(squared), space.sigma)
                        if not to_centres:
                            height = normals[at, 0] * dx + normals[at, 1] * dy + normals[at, 2] * dz
                            share *= kernel_weight(term.code, height, term.sigma)
                            dx, dy, dz = height * normals[at, 0], height * normals[at, 1], height * normals[at, 2]
                        total += share
                        x += share * dx
                        y += share * dy
                        z += share * dz
                    at += 1
        if total > 0.0:
            out[i, 0] = px + x / total
            out[i, 1] = py + y / total
            out[i, 2] = pz + z / total

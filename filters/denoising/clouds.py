"""Bilateral projection of point clouds: moves each point along its normal to the surface that its neighbours predict."""

from collections.abc import Iterator
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_whole_number
from ..compilation import compiled
from ..execution import Progress, blocks, ignore_progress, over_range
from ..geometry import unit_vectors
from ..mesh import Bools, Floats, Ints, check_points, normalised_mesh
from ..neighbours import nearest_neighbours
from ..quadrics import height_of_quadric, tangents
from ..robust import KernelName, kernel_weight
from .bilateral import REACH, Term, range_term, space_term

# The default range sigma as a share of the sigma of 95 % efficiency (`SIGMA_IN_DEVIATIONS`), as in `bilateral_fleishman`.
_SHARE = 0.5


class CloudKernels(NamedTuple):
    """Kernels and scales of `bilateral_projection`."""

    range: KernelName = "gaussian"
    space: KernelName = "gaussian"
    range_sigma: float | None = None
    space_sigma: float | None = None


def bilateral_projection(
    points: ArrayLike,
    *,
    normals: ArrayLike | None = None,
    neighbors: int = 18,
    range_kernel: KernelName = "gaussian",
    space_kernel: KernelName = "gaussian",
    range_sigma: float | None = None,
    space_sigma: float | None = None,
    iterations: int = 2,
    degree: int = 1,
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Moves points along their normals: p_i <- p_i + n_i sum_j f(|p_j - p_i|) g(h_ij) h_ij / sum_j f g.

    The heights are h_ij = n_i . (p_j - p_i). This is the filter of [fleishman2003] without triangles: the sums go over the
    nearest neighbours of each point, searched again in every iteration. Degree 2 fits a polynomial of second degree in the
    tangential coordinates to the heights, by least squares with the weights f g, and moves p_i by its value at 0: an osculating
    jet [cazals2005]. If the polynomial would pass on more noise than p_i has, as at a border, a plane or the mean replaces it.

    Args:
        points: (n, 3) coordinates.
        normals: (n, 3) of any length and sign, kept through all iterations; a point with the normal 0 stays. None: estimated
            again in every iteration, see `normals_of`.
        neighbors: their number, below n; without `normals` 1 or 2 move nothing. Larger averages over larger regions, more slowly.
        range_kernel: g; see `bilateral_fleishman`.
        space_kernel: f.
        range_sigma: scale of g in the unit of the points. Larger flattens larger features. None: computed from the median
            absolute height of the neighbours in the input.
        space_sigma: scale of f in the unit of the points. Larger makes the weights of near and distant neighbours more equal.
            None: the kernel's radius, sqrt(2) sigma, is the mean distance from a point to its farthest neighbour.
        iterations: number of iterations. More iterations smooth more.
        degree: 1 or 2. Degree 2 follows curvature, but needs four times as many neighbours as degree 1 to reduce noise as much.
        movable: (n,) bool, which points may move, None for all. Fixed points still count as neighbours.
        progress: called after every iteration.

    Returns:
        (n, 3) float64. Points that do not move keep every bit.

    Raises:
        FilterInputError: not a cloud, normals that do not fit, too few points, no such kernel, a parameter out of range.
    """
    coordinates = check_points(points)
    directions = None if normals is None else unit_normals(normals, len(coordinates))
    count = check_whole_number("neighbors", neighbors, least=1)
    steps = check_whole_number("iterations", iterations)
    check_whole_number("degree", degree, least=1, most=2)
    cloud = normalised_mesh(coordinates, np.empty((0, 3), dtype=np.int32), movable)
    kernels = CloudKernels(range_kernel, space_kernel, range_sigma, space_sigma)
    now = cloud.points
    results = projections(now, directions, count, kernels, degree=degree, scale=cloud.scale, movable=cloud.movable)
    for done, result in enumerate(islice(results, steps), start=1):
        now = result
        progress(done / steps)
    return cloud.restored(now)


def projections(
    points: Floats,
    normals: Floats | None,
    neighbors: int,
    kernels: CloudKernels,
    *,
    degree: int = 1,
    scale: float = 1.0,
    movable: Bools | None = None,
) -> Iterator[Floats]:
    """Yields the points after each iteration of `bilateral_projection`, without end; nothing if a kernel's sigma is 0.

    Arguments: see `bilateral_projection`. `points` are already multiplied by `scale`, sigmas are not; `normals` have length 1.
    """
    moves = np.ones(len(points), dtype=np.bool_) if movable is None else movable
    now, space, height = points, None, None
    while True:
        distances, indices = nearest_neighbours(now, neighbors)
        axes = normals_of(now, indices) if normals is None else normals
        if space is None or height is None:
            space = space_term(kernels.space, kernels.space_sigma, scale, float(distances[:, -1].mean()) / REACH)
            height = range_term(kernels.range, kernels.range_sigma, scale, _heights_of(now, axes, indices), _SHARE)
            if space.sigma <= 0.0 or height.sigma <= 0.0:
                return
        following = now.copy()
        over_range(_project, len(now), now, following, axes, moves, distances, indices, space, height, degree)
        now = following
        yield now


def estimated_range_sigma(points: Floats, normals: Floats | None, neighbors: int, kernel: KernelName) -> float:
    """Returns the default range sigma of `bilateral_projection`, 0 if all heights h_ij are 0; arguments as in `projections`."""
    _, indices = nearest_neighbours(points, neighbors)
    axes = normals_of(points, indices) if normals is None else normals
    return range_term(kernel, None, 1.0, _heights_of(points, axes, indices), _SHARE).sigma


def _heights_of(points: Floats, normals: Floats, indices: Ints) -> Floats:
    heights = np.zeros(indices.shape)
    over_range(_heights, len(points), points, normals, indices, heights)
    return heights.ravel()


def normals_of(points: Floats, indices: Ints) -> Floats:
    """Returns (m, 3) unit normals, each the direction of least variance of a point and its neighbours, of arbitrary sign.

    If the neighbours coincide or lie on a line, the direction is arbitrary, too. `indices` has the (m, k) neighbours of the first
    m points. More neighbours give steadier normals and round off edges.
    """
    normals = np.empty((len(indices), 3))
    for part in blocks(len(indices)):
        covariances = np.empty((part.stop - part.start, 3, 3))
        over_range(_covariances, len(covariances), points, indices, part.start, covariances)
        # The scaling prevents underflow in tiny neighbourhoods.
        sizes = np.abs(covariances).max(axis=(1, 2), keepdims=True)
        normals[part] = np.linalg.eigh(covariances / np.where(sizes > 0.0, sizes, 1.0))[1][:, :, 0]
    return normals


def smoothed_directions(normals: Floats, indices: Ints) -> Floats:
    """Returns (m, 3) the unit mean of each normal and its neighbours' normals, flipped if they oppose it, as in MeshLab.

    `normals` are (n, 3) unit normals of any sign; `indices` has the (m, k) neighbours of the first m points.
    """
    smooth = np.empty((len(indices), 3))
    for part in blocks(len(indices)):
        reference = normals[part]
        sums = reference.copy()
        for column in indices[part].T:
            other = normals[column]
            sums += np.where(np.einsum("ij,ij->i", reference, other) > 0.0, 1.0, -1.0)[:, None] * other
        smooth[part] = sums
    return unit_normals(smooth, len(indices))


def unit_normals(normals: ArrayLike, n: int) -> Floats:
    """Returns (n, 3) the normals with length 1; a normal of 0 stays. Raises `FilterInputError` unless n finite ones are given."""
    directions = check_points(normals, "normal", "normals", "a point whose normal is 0 stays")
    if directions.shape != (n, 3):
        raise FilterInputError(f"normals must have the shape ({n}, 3), one per point, got {directions.shape}")
    sizes = np.abs(directions).max(axis=1, initial=0.0, keepdims=True)
    return unit_vectors(directions / np.where(sizes > 0.0, sizes, 1.0))


@compiled(nogil=True)
def _covariances(points: Floats, indices: Ints, first: int, covariances: Floats, begin: int, end: int) -> None:
    count = indices.shape[1] + 1
    for m in range(begin, end):
        i = first + m
        # Differences from the point itself keep their digits far from the origin.
        mx = my = mz = xx = xy = xz = yy = yz = zz = 0.0
        for k in range(indices.shape[1]):
            j = indices[i, k]
            x, y, z = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            mx += x
            my += y
            mz += z
            xx += x * x
            xy += x * y
            xz += x * z
            yy += y * y
            yz += y * z
            zz += z * z
        covariances[m, 0, 0] = xx - mx * mx / count
        covariances[m, 1, 1] = yy - my * my / count
        covariances[m, 2, 2] = zz - mz * mz / count
        covariances[m, 0, 1] = covariances[m, 1, 0] = xy - mx * my / count
        covariances[m, 0, 2] = covariances[m, 2, 0] = xz - mx * mz / count
        covariances[m, 1, 2] = covariances[m, 2, 1] = yz - my * mz / count


@compiled(nogil=True)
def _heights(points: Floats, normals: Floats, indices: Ints, heights: Floats, begin: int, end: int) -> None:
    for i in range(begin, end):
        for k in range(indices.shape[1]):
            heights[i, k] = _height(points, normals, i, indices[i, k])


@compiled(nogil=True)
def _height(points: Floats, normals: Floats, i: int, j: int) -> float:
    height = 0.0
    for c in range(3):
        height += normals[i, c] * (points[j, c] - points[i, c])
    return height


@compiled(nogil=True)
def _project(
    points: Floats,
    out: Floats,
    normals: Floats,
    moves: Bools,
    distances: Floats,
    indices: Ints,
    space: Term,
    term: Term,
    degree: int,
    begin: int,
    end: int,
) -> None:
    most = indices.shape[1]
    samples, work = np.empty((4, most)), np.empty((9, 6))
    for i in range(begin, end):
        unit = distances[i, most - 1]
        if not moves[i] or unit == 0.0:
            continue
        ax, ay, az, bx, by, bz = tangents(normals[i, 0], normals[i, 1], normals[i, 2])
        count, largest, total, shift = 0, 0.0, 0.0, 0.0
        for k in range(most):
            j = indices[i, k]
            dx, dy, dz = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            height = _height(points, normals, i, j)
            share = kernel_weight(space.code, distances[i, k], space.sigma) * kernel_weight(term.code, height, term.sigma)
            total += share
            shift += share * height
            if degree > 1 and share > 0.0:
                samples[0, count], samples[1, count] = (ax * dx + ay * dy + az * dz) / unit, (bx * dx + by * dy + bz * dz) / unit
                samples[2, count], samples[3, count] = height, share
                largest = max(largest, share)
                count += 1
        height = shift / total if total > 0.0 else 0.0
        if degree > 1:
            for k in range(count):
                samples[3, k] /= largest
            # 1.0 limits the noise of the height to that of the point.
            height, _ = height_of_quadric(samples, count, 1.0, work)
        for c in range(3):
            out[i, c] = points[i, c] + height * normals[i, c]

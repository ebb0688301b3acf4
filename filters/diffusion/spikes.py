"""Spike removal: single vertices far from the mean of their neighbours are put there."""

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_finite
from ..execution import Progress, ignore_progress
from ..libraries import sparse
from ..mesh import Bools, Floats, check_mesh, mask_of, normalised_mesh
from ..topology import border_vertices, edges

# The most passes. A spike hides those next to it, which the next pass removes.
_PASSES = 10


def remove_spikes(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    steepness: float = 1.5,
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> tuple[Floats, Bools]:
    """Put vertices that are farther from the mean m of their neighbours than these spread around it to m.

    With the neighbours j of vertex i, m = mean p_j and s^2 = mean |p_j - m|^2, vertex i is the tip of a spike if
    |p_i - m| > k s, k the `steepness`, and |p_i - m| is the largest of its one-ring. All tips move at once; then again, until
    none is left. A pyramid on a regular polygon has the steepness of its height over the radius: k = 1.5 is a tip of 67 degrees
    from side to side.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        steepness: k, above 0. Larger removes thinner spikes alone; below 1, corners of cubes go.
        movable: (n,) bool, which vertices may move, None for all.
        progress: called with the share that is done; may raise to stop.

    Returns:
        vertices: (n, 3) float64; all but the tips, and those on borders, keep every bit.
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
    for done in range(_PASSES):
        progress(done / _PASSES)
        means = (neighbours @ points) / degrees
        # sum |p_j - m|^2 = sum |p_j|^2 - k |m|^2 would lose the digits of small stars.
        spread = np.bincount(rows, ((points[columns] - means[rows]) ** 2).sum(axis=1), minlength=n) / degrees[:, 0]
        heights = np.linalg.norm(points - means, axis=1)
        highest = heights.copy()
        np.maximum.at(highest, rows, heights[columns])
        tips = allowed & (heights > steep * np.sqrt(spread)) & (heights >= highest) & (heights > 0.0)
        if not tips.any():
            break
        points[tips] = means[tips]
        spikes |= tips
    result = mesh.restored(points)
    progress(1.0)
    return result, mask_of(mesh.used[spikes], len(mesh.vertices))

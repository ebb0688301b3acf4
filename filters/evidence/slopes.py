"""How far the slopes of results are expected to be from the true ones [stein1981]: normals follow from them, not from places."""

from collections.abc import Callable

import numpy as np

from ..mesh import Bools, Floats, Ints
from ..topology import edges
from .held_out import random_numbers
from .local_means import local_means

# The noise is added once more, times this: little enough that it leaves a filter as it is, and so much that the jumps of kernels
# that cut off are met by many faces and not by a few.
_MORE = 0.3
# How much results differ is averaged over so many rings.
_AVERAGED = 2


def slope_squares(heights: Floats, passed: Floats, noise: Floats, pairs: Ints) -> Floats:
    """(e,) (h_i - h_j)^2 + 2 (b_i - b_j) (g_i - g_j), whose mean is the squared error of the slopes and a constant.

    Args:
        heights: (n,) h, how far a filter moves the vertices along the normals.
        passed: (n,) g, what it makes of the noise b: its derivative in that direction.
        noise: (n,) b, a noise as that of the scan and independent of it.
        pairs: (e, 2) the edges.
    """
    i, j = pairs.T
    return np.asarray((heights[i] - heights[j]) ** 2 + 2.0 * (noise[i] - noise[j]) * (passed[i] - passed[j]))


def slope_errors(
    points: Floats,
    faces: Ints,
    heights: Callable[[Floats], dict[int, Floats]],
    *,
    best: int,
    normals: Floats,
    scored: Bools,
    seed: int = 0,
) -> dict[int, float]:
    """The expected squared errors of the slopes of results, where the noise of every vertex is its own.

    As much as a filter follows the noise, so much it follows a little more of it, which is added to see that [ramani2008]. How
    strong the noise is the best filter says: it takes heights h from the scan, and b - g of a noise b; so the variances of the
    noises are as mean(h^2) to mean((b - g)^2).

    Squares would be ruled by edges and corners, where results differ most, while all faces count in a mean angle. So a square
    counts as 1 over the root mean square of how much the slopes of the results differ around it.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        heights: for (n, 3) points the heights (n,) of the results of the filters over the given ones, by their numbers.
        best: the number of the filter that the strength of the noise is measured by.
        normals: (n, 3) unit normals along which noise is added.
        scored: (n,) the vertices that count.
        seed: another noise for another number.

    Returns:
        By their numbers the errors. They are known up to an uncertainty that all share, and so may be below 0.
    """
    pairs = edges(faces)
    signs = np.where(random_numbers(points, pairs, seed) < 0.5, -1.0, 1.0)
    pairs = pairs[scored[pairs].all(axis=1)]
    taken = heights(points)
    noise = np.sqrt((taken[best][scored] ** 2).mean()) * signs
    if not noise.any() or not len(pairs):
        return {best: 0.0}
    more = heights(points + _MORE * noise[:, None] * normals)
    passed = {at: (more[at] - taken[at]) / _MORE for at in taken}
    of_noise = float(((noise - passed[best])[scored] ** 2).mean())
    stronger = float((taken[best][scored] ** 2).mean()) / of_noise if of_noise > 0.0 else 1.0
    numbers = sorted(taken)
    differences = np.var([taken[at][pairs[:, 0]] - taken[at][pairs[:, 1]] for at in numbers], axis=0)
    weights = 1.0 / np.sqrt(_around(differences, pairs, len(points)))
    own = stronger * (noise[pairs[:, 0]] - noise[pairs[:, 1]]) ** 2
    return {
        at: float((slope_squares(taken[at], stronger * passed[at], noise, pairs) - own) @ weights / weights.sum())
        for at in numbers
    }


def _around(values: Floats, pairs: Ints, n: int) -> Floats:
    """(e,) the means of values of the edges over the edges around; not 0, so that these can be divided by."""
    sums, counts = np.bincount(pairs.ravel(), np.repeat(values, 2), n), np.bincount(pairs.ravel(), minlength=n)
    means = local_means(sums / np.maximum(counts, 1), counts > 0, pairs, times=_AVERAGED)[pairs].mean(axis=1)
    return np.asarray(np.maximum(means, max(np.finfo(float).eps * means.mean(), np.finfo(float).tiny)))

"""How far the slopes of results are expected to be from the true ones [stein1981]: normals follow from them, not from places."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..mesh import Bools, Floats, Ints
from ..topology import edges
from .held_out import random_signs
from .local_means import local_means

# The noise is added once more, times this: little enough that it leaves a filter as it is, and so much that the jumps of kernels
# that cut off are met by many faces and not by a few.
_MORE = 0.3
# So many such noises are tried, and meant over.
_NOISES = 2
# How much results differ is averaged over so many rings.
_AVERAGED = 2
# There are three edges to a vertex, which share its noise.
_EDGES_OF_VERTEX = 3.0


class SlopeError(NamedTuple):
    """What is expected of a result.

    Attributes:
        error: the squared error of its slopes. It is known up to an uncertainty that all results share, and so may be below 0.
        excess: how much that is more than the least.
        uncertainty: the standard error of the excess.
    """

    error: float
    excess: float
    uncertainty: float


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
    taken: Mapping[int, Floats],
    heights: Callable[[Floats], Mapping[int, Floats]],
    *,
    best: int,
    normals: Floats,
    scored: Bools,
    seed: int = 0,
) -> dict[int, SlopeError]:
    """The expected squared errors of the slopes of results, where the noise of every vertex is its own.

    As much as a filter follows the noise, so much it follows a little more of it, which is added to see that [ramani2008]. How
    strong the noise is the best filter says: it takes heights h from the scan, and b - g of a noise b; so the variances of the
    noises are as mean(h^2) to mean((b - g)^2).

    Squares would be ruled by edges and corners, where results differ most, while all faces count in a mean angle. So a square
    counts as 1 over the root mean square of how much the slopes of the results differ around it.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        taken: the heights (n,) of the results of the filters over the points, along the normals, by the filters' numbers.
        heights: those of their results for other (n, 3) points, over the given ones too.
        best: the number of the filter that the strength of the noise is measured by.
        normals: (n, 3) unit normals along which noise is added.
        scored: (n,) the vertices that count.
        seed: another noise for another number.

    Returns:
        Their errors, by their numbers.
    """
    pairs = edges(faces)
    signs = [random_signs(points, pairs, _NOISES * seed + k) for k in range(_NOISES)]
    pairs = pairs[scored[pairs].all(axis=1)]
    strength = float(np.sqrt((taken[best][scored] ** 2).mean()))
    if strength == 0.0 or not len(pairs):
        return {best: SlopeError(0.0, 0.0, 0.0)}
    numbers = sorted(taken)
    squares = np.zeros((len(numbers), len(pairs)))
    for noise in (strength * sign for sign in signs):
        more = heights(points + _MORE * noise[:, None] * normals)
        passed = {at: (more[at] - taken[at]) / _MORE for at in numbers}
        of_noise = float(((noise - passed[best])[scored] ** 2).mean())
        stronger = strength**2 / of_noise if of_noise > 0.0 else 1.0
        own = stronger * (noise[pairs[:, 0]] - noise[pairs[:, 1]]) ** 2
        squares += [slope_squares(taken[at], stronger * passed[at], noise, pairs) - own for at in numbers]
    weighted = squares * weights_of([taken[at] for at in numbers], pairs, len(points)) / _NOISES
    errors = weighted.sum(axis=1)
    least = int(errors.argmin())
    behind = weighted - weighted[least]
    uncertainty = behind.std(axis=1) * np.sqrt(_EDGES_OF_VERTEX * len(pairs))
    return {
        at: SlopeError(float(error), float(error - errors[least]), float(doubt))
        for at, error, doubt in zip(numbers, errors, uncertainty, strict=True)
    }


def weights_of(heights: Floats | Sequence[Floats], pairs: Ints, n: int) -> Floats:
    """(e,) the weights of edges, 1 in all: 1 over the root mean square of how much the slopes of the results differ around each.

    Args:
        heights: (k, n) those of the results.
        pairs: (e, 2) the edges that count.
        n: the number of vertices.
    """
    differences = np.var([height[pairs[:, 0]] - height[pairs[:, 1]] for height in heights], axis=0)
    weights = 1.0 / np.sqrt(_around(differences, pairs, n))
    return np.asarray(weights / weights.sum())


def _around(values: Floats, pairs: Ints, n: int) -> Floats:
    """(e,) the means of values of the edges over the edges around; not 0, so that these can be divided by."""
    sums, counts = np.bincount(pairs.ravel(), np.repeat(values, 2), n), np.bincount(pairs.ravel(), minlength=n)
    means = local_means(sums / np.maximum(counts, 1), counts > 0, pairs, times=_AVERAGED)[pairs].mean(axis=1)
    return np.asarray(np.maximum(means, max(np.finfo(float).eps * means.mean(), np.finfo(float).tiny)))

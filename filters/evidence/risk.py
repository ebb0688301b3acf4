"""A filter chosen by how far its result is expected to be from the truth, where the covariance of the noise is known."""

from collections.abc import Sequence

import numpy as np

from ..execution import Progress, ignore_progress, part_of
from ..geometry import normal_differences
from ..libraries import spatial
from ..mesh import Bools, Floats, Ints
from ..topology import edges
from .cross_validation import Candidates, Choice, Label, Scores, run_to_last, starts_of, trials_of

# The noise is added once more, times this: little enough that the filter does not see it, and far more than rounding.
_LITTLE = 0.1
# Standard errors are those of the means of so many regions: neighbours say the same.
_REGIONS = 100


def choose_by_risk(
    points: Floats,
    faces: Ints,
    candidates: Candidates,
    labels: Sequence[Sequence[Label]],
    *,
    normals: Floats,
    scored: Bools,
    noise: Floats,
    progress: Progress = ignore_progress,
) -> Choice[Label] | None:
    """Choose the result whose slopes are expected to be nearest to the true ones [stein1981], for noise of any covariance.

    Held-out vertices say nothing where neighbours share their noise, and little of filters that take noise and shape alike. But
    what a filter f makes of noise can be seen [ramani2008]: with heights h = n . (f(y) - y), one more noise b of the same
    covariance, and g = n . (f(y + e b) - f(y)) / e, the mean over the edges of (h_i - h_j)^2 + 2 (b_i - b_j) (g_i - g_j) is how
    far the differences of heights along the edges are from those of another scan of the same surface: that is the squared error
    of the result and the variance of the noise.

    Of those within one standard error of the best the flattest is taken.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        candidates: what is tried, each on all vertices.
        labels: for each family the labels of its results. The very first should be that of doing nothing.
        normals: (n, 3) unit normals of a smoothed copy.
        scored: (n,) the vertices that count.
        noise: (n,) heights of a noise as that of the scan, independent of it.
        progress: called after every family that was run; may raise to stop.

    Returns:
        The choice; None if no edge counts. The errors are in mean edges.
    """
    pairs = edges(faces)
    counted = pairs[scored[pairs].all(axis=1)]
    if not len(counted):
        return None
    every = [label for family in labels for label in family]
    heights = np.zeros((len(every), len(points)))
    passed, flatness = np.zeros_like(heights), np.zeros(len(every))

    def look(at: int, result: Floats) -> None:
        heights[at] = np.einsum("ij,ij->i", result - points, normals)
        flatness[at] = roughness(result, faces)

    def look_again(at: int, result: Floats) -> None:
        passed[at] = (np.einsum("ij,ij->i", result - points, normals) - heights[at]) / _LITTLE

    none_held, starts, all_of_them = np.empty(0, dtype=np.int32), starts_of(labels), np.ones(len(every), dtype=np.bool_)
    run_to_last(candidates(points, none_held), starts, all_of_them, look, part_of(progress, 0.0, 0.5))
    more = points + _LITTLE * noise[:, None] * normals
    run_to_last(candidates(more, none_held), starts, all_of_them, look_again, part_of(progress, 0.5, 1.0))
    regions = _regions(points, counted[:, 0])
    sums = np.array(
        [
            np.bincount(regions, slope_squares(height, passes, noise, counted), minlength=_REGIONS) / len(counted)
            for height, passes in zip(heights, passed, strict=True)
        ]
    )
    shares = np.bincount(regions, minlength=_REGIONS) / len(counted)
    means = sums.sum(axis=1)
    best = int(means.argmin())
    excess = means - means[best]
    uncertainty = np.sqrt(((sums - sums[best] - excess[:, None] * shares) ** 2).sum(axis=1))
    scores = Scores(np.sqrt(np.maximum(means, 0.0)), excess, uncertainty, best)
    trials = trials_of(every, np.arange(len(every), dtype=np.int32), scores)
    return Choice(trials[int(np.where(excess <= uncertainty, flatness, np.inf).argmin())], trials)


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


def roughness(points: Floats, faces: Ints) -> float:
    """The mean difference |n_f - n_g| of the unit normals of adjacent faces; 0 without any."""
    differences = normal_differences(points, faces)
    return float(differences.mean()) if len(differences) else 0.0


def _regions(points: Floats, which: Ints) -> Ints:
    """(k,) for the vertices the region that each is in, around vertices that lie anywhere."""
    distances = np.linalg.norm(points[which] - points[which].mean(axis=0), axis=1)
    middles = which[np.argsort((distances * 1013.0) % 1.0, kind="stable")]
    middles = middles[np.sort(np.unique(middles, return_index=True)[1])][:_REGIONS]
    return np.asarray(spatial.cKDTree(points[middles]).query(points[which])[1], dtype=np.int64)

"""Chooses the amount of smoothing for a point cloud from the cloud alone."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_choice, check_positive
from ..denoising import CloudKernels, estimated_range_sigma, noise_floor, normals_of, projections, unit_normals
from ..evidence import (
    Choice,
    cross_validate,
    height_residuals,
    held_out_vertices,
    lengths_around,
    local_means,
    predicted_heights,
    tuned,
)
from ..execution import Progress, ignore_progress
from ..libraries import spatial
from ..mesh import Bools, Floats, Ints, NormalisedMesh, check_points, mask_of, normalised_mesh
from ..neighbours import nearest_neighbours
from ..robust import KERNEL_NAMES, KernelName
from ..topology import OneRings, one_rings

# Settings tried for each degree: numbers of neighbours, multiples of the estimated range sigma, the most iterations.
# Degree 1 with 40 neighbours smooths more than degree 2 with 90: it serves flat clouds.
_TRIED = {1: ((6, 8, 12, 18, 40), (0.5, 1.0, 4.0), 3), 2: ((18, 27, 40, 60, 90), (1.0,), 4)}
# Clouds above `_WHOLE` points are sampled by `_PATCHES` patches of `_POINTS` points. Only the `_INNER` middle points of a patch
# may be held out: the patch contains nearly all of their 40 nearest neighbours, and most of their 90 nearest.
_WHOLE, _PATCHES, _POINTS, _INNER = 10_000, 40, 250, 100
# Number of nearest points used as a one-ring; numbers of neighbours and iterations for the smoothed copy that gives the normals.
_NEAR, _SMOOTHED_BY, _SMOOTHED = 6, 18, 2
# Number of sets of held-out points, and the least number of points in all sets together.
_SETS, _ENOUGH = 4, 30


class Projection(NamedTuple):
    """A setting of `bilateral_projection`; 0 iterations do nothing."""

    neighbors: int = 0
    range_sigma: float = 0.0
    iterations: int = 0
    degree: int = 1

    @property
    def amount(self) -> float:
        """The amount of smoothing. A quadric fitted to 4 k neighbours in a disk has the variance of the mean of k neighbours."""
        return self.neighbors * self.iterations / (1.0 if self.degree == 1 else 4.0)


def chosen_projection(
    points: ArrayLike,
    *,
    normals: ArrayLike | None = None,
    range_kernel: KernelName = "gaussian",
    space_kernel: KernelName = "gaussian",
    range_sigma: float | None = None,
    space_sigma: float | None = None,
    movable: ArrayLike | None = None,
    seed: int = 0,
    progress: Progress = ignore_progress,
) -> Choice[Projection] | None:
    """Chooses the setting of `bilateral_projection` that best predicts held-out points along the normals.

    A cloud counts as clean if its calmest part has hardly any noise. Four sets of points are held out. Among the settings within
    one standard error of the best, the one with the least `Projection.amount` wins. If residuals of neighbours correlate, doing
    nothing wins instead, unless the smoothed points are probably nearer to the true surface than the given points.

    The arguments are those of `bilateral_projection`. A given range sigma is the only one tried. Fixed points are never held out,
    `seed` selects the held-out points, and `progress` is called while settings are tried.

    Returns:
        The choice. Its first trial does nothing. Errors are in spacings of the points that are tried, a random part of very
        noisy clouds; range sigmas are in the unit of the points. None if the cloud is clean, most points coincide or too few can
        be used. The choice does not depend on the number of threads, or on the position, orientation, scale and order of points.

    Raises:
        FilterInputError: not a cloud of at least 7 points; no such kernel; scales, normals or `movable` that do not fit.
    """
    coordinates = check_points(points)
    directions = None if normals is None else unit_normals(normals, len(coordinates))
    for name, kernel in (("range_kernel", range_kernel), ("space_kernel", space_kernel)):
        check_choice(name, kernel, KERNEL_NAMES)
    given = (("range_sigma", range_sigma), ("space_sigma", space_sigma))
    sigmas = [sigma if sigma is None else check_positive(name, sigma) for name, sigma in given]
    cloud = normalised_mesh(coordinates, np.empty((0, 3), dtype=np.int32), movable)
    sampled = _sampled(cloud)
    if sampled is None:
        return None
    sample, origin, spacing, reduction = sampled
    local = sample.points
    moves = None if cloud.movable is None else cloud.movable[origin]
    axes = None if directions is None else directions[origin]
    held = held_out_vertices(local, sample.pairs, scored=sample.inner, sets=_SETS, seed=seed)
    if sum(map(len, held)) < _ENOUGH:
        return None
    kernels = CloudKernels(range_kernel, space_kernel, *(sigma and sigma * cloud.scale / spacing for sigma in sigmas))
    families = [[Projection()], *_families(local, axes, kernels)]
    costs = np.zeros(len(local))

    def projected(start: Floats, first: Projection) -> Iterator[Floats]:
        of_family = kernels._replace(range_sigma=first.range_sigma)
        return projections(start, axes, first.neighbors, of_family, degree=first.degree, movable=moves)

    def run(mask: Ints) -> list[Iterator[Floats]]:
        start, costs[mask] = sample.without(mask)
        return [iter([start]), *(projected(start, family[0]) for family in families[1:])]

    def deviations(mask: Ints, at: int, result: Floats) -> Floats:
        return costs[mask] if at == 0 else np.einsum("ij,ij->i", local[mask] - result[mask], sample.normals[mask])

    def label(tried: Projection) -> Projection:
        neighbors = min(reduction * tried.neighbors, len(coordinates) - 1)
        return tried._replace(neighbors=neighbors, range_sigma=tried.range_sigma * (spacing / cloud.scale))

    choice = cross_validate(local, held, run, deviations, [list(map(label, family)) for family in families], progress=progress)
    chosen = min((trial for trial in choice.trials if trial.excess <= trial.uncertainty), key=lambda trial: trial.label.amount)
    if sample.correlation > tuned.CLOUD_INDEPENDENT and chosen.error**2 >= 2.0 * (tuned.EVEN * sample.quietest) ** 2:
        chosen = choice.trials[0]
    return replace(choice, chosen=chosen)


def _sampled(cloud: NormalisedMesh) -> "tuple[CloudSample, Ints, float, int] | None":
    """Returns a sample, its indices in the cloud, the spacing and the reduction 4^k; None if the cloud is clean or unusable.

    The points are reduced to a random quarter, k times, until noise is below half a spacing or residuals hardly correlate.
    """
    kept, reduction = np.arange(len(cloud), dtype=np.int32), 1
    while reduction == 1 or len(kept) >= _ENOUGH:
        points = cloud.points[kept]
        sums = nearest_neighbours(points, _NEAR)[0].sum(axis=1)
        spacing = float(np.median(sums)) / _NEAR
        if spacing == 0.0:
            return None
        numbers = (sums / spacing * 1013.0) % 1.0  # pseudo-random, from 0 to 1
        local, origin, inner = _patches(points / spacing, numbers)
        origin = kept[origin]
        near = min(_SMOOTHED_BY, len(local) - 1)
        smooth = (local, *islice(projections(local, None, near, CloudKernels()), _SMOOTHED))[-1]
        normals = normals_of(smooth, nearest_neighbours(smooth, near)[1])
        sample = CloudSample(local, inner if cloud.movable is None else inner & cloud.movable[origin], normals)
        if sample.quietest < tuned.CLOUD_NO_NOISE:
            return None
        if sample.quietest <= tuned.CLOUD_THICK or sample.correlation <= tuned.CLOUD_INDEPENDENT:
            return sample, origin, spacing, reduction
        kept, reduction = kept[numbers < 1.0 / 4], 4 * reduction
    return None


def _families(points: Floats, normals: Floats | None, kernels: CloudKernels) -> list[list[Projection]]:
    """Returns a list of settings, by ascending iterations, for each number of neighbours and range sigma."""
    families = []
    for degree, (counts, shares, iterations) in _TRIED.items():
        for neighbors in (k for k in counts if k < len(points)):
            if kernels.range_sigma is None:
                estimated = estimated_range_sigma(points, normals, neighbors, kernels.range)
                sigmas = [share * estimated for share in shares if estimated > 0.0]
            else:
                sigmas = [kernels.range_sigma]
            families += [[Projection(neighbors, sigma, i + 1, degree) for i in range(iterations)] for sigma in sigmas]
    return families


@dataclass(frozen=True, eq=False)
class CloudSample:
    """A cloud to try filters on. Its spacing, the median of the mean distances to the six nearest points, is 1."""

    points: Floats  # (k, 3) coordinates
    inner: Bools  # (k,) which points may be held out: they are movable, and their neighbourhoods are nearly complete
    normals: Floats  # (k, 3) unit normals of a smoothed copy, which may point to either side

    @cached_property
    def pairs(self) -> Ints:
        """(e, 2) the unique pairs in which one point is among the six nearest of the other."""
        _, near = nearest_neighbours(self.points, _NEAR)
        pairs = np.column_stack([np.repeat(np.arange(len(near), dtype=np.int32), _NEAR), near.ravel()])
        return np.unique(np.sort(pairs, axis=1), axis=0)

    @cached_property
    def rings(self) -> OneRings:
        """The one-rings that `pairs` define."""
        return one_rings(self.pairs, len(self.points))

    @cached_property
    def quietest(self) -> float:
        """The noise level of the calmest part, see `noise_floor`."""
        return noise_floor(self.points, self.pairs, normals=self.normals, scored=self.inner)

    @cached_property
    def correlation(self) -> float:
        """The correlation of residuals of neighbours, in the calmest fifth of the points.

        It is the sum of s_i s_j over the pairs there, divided by the sum of (s_i^2 + s_j^2) / 2. s is a residual of
        `height_residuals` divided by the local deviation.
        """
        sizes = height_residuals(self.points, self.rings, self.normals)
        squares = np.minimum(np.abs(sizes), tuned.CLIP / tuned.MEDIAN_OF_NORMAL * np.median(np.abs(sizes))) ** 2
        levels = np.sqrt(local_means(squares, np.ones(len(sizes), dtype=np.bool_), self.pairs, times=3))
        calm = self.inner & (levels > 0.0) & (levels <= np.quantile(levels[self.inner], 0.2))
        a, b = self.pairs[calm[self.pairs].all(axis=1)].T
        scaled = np.clip(sizes / np.where(levels > 0.0, levels, 1.0), -tuned.CLIP, tuned.CLIP)
        facing = np.sign(np.einsum("ij,ij->i", self.normals[a], self.normals[b]))
        both = float(np.sum(scaled[a] ** 2 + scaled[b] ** 2))
        return 2.0 * float(np.sum(facing * scaled[a] * scaled[b])) / both if both else 0.0

    def without(self, held: Ints) -> tuple[Floats, Floats]:
        """Returns (k, 3) the points, with predictions at the h held-out points, and (h,) the deviations of doing nothing.

        Each held-out point moves along its normal to a quadric fitted to points that are not held out. Noise is added until the
        point is as noisy as the cloud, since filters run on noisy points. Deviations are measured from the given point, which has
        the noise s. A result at distance d from the truth deviates by s^2 + d^2 (mean square), a prediction with noise g s by
        (1 + g^2) s^2. Doing nothing is scored like a second measurement with noise s, which deviates by 2 s^2.
        """
        heights, gains = predicted_heights(self.points, self.rings, self.normals, held, mask_of(held, len(self.points)))
        sizes = heights / np.sqrt(1.0 + gains**2)
        level = float(np.median(np.abs(sizes))) / tuned.MEDIAN_OF_NORMAL
        # Uniform noise times the sign of the height: so the sign of the normal does not change the points.
        random = 2.0 * ((lengths_around(self.points, self.pairs, 1.0)[held] * 1301.0) % 1.0) - 1.0
        added = np.sqrt(3.0 * np.maximum(0.0, 1.0 - gains**2)) * level * random * np.sign(heights)
        points = self.points.copy()
        points[held] += (heights + added)[:, None] * self.normals[held]
        return points, np.sqrt(2.0) * sizes


def _patches(points: Floats, numbers: Floats) -> tuple[Floats, Ints, Bools]:
    """Returns (k, 3) all points, or patches around the points with the least `numbers`; (k,) indices; (k,) which are inner."""
    if len(points) <= _WHOLE:
        return points, np.arange(len(points), dtype=np.int32), np.ones(len(points), dtype=np.bool_)
    seeds = np.argsort(numbers, kind="stable")[:_PATCHES]
    near = spatial.cKDTree(points).query(points[seeds], _POINTS)[1]
    parts = points[near] - points[seeds, None]
    parts[:, :, 0] += 4.0 * np.abs(parts).max() * np.arange(_PATCHES)[:, None]
    return parts.reshape(-1, 3), near.astype(np.int32).ravel(), np.tile(np.arange(_POINTS) < _INNER, _PATCHES)

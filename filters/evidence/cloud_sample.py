"""A point cloud on which filters are tried: which of its points are evidence, and whether they say that it is noisy at all."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..mesh import Bools, Floats, Ints
from ..neighbours import nearest_neighbours
from ..topology import OneRings, one_rings
from .local_means import local_means
from .noise_floor import noise_floor
from .quadric_prediction import predicted_heights

# Larger clouds are sampled by so many patches of so many points, of which so many in the middle are evidence: forty neighbours of
# these lie within the patch.
_WHOLE, _PATCHES, _POINTS, _INNER = 10_000, 40, 250, 100
# As many as a mesh has.
_NEIGHBOURS = 6
# Random numbers are the fractions of these many times a length of the geometry.
_MULTIPLE, _OTHER_MULTIPLE = 1013.0, 1301.0
# Local levels of noise are averaged so many times over the neighbours; in so large a part, the calmest, neighbours are compared.
_AVERAGED, _CALMEST = 3, 0.2
# Residuals count up to so many local deviations.
_CLIP = 4.0
_MEDIAN_OF_NORMAL = 0.6745


@dataclass(frozen=True, eq=False)
class CloudSample:
    """A cloud to try filters on, its spacing 1: the median over all points of the mean distance to the six nearest.

    Attributes:
        points: (k, 3) coordinates.
        inner: (k,) the points that are evidence; their surroundings are whole.
        normals: (k, 3) unit normals of a smoothed copy, of any sign.
    """

    points: Floats
    inner: Bools
    normals: Floats

    @cached_property
    def pairs(self) -> Ints:
        """(e, 2) every pair of which one is among the six nearest of the other, once."""
        _, near = nearest_neighbours(self.points, _NEIGHBOURS)
        own = np.repeat(np.arange(len(near), dtype=np.int64), _NEIGHBOURS)
        low, high = np.minimum(own, near.ravel()), np.maximum(own, near.ravel())
        keys = np.unique(low * len(near) + high)
        return np.column_stack([keys // len(near), keys % len(near)]).astype(np.int32)

    @cached_property
    def rings(self) -> OneRings:
        """The neighbours of every point by these pairs."""
        return one_rings(self.pairs, len(self.points))

    @cached_property
    def random(self) -> Floats:
        """(k,) numbers between -1 and 1 that moving, turning, scaling and renumbering change by no more than rounding."""
        a, b = self.pairs.T
        lengths = np.linalg.norm(self.points[a] - self.points[b], axis=1)
        sums = np.bincount(self.pairs.ravel(), np.repeat(lengths, 2), len(self.points))
        return np.asarray(2.0 * ((sums * _OTHER_MULTIPLE) % 1.0) - 1.0)

    @cached_property
    def quietest(self) -> float:
        """The noise of its calmest parts, see `noise_floor`."""
        return noise_floor(self.points, self.pairs, normals=self.normals, scored=self.inner)

    @cached_property
    def correlation(self) -> float:
        """How much neighbours agree, where the cloud is calmest, in how far they are from where their surroundings expect them.

        With s = h / sqrt(1 + g^2) of `predicted_heights` over the local deviation it is the sum of s_i s_j over neighbours in
        the calmest fifth, over that of (s_i^2 + s_j^2) / 2: about -0.15 for independent noise, nearer to 0 where that is as
        strong as half a spacing, and above 0 for a surface without noise.
        """
        every = np.arange(len(self.points), dtype=np.int32)
        heights, gains = predicted_heights(self.points, self.rings, self.normals, every)
        sizes = heights / np.sqrt(1.0 + gains**2)
        squares = np.minimum(np.abs(sizes), _CLIP / _MEDIAN_OF_NORMAL * np.median(np.abs(sizes))) ** 2
        levels = np.sqrt(local_means(squares, np.ones(len(sizes), dtype=np.bool_), self.pairs, times=_AVERAGED))
        calm = self.inner & (levels > 0.0) & (levels <= np.quantile(levels[self.inner], _CALMEST))
        a, b = self.pairs[calm[self.pairs].all(axis=1)].T
        scaled = np.clip(sizes / np.where(levels > 0.0, levels, 1.0), -_CLIP, _CLIP)
        # Normals may point to either side.
        facing = np.sign(np.einsum("ij,ij->i", self.normals[a], self.normals[b]))
        both = float(np.sum(scaled[a] ** 2 + scaled[b] ** 2))
        return 2.0 * float(np.sum(facing * scaled[a] * scaled[b])) / both if both else 0.0

    def without(self, held: Ints) -> tuple[Floats, Floats]:
        """The points without some, and what it would cost to leave these where they are.

        Each of them is put, along its normal, where the quadric through the others expects it, and then off by as much as the
        noise: a filter finds points with noise, of which it sees neither how much nor where.

        Returns:
            points: (k, 3).
            costs: (h,) for each held-out point the deviation of doing nothing. A filter that is d from the truth deviates by
                e^2 = s^2 + d^2, s the noise of the held-out point. Doing nothing is s from the truth, so it deviates by 2 s^2;
                and the prediction, whose noise is g s, deviates by (1 + g^2) s^2.
        """
        hidden = np.zeros(len(self.points), dtype=np.bool_)
        hidden[held] = True
        heights, gains = predicted_heights(self.points, self.rings, self.normals, held, hidden)
        sizes = heights / np.sqrt(1.0 + gains**2)
        level = float(np.median(np.abs(sizes))) / _MEDIAN_OF_NORMAL
        # Evenly distributed noise, its sign independent of that of the normal.
        more = np.sqrt(3.0 * np.maximum(0.0, 1.0 - gains**2)) * level * self.random[held] * np.sign(heights)
        points = self.points.copy()
        points[held] += (heights + more)[:, None] * self.normals[held]
        return points, np.sqrt(2.0) * sizes


def spacing_and_numbers(points: Floats) -> tuple[float, Floats]:
    """The spacing of a cloud, and (n,) random numbers from 0 to 1 made of the distances to the six nearest points.

    Args:
        points: (n, 3) coordinates of ordinary size, at least 7.
    """
    sums = nearest_neighbours(points, _NEIGHBOURS)[0].sum(axis=1)
    spacing = float(np.median(sums)) / _NEIGHBOURS
    return spacing, (sums / (spacing or 1.0) * _MULTIPLE) % 1.0


def cloud_patches(points: Floats, numbers: Floats) -> tuple[Floats, Ints, Bools]:
    """All of a cloud of up to 10,000 points, or else 40 patches of 250, far apart: its points, their origin, and the inner ones.

    Args:
        points: (n, 3) coordinates.
        numbers: (n,) random numbers; patches lie around the points with the least.
    """
    if len(points) <= _WHOLE:
        return points, np.arange(len(points), dtype=np.int32), np.ones(len(points), dtype=np.bool_)
    parts, origins = [], []
    for seed in np.argsort(numbers, kind="stable")[:_PATCHES]:
        squared = ((points - points[seed]) ** 2).sum(axis=1)
        near = np.argpartition(squared, _POINTS)[:_POINTS]
        near = near[np.argsort(squared[near], kind="stable")]
        parts.append(points[near] - points[seed])
        origins.append(near.astype(np.int32))
    reach = max(float(np.abs(part).max()) for part in parts)
    for number, part in enumerate(parts):
        part[:, 0] += 4.0 * reach * number
    inner = np.tile(np.arange(_POINTS) < _INNER, _PATCHES)
    return np.concatenate(parts), np.concatenate(origins), inner

"""How much a point cloud is smoothed, found from the cloud alone."""

from collections.abc import Iterator
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..denoising import CloudKernels, estimated_range_sigma, normals_of, projections, unit_normals
from ..evidence import (
    Choice,
    CloudSample,
    cloud_patches,
    cross_validate,
    held_out_vertices,
    spacing_and_numbers,
    starts_of,
    trials_of,
)
from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints, check_points, normalised_mesh
from ..neighbours import nearest_neighbours
from ..robust import KernelName

# What is tried: numbers of neighbours, shares of the range sigma that is estimated for them, and up to so many iterations.
_NEIGHBORS, _SHARES, _ITERATIONS = (6, 8, 12, 18, 27, 40), (0.5, 1.0, 2.0, 4.0), 4
# Sets of held-out points, which are evidence if they are so many together.
_MASKS, _ENOUGH = 4, 30
# Of what is within so many standard errors of the best the one that does least is chosen.
_EQUAL = 1.0
# The copy whose normals say what is along and what is across the surface.
_SMOOTHED_BY, _SMOOTHED = 18, 2
# Clouds have so much noise at least, in spacings, by `CloudSample.quietest`; exact surfaces and smoothed scans less than half.
_CLEAN = 0.03
# Neighbours agree by -0.2 to -0.1 where noise is independent, by -0.05 to 0.01 where it is as strong as 0.6 spacings, and by up
# to 0.28 where it is stronger; by -0.08 to 0.07 on decimated figures, and by 0.6 on clouds too coarse for their details.
_INDEPENDENT, _SURFACE = -0.085, 0.4
# Noise of more than half a spacing has at least so much by `CloudSample.quietest`. Points nearer to each other than the noise say
# nothing of the surface; a quarter of them has half of the noise in spacings.
_THICK, _QUARTER = 0.33, 4
# Even noise is so many times what `calm` says of it.
_EVEN = 1.4


class Projection(NamedTuple):
    """A setting of `bilateral_projection`; no iterations are doing nothing."""

    neighbors: int = 0
    range_sigma: float = 0.0
    iterations: int = 0


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
    """The setting of `bilateral_projection` that best predicts points which it has not seen.

    1. A cloud is clean, and left alone, if hardly any noise is left where it is calmest, or if neighbours agree in what is left.
       Where the noise is above half a spacing a quarter of the points decides, with a quarter of the neighbours.
    2. Some points, no two of them near neighbours, are held out, see `CloudSample.without`, four times. Settings that fall behind
       are dropped, see `cross_validate`; what counts is how far along the normal the results are from the points as measured.
    3. Of the settings within one standard error of the best the one with the fewest iterations times neighbours is taken.
    4. Where neighbours agree somewhat, it must be nearer to the truth than the cloud is even if all its noise is that of the
       calmest parts.

    Args:
        points: (n, 3) coordinates.
        normals: (n, 3) of any length and sign, along which points are moved. None to estimate them.
        range_kernel: see `bilateral_projection`.
        space_kernel: likewise.
        range_sigma: in the unit of the points; the only one that is tried. None to try several.
        space_sigma: in the unit of the points. None: found for each number of neighbours.
        movable: (n,) bool, which points may move, None for all. The others are not evidence.
        seed: other points are held out for another number.
        progress: called while settings are tried; may raise to stop.

    Returns:
        The choice, doing nothing first, errors in spacings and range sigmas in the unit of the points; None where the cloud is
        clean or hardly any point can be held out. The same for any number of threads, and for the cloud moved, turned, scaled and
        renumbered.

    Raises:
        FilterInputError: not a cloud of 7 points at least, normals or `movable` that do not fit, no such kernel, a parameter out
            of range.
    """
    given = check_points(points)
    directions = None if normals is None else unit_normals(normals, len(given))
    cloud = normalised_mesh(given, np.empty((0, 3), dtype=np.int32), movable)
    kernels = CloudKernels(range_kernel, space_kernel, *(s and s * cloud.scale for s in (range_sigma, space_sigma)))
    part = _Part(cloud.points, directions, cloud.movable)
    return _choice(part, kernels, unit=1.0 / cloud.scale, most=len(given) - 1, seed=seed, progress=progress)


class _Part(NamedTuple):
    """(n, 3) points of a cloud, the (n, 3) normals that are given and (n,) which of them may move."""

    points: Floats
    normals: Floats | None
    movable: Bools | None

    def of(self, some: Ints) -> "_Part":
        return _Part(*(None if values is None else values[some] for values in self))  # type: ignore[arg-type]


def _choice(
    part: _Part, kernels: CloudKernels, *, unit: float, most: int, seed: int, progress: Progress, share: int = 1
) -> Choice[Projection] | None:
    """The choice on a part that has one point of `share`; range sigmas are then in the unit, neighbours at most so many."""
    spacing, numbers = spacing_and_numbers(part.points)
    if spacing == 0.0:
        return None
    local, origin, inner = cloud_patches(part.points / spacing, numbers)
    _, directions, moves = part.of(origin)
    sample = CloudSample(local, inner if moves is None else inner & moves, _smooth_normals(local))
    if sample.quietest < _CLEAN or sample.correlation > _SURFACE:
        return None
    if sample.quietest > _THICK and sample.correlation > _INDEPENDENT:
        quarter = np.flatnonzero(numbers < 1.0 / _QUARTER).astype(np.int32)
        if len(quarter) < _ENOUGH:
            return None
        return _choice(part.of(quarter), kernels, unit=unit, most=most, seed=seed, progress=progress, share=share * _QUARTER)
    held = [mask for mask in held_out_vertices(local, sample.pairs, scored=sample.inner, masks=_MASKS, seed=seed) if len(mask)]
    if sum(map(len, held)) < _ENOUGH:
        return None
    kernels = kernels._replace(**{name: s and s / spacing for name, s in kernels._asdict().items() if name.endswith("sigma")})
    families = [[Projection()], *_families(local, directions, kernels)]
    costs = np.zeros(len(local))

    def projected(start: Floats, first: Projection) -> Iterator[Floats]:
        its = kernels._replace(range_sigma=first.range_sigma)
        return islice(projections(start, directions, first.neighbors, its, movable=moves), _ITERATIONS)

    def run(mask: Ints) -> list[Iterator[Floats]]:
        start, costs[mask] = sample.without(mask)
        return [iter([start]), *(projected(start, family[0]) for family in families[1:])]

    def deviations(at: int, result: Floats, mask: Ints) -> Floats:
        return costs[mask] if at == 0 else np.einsum("ij,ij->i", local[mask] - result[mask], sample.normals[mask])

    tried, verdict = cross_validate(held, run, deviations, starts_of(families), progress=progress)
    every = [
        Projection(min(share * neighbors, most), sigma * spacing * unit, iterations)
        for family in families
        for neighbors, sigma, iterations in family
    ]
    trials = trials_of(every, tried, verdict)
    equal = [trial for trial, near in zip(trials, verdict.within(_EQUAL), strict=True) if near]
    chosen = min(equal, key=lambda trial: trial.label.neighbors * trial.label.iterations)
    if sample.correlation > _INDEPENDENT and chosen.error**2 >= 2.0 * (_EVEN * sample.quietest) ** 2:
        chosen = trials[0]
    return Choice(chosen, trials)


def _smooth_normals(points: Floats) -> Floats:
    """(n, 3) of the copy, or of the points themselves where these are exact or few."""
    near = min(_SMOOTHED_BY, len(points) - 1)
    smooth = (points, *islice(projections(points, None, near, CloudKernels()), _SMOOTHED))[-1]
    return normals_of(smooth, nearest_neighbours(smooth, near)[1])


def _families(points: Floats, normals: Floats | None, kernels: CloudKernels) -> list[list[Projection]]:
    """For each number of neighbours and each range sigma the settings by their iterations."""
    families = []
    for neighbors in (k for k in _NEIGHBORS if k < len(points)):
        if kernels.range_sigma is None:
            estimated = estimated_range_sigma(points, normals, neighbors, kernels.range)
            sigmas = [share * estimated for share in _SHARES if estimated > 0.0]
        else:
            sigmas = [kernels.range_sigma]
        families += [[Projection(neighbors, sigma, i + 1) for i in range(_ITERATIONS)] for sigma in sigmas]
    return families

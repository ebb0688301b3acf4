"""How much a point cloud is smoothed, found from the cloud alone."""

from collections.abc import Iterator
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..denoising import CloudKernels, estimated_range_sigma, normals_of, projections, unit_normals
from ..evidence import Choice, CloudSample, cloud_patches, hear, held_out_vertices, spacing_and_numbers, starts_of, trials_of
from ..execution import Progress, ignore_progress
from ..mesh import Floats, Ints, check_points, normalised_mesh
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
# Clouds have so much noise at least, in spacings, by `CloudSample.calm`; exact surfaces and smoothed scans less than half of it.
_CLEAN = 0.03
# Neighbours agree by -0.2 to -0.1 where noise is independent, by -0.05 to 0.01 where it is as strong as 0.6 spacings; by -0.08
# to 0.07 on decimated figures, and by 0.6 on clouds too coarse for their details.
_INDEPENDENT, _SURFACE = -0.085, 0.2
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
    2. Some points, no two of them near neighbours, are held out, see `CloudSample.without`, four times. Settings that fall behind
       are dropped, see `hear`; what counts is how far along the normal the results are from the points as they were measured.
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
    spacing, numbers = spacing_and_numbers(cloud.points)
    if spacing == 0.0:
        return None
    unit = spacing / cloud.scale
    local, origin, inner = cloud_patches(cloud.points / spacing, numbers)
    directions = None if directions is None else directions[origin]
    moves = None if cloud.movable is None else cloud.movable[origin]
    sample = CloudSample(local, inner if moves is None else inner & moves, _smooth_normals(local))
    held = [mask for mask in held_out_vertices(local, sample.pairs, scored=sample.inner, masks=_MASKS, seed=seed) if len(mask)]
    if sum(map(len, held)) < _ENOUGH or sample.calm < _CLEAN or sample.agreement > _SURFACE:
        return None
    kernels = CloudKernels(range_kernel, space_kernel, *(s and s / unit for s in (range_sigma, space_sigma)))
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

    tried, verdict = hear(held, run, deviations, starts_of(families), progress=progress)
    every = [setting._replace(range_sigma=setting.range_sigma * unit) for family in families for setting in family]
    trials = trials_of(every, tried, verdict)
    equal = [trial for trial, near in zip(trials, verdict.within(_EQUAL), strict=True) if near]
    chosen = min(equal, key=lambda trial: trial.label.neighbors * trial.label.iterations)
    if sample.agreement > _INDEPENDENT and chosen.error**2 >= 2.0 * (_EVEN * sample.calm) ** 2:
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

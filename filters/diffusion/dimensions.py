"""Giving a smoothed shape its dimensions back, locally and along its normals."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..execution import Progress, part_of
from ..geometry import vertex_normals_by_area
from ..libraries import optimize
from ..mesh import Floats, Ints

# How often a step gives back. Each time brings long waves nearer to what they were.
_TIMES = 2
# How often the loss is smoothed each time, so that hardly any noise is in it.
_PASSES = 2


def dimensions_restored(
    before: Floats, after: Floats, faces: Ints, smoothed: Callable[[Floats, Progress], Floats], progress: Progress
) -> Floats:
    """The points after a step of smoothing, moved along their normals by what their surroundings have lost in common.

    A step draws convex parts in and hollow ones out. There the loss h = (p - p') . n along the normals n of p' varies slowly,
    while on noise it changes sign from vertex to vertex. So the same smoothing S tells the two apart: p'' = p' + S(S(h)) n, and
    once more. It is twicing [tukey1977] of the shape along its normals. A sphere, whose h is constant, gets its radius back;
    a wave of a plane of which S leaves the share s comes out with 1 - (1 - s) (1 - s^2)^2.

    Args:
        before: (n, 3) p, the points before the step.
        after: (n, 3) p', the points after it.
        faces: (m, 3) triangles.
        smoothed: S for (n, 1) values, with its progress.
        progress: called every few solver steps; may raise to stop.

    Returns:
        (n, 3); vertices that the step has not moved and S leaves at 0 stay.
    """
    solves = _TIMES * _PASSES
    for time in range(_TIMES):
        normals = vertex_normals_by_area(after, faces)
        loss = np.einsum("ij,ij->i", before - after, normals)[:, None]
        for solve in range(time * _PASSES, (time + 1) * _PASSES):
            loss = smoothed(loss, part_of(progress, solve / solves, (solve + 1) / solves))
        after = after + loss * normals
    return after


def amplitude_with_dimensions(s: float) -> float:
    """What of a wave is left by a step that would leave the share `s`, where dimensions are kept."""
    return float(1.0 - (1.0 - s) * (1.0 - s**_PASSES) ** _TIMES)


def share_with_dimensions(amplitude: float) -> float:
    """The inverse of `amplitude_with_dimensions`, to rounding: the share of a step alone that leaves a wave that amplitude."""
    return float(optimize.brentq(lambda s: amplitude_with_dimensions(s) - amplitude, 0.0, 1.0, xtol=1e-15))

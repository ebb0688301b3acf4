"""Thickness of a body at its surface points, by the largest inner ball that touches the surface there."""

import numpy as np

from ..execution import Progress, ignore_progress
from ..libraries import spatial
from ..mesh import Floats

#: A ball counts if the angle between its two contacts, seen from its centre, is at least this large, in radians: then the
#: contacts lie on two sides of the body. Smaller angles are due to the curvature or the noise of one side.
LEAST_ANGLE = np.pi / 3.0
_MOST_STEPS = 30
_SAME = 1e-6  # a point counts as inside a ball if its distance from the centre is below (1 - `_SAME`) times the radius


def touching_balls(points: Floats, normals: Floats, *, largest: Floats, progress: Progress = ignore_progress) -> Floats:
    """Returns the radii of the largest balls that touch a surface at each point from behind, opposite to the normal [ma2012].

    The search starts with the largest allowed ball at the point p with normal n; its centre is p - r n. While another point q
    lies in the ball, a smaller ball through p and q replaces it, of radius r = |p - q|^2 / (2 n . (p - q)). The result is the
    last of these balls whose centre sees p and q at least `LEAST_ANGLE` apart, or else the first ball.

    Args:
        points: (n, 3) samples of the surface.
        normals: (n, 3) unit normals; a point with the normal 0 gets its largest ball.
        largest: (n,) the largest allowed radius at each point, at least 0. Smaller radii make the search faster.
        progress: called in each step with the finished share; may raise to stop.

    Returns:
        (n,) radii, at most `largest`: half of the thickness where two sides face each other.
    """
    radii, current = largest.copy(), largest.copy()
    active = np.flatnonzero((normals != 0.0).any(axis=1) & (radii > 0.0))
    if len(active) == 0:
        return radii
    tree = spatial.cKDTree(points)
    for step in range(_MOST_STEPS):
        progress(step / _MOST_STEPS)
        bound = (1.0 - _SAME) * current[active]
        centres = points[active] - current[active, None] * normals[active]
        distance, nearest = tree.query(centres, distance_upper_bound=bound.max())
        inside = distance < bound
        active, nearest = active[inside], nearest[inside]
        offset = points[active] - points[nearest]
        rise = (offset * normals[active]).sum(axis=1)
        # A point in the ball has a positive rise, except for rounding errors.
        active, offset, rise = active[rise > 0.0], offset[rise > 0.0], rise[rise > 0.0]
        if len(active) == 0:
            break
        current[active] = np.minimum((offset * offset).sum(axis=1) / (2.0 * rise), current[active])
        # From the centre, p is at r n and q at r n - (p - q).
        to_first = current[active, None] * normals[active]
        wide = (to_first * (to_first - offset)).sum(axis=1) <= np.cos(LEAST_ANGLE) * current[active] ** 2
        radii[active[wide]] = current[active[wide]]
    progress(1.0)
    return radii

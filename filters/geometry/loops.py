"""Closed polylines: (k, 3) points in order, the last joined with the first."""

import numpy as np

from ..mesh import Floats


def area_vector(loop: Floats) -> Floats:
    """(3,) half the sum of p_i x p_(i + 1): for a plane loop its area times the normal from which it is counter-clockwise."""
    centred = loop - loop.mean(axis=0)
    return np.asarray(np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0) / 2.0)


def side_lengths(loop: Floats) -> Floats:
    """(k,) the length of the side from each point to the next."""
    return np.asarray(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1))

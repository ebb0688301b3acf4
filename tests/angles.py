"""How far apart two sets of normals are."""

from __future__ import annotations

import numpy as np

from pymeshfair.filters.geometry import angles_between
from tests.meshes import Floats


def mean_angle(normals: Floats, others: Floats) -> float:
    """The mean angle between two sets of (m, 3) normals in degrees; a normal of 0 is 90 degrees from any other."""
    angles = angles_between(normals, others)
    angles[~(normals.any(axis=1) & others.any(axis=1))] = np.pi / 2
    return float(np.degrees(angles.mean()))

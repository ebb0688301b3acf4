"""How a neighbour counts in a weighted mean of normals."""

import math
from typing import NamedTuple

from ..compilation import compiled
from ..robust import KERNEL_CODES, kernel_weight

GAUSSIAN = KERNEL_CODES["gaussian"]


class Weighting(NamedTuple):
    """How neighbours are weighted, as the kernels are told; see `weighted_normals`.

    Attributes:
        range_code: of the kernel of the deviation; below 0 for a constant.
        range_scale: its scale.
        measure: how the deviation is measured: 0 the difference, 1 the angle, 2 the squared difference.
        floor: smaller deviations count as this one.
        space_code: of the kernel of the distance; below 0 for a constant.
        space_scale: its scale.
        itself: whether face i is one of its own neighbours.
    """

    range_code: int
    range_scale: float
    measure: int
    floor: float
    space_code: int
    space_scale: float
    itself: bool


@compiled(nogil=True)
def neighbour_weight(
    weight: float,
    distance: float,
    deviation: float,
    range_code: int,
    range_scale: float,
    measure: int,
    floor: float,
    space_code: int,
    space_scale: float,
    per_space: float,
) -> float:
    """The weight times both kernels, of the squared distance of two centres and the squared difference of two normals.

    `per_space` is 1 / space_scale^2, which callers find once for all neighbours; where both are Gaussians they take one
    exponential instead.
    """
    if range_code >= 0:
        if measure == 0:
            deviation = math.sqrt(deviation)
        elif measure == 1:
            deviation = 2.0 * math.asin(min(1.0, 0.5 * math.sqrt(deviation)))
        weight *= kernel_weight(range_code, max(deviation, floor), range_scale)
    if space_code >= 0 and weight > 0.0:
        if space_code == GAUSSIAN:
            weight *= math.exp(-distance * per_space)
        else:
            weight *= kernel_weight(space_code, math.sqrt(distance), space_scale)
    return weight

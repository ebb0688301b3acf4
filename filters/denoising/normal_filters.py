"""Filters of face normals: every normal becomes a weighted mean of those around it."""

import math
from typing import Literal, TypeAlias, get_args

import numpy as np

from ..checks import check_choice, check_finite
from ..compilation import compiled
from ..execution import over_range
from ..geometry import NORMAL
from ..mesh import Floats, Ints, Longs
from ..robust import KERNEL_CODES, KERNEL_NAMES, KernelName
from .border_trend import follow_trend
from .face_neighbourhoods import FaceNeighbourhoods
from .neighbour_weights import Weighting, faces_with_room, make_room, neighbour_weights, room_for

#: Kernels of the distance between centres: those of the table, or none at all.
SpaceKernel: TypeAlias = KernelName | Literal["constant"]
SPACE_KERNELS: tuple[str, ...] = ("constant", *KERNEL_NAMES)

#: The deviation x of a normal from another: "euclidean" |n - m| (0 to 2), "angle" (0 to pi), "squared" |n - m|^2 (0 to 4).
RangeMeasure: TypeAlias = Literal["euclidean", "angle", "squared"]

_CONSTANT = -1
_MEASURE_CODES: dict[str, int] = {name: code for code, name in enumerate(get_args(RangeMeasure))}


def weighted_normals(
    normals: Floats,
    table: Floats,
    neighbourhoods: FaceNeighbourhoods,
    *,
    guide: Floats | None = None,
    range_kernel: KernelName | Literal["constant"] = "gaussian",
    range_sigma: float = 0.35,
    range_measure: RangeMeasure = "euclidean",
    range_floor: float = 0.0,
    space_kernel: SpaceKernel = "gaussian",
    space_sigma: float = 1.0,
    itself: bool = False,
    cut_off: Ints | None = None,
    overwrite: bool = False,
) -> Floats:
    """One pass of n_i' = normalise(sum_j A_j f(|c_i - c_j|) g(x_ij) n_j).

    The Gaussian is exp(-x^2 / (2 sigma^2)) here as in the literature on bilateral filters, so its sigma is a standard deviation,
    1 / sqrt 2 of that of `robust`. All other kernels are as there.

    Args:
        normals: (m, 3) the normals n to average.
        table: (m, 8) of `measure_faces`: areas A and centres c.
        neighbourhoods: which faces j are averaged over.
        guide: (m, 3) the normals on which the deviation x_ij is measured; None for n themselves.
        range_kernel: g. "constant" gives every neighbour the same weight, whatever its direction.
        range_sigma: its scale, in the unit of the measure. Larger averages across sharper features.
        range_measure: how x_ij is measured.
        range_floor: smaller deviations count as this one, in the unit of the measure. Kernels such as 1 / x otherwise let two
            faces that happen to agree hold each other, against all others.
        space_kernel: f.
        space_sigma: its scale, in the unit of the centres. Larger smooths larger details, as far as the neighbourhood reaches.
        itself: whether face i is one of its own neighbours.
        cut_off: faces whose neighbours lie to one side, at which the mean follows a trend, see `follow_trend`; None for none.
        overwrite: whether the normals of the table may be overwritten, which saves a copy of it.

    Returns:
        (m, 3) unit normals; where all weights are 0 the normal as it was.
    """
    check_choice("range_kernel", range_kernel, SPACE_KERNELS)
    check_choice("space_kernel", space_kernel, SPACE_KERNELS)
    check_choice("range_measure", range_measure, RangeMeasure)
    for name, number in (("range_sigma", range_sigma), ("space_sigma", space_sigma), ("range_floor", range_floor)):
        check_finite(name, number, least=0.0)
    result = np.empty_like(normals)
    # One row of 8 numbers, the guide in the place of the table's normal, is all that the kernel fetches of a guide's neighbour.
    rows = _with_normals(table, normals if guide is None else guide, overwrite)
    weighting = Weighting(
        _code(range_kernel),
        _scale(range_kernel, range_sigma),
        _MEASURE_CODES[range_measure],
        range_floor,
        _code(space_kernel),
        _scale(space_kernel, space_sigma),
        itself,
    )
    size = room_for(neighbourhoods.offsets, itself)
    over_range(_weighted_means, len(normals), normals, rows, guide is None, neighbourhoods, weighting, size, result)
    if cut_off is not None:
        follow_trend(result, cut_off, normals, rows, neighbourhoods, weighting)
    return result


def mean_normals(normals: Floats, table: Floats, neighbourhoods: FaceNeighbourhoods, *, overwrite: bool = False) -> Floats:
    """(m, 3) the mean of each normal and its neighbours', weighted by area alone [belyaev2001].

    `overwrite` as in `weighted_normals`.
    """
    result = np.empty_like(normals)
    rows = _with_normals(table, normals, overwrite)
    over_range(_means, len(normals), rows, *neighbourhoods, result)
    return result


def _with_normals(table: Floats, normals: Floats, overwrite: bool) -> Floats:
    """(m, 8) the table with other normals."""
    rows = table if overwrite else table.copy()
    rows[:, NORMAL] = normals
    return rows


def _code(kernel: str) -> int:
    return _CONSTANT if kernel == "constant" else KERNEL_CODES[kernel]  # type: ignore[index]


def _scale(kernel: str, sigma: float) -> float:
    scale = math.sqrt(2.0) * sigma if kernel == "gaussian" else sigma
    # With a scale of 0 nothing but equal normals count.
    return max(scale, 1e-150)


# A kernel of its own, without the distances and deviations of the next.
@compiled(nogil=True)
def _means(rows: Floats, offsets: Longs, neighbours: Ints, result: Floats, first: int, last: int) -> None:
    for i in range(first, last):
        x, y, z = rows[i, 3] * rows[i, 0], rows[i, 3] * rows[i, 1], rows[i, 3] * rows[i, 2]
        for k in range(offsets[i], offsets[i + 1]):
            j = neighbours[k]
            x += rows[j, 3] * rows[j, 0]
            y += rows[j, 3] * rows[j, 1]
            z += rows[j, 3] * rows[j, 2]
        length = math.sqrt(x * x + y * y + z * z)
        if length > 1e-300:
            result[i, 0], result[i, 1], result[i, 2] = x / length, y / length, z / length
        else:
            result[i, 0], result[i, 1], result[i, 2] = rows[i, 0], rows[i, 1], rows[i, 2]


@compiled(nogil=True)
def _weighted_means(
    normals: Floats,
    rows: Floats,
    unguided: bool,
    neighbourhoods: FaceNeighbourhoods,
    weighting: Weighting,
    size: int,
    result: Floats,
    first: int,
    last: int,
) -> None:
    room = make_room(size)
    near, weights, offsets, itself = room.near, room.weights, neighbourhoods.offsets, weighting.itself
    begin = first
    while begin < last:
        end = faces_with_room(offsets, begin, last, itself, size)
        neighbour_weights(begin, end, rows, neighbourhoods, weighting, room)
        stop = np.uint64(0)
        for i in range(np.uint64(begin), np.uint64(end)):
            start = stop
            stop += np.uint64(offsets[i + np.uint64(1)] - offsets[i]) + np.uint64(itself)
            x = y = z = 0.0
            for k in range(start, stop):
                j, weight = np.uint32(near[k]), weights[k]
                if unguided:
                    x += weight * rows[j, 0]
                    y += weight * rows[j, 1]
                    z += weight * rows[j, 2]
                else:
                    x += weight * normals[j, 0]
                    y += weight * normals[j, 1]
                    z += weight * normals[j, 2]
            length = math.sqrt(x * x + y * y + z * z)
            if length > 1e-300:
                result[i, 0], result[i, 1], result[i, 2] = x / length, y / length, z / length
            else:
                result[i, 0], result[i, 1], result[i, 2] = normals[i, 0], normals[i, 1], normals[i, 2]
        begin = end

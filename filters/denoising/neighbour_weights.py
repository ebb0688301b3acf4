"""Weights of neighbours in means of normals: kernels with their scales, checked or estimated from the data."""

import math
from typing import NamedTuple

import numpy as np

from ..checks import FilterInputError, check_choice, check_positive
from ..compilation import compiled
from ..mesh import Floats, Ints, Longs
from ..robust import KERNEL_CODES, KERNEL_NAMES, SIGMA_IN_DEVIATIONS, KernelName, exponential, robust_deviation, weigh
from .face_neighbourhoods import FaceNeighbourhoods

#: How far a space kernel reaches, in its sigma. A Gaussian exp(-x^2 / (2 s^2)) is our kernel "gaussian" with sigma = sqrt(2) s:
#: this is the distance 2 s at which the papers cut it off.
REACH = math.sqrt(2.0)
# Larger scales are refused: their squares would overflow.
_EXTREME = 1e150


class Term(NamedTuple):
    """A kernel by its number, and its scale in the unit of the coordinates that it is applied to."""

    code: int
    sigma: float


def space_term(kernel: KernelName, sigma: float | None, scale: float, automatic: float) -> Term:
    """The kernel of distances.

    Args:
        kernel: its name.
        sigma: its scale in mesh units; None for the automatic one.
        scale: how long one mesh unit is in the coordinates that the kernel is applied to.
        automatic: the automatic sigma, in these coordinates.
    """
    check_choice("space_kernel", kernel, KERNEL_NAMES)
    return Term(KERNEL_CODES[kernel], _scaled("space_sigma", sigma, scale, automatic))


def range_term(kernel: KernelName, sigma: float | None, scale: float, heights: Floats, share: float) -> Term:
    """The kernel of heights; arguments as `space_term`.

    The automatic sigma is a share of `SIGMA_IN_DEVIATIONS` times the deviation of the heights of neighbours. Most of a surface
    being smooth, the median of their sizes is that of noise, not of features. A term with sigma 0 comes from heights that are all
    0 but for the rounding of coordinates, of which the largest are about 1: there is nothing to remove.
    """
    check_choice("range_kernel", kernel, KERNEL_NAMES)
    deviation = robust_deviation(heights) if sigma is None and len(heights) else 0.0
    if deviation < np.finfo(np.float64).eps:
        deviation = 0.0
    return Term(KERNEL_CODES[kernel], _scaled("range_sigma", sigma, scale, share * SIGMA_IN_DEVIATIONS[kernel] * deviation))


def _scaled(name: str, sigma: float | None, scale: float, automatic: float) -> float:
    if sigma is None:
        return automatic
    scaled = check_positive(name, sigma, note="; None takes it from the mesh") * scale
    if not 1.0 / _EXTREME < scaled < _EXTREME:
        raise FilterInputError(f"{name} {sigma} is out of all proportion to the mesh; None takes it from the mesh")
    return scaled


_GAUSSIAN = KERNEL_CODES["gaussian"]
# Weights of about so many neighbours are found at once: few enough to stay at hand.
_MORE = 256


class Weighting(NamedTuple):
    """How neighbours are weighted, as the kernels are told; see `weighted_normals`."""

    range_code: int  # of the kernel of the deviation; below 0 for a constant
    range_scale: float  # its scale
    measure: int  # how the deviation is measured: 0 the difference, 1 the angle, 2 the squared difference
    floor: float  # smaller deviations count as this one
    space_code: int  # of the kernel of the distance; below 0 for a constant
    space_scale: float  # its scale
    itself: bool  # whether face i is one of its own neighbours


class Room(NamedTuple):
    """Arrays for what `neighbour_weights` finds."""

    near: Ints  # the neighbours
    weights: Floats  # their weights
    squares: Floats  # of the deviations of their normals
    distances: Floats  # squared, of their centres


@compiled(nogil=True)
def make_room(size: int) -> Room:
    """For so many neighbours."""
    return Room(np.empty(size, np.int32), np.empty(size), np.empty(size), np.empty(size))


def room_for(offsets: Longs, itself: bool) -> int:
    """How many neighbours the arrays of `neighbour_weights` must hold: those of any one face, and some more."""
    return _MORE + int(np.diff(offsets).max(initial=0)) + itself


@compiled(nogil=True)
def faces_with_room(offsets: Longs, first: int, last: int, itself: bool, room: int) -> int:
    """The end of the faces, from `first` and up to `last`, whose neighbours have room; that of one face at least."""
    stop = first + 1
    while stop < last and offsets[stop + 1] - offsets[first] + (stop + 1 - first if itself else 0) <= room:
        stop += 1
    return stop


# Each step is a loop of its own over arrays in a row, which is done for several neighbours at once. Short loops take longer: so
# it goes over the neighbours of several faces. Unsigned indices need no look whether they count from the end.
@compiled(nogil=True, error_model="numpy")
def neighbour_weights(
    first: int, last: int, rows: Floats, neighbourhoods: FaceNeighbourhoods, weighting: Weighting, room: Room
) -> int:
    """The neighbours of some faces, of one after the other, and their weights: their areas times both kernels.

    Args:
        first: the number of the first face.
        last: of that after the last one, as `faces_with_room` says.
        rows: (m, 8) of `measure_faces`, with the normals on which deviations are measured.
        neighbourhoods: which are the neighbours.
        weighting: the kernels; a face that is its own neighbour is the first.
        room: for `room_for` neighbours, overwritten.

    Returns:
        How many they are.
    """
    offsets, neighbours = neighbourhoods
    range_code, range_scale, measure, floor, space_code, space_scale, itself = weighting
    near, weights, squares, distances = room
    count = np.uint64(0)
    for i in range(np.uint64(first), np.uint64(last)):
        start, stop = np.uint64(offsets[i]), np.uint64(offsets[i + np.uint64(1)])
        of_face = count
        if itself:
            near[count] = i
            count += np.uint64(1)
        for k in range(start, stop):
            near[count] = neighbours[k]
            count += np.uint64(1)
        gx, gy, gz = rows[i, 0], rows[i, 1], rows[i, 2]
        cx, cy, cz = rows[i, 4], rows[i, 5], rows[i, 6]
        for k in range(of_face, count):
            j = np.uint32(near[k])
            dx, dy, dz = rows[j, 4] - cx, rows[j, 5] - cy, rows[j, 6] - cz
            rx, ry, rz = rows[j, 0] - gx, rows[j, 1] - gy, rows[j, 2] - gz
            weights[k] = rows[j, 3]
            distances[k], squares[k] = dx * dx + dy * dy + dz * dz, rx * rx + ry * ry + rz * rz
    per_space, per_range = 1.0 / (space_scale * space_scale), 1.0 / (range_scale * range_scale)
    if range_code == space_code == _GAUSSIAN and measure == 0 and floor == 0.0:
        for k in range(count):
            weights[k] *= exponential(-(distances[k] * per_space + squares[k] * per_range))
        return int(count)
    if measure == 1:
        for k in range(count):
            squares[k] = (2.0 * math.asin(min(1.0, 0.5 * math.sqrt(squares[k])))) ** 2
    elif measure == 2:
        for k in range(count):
            squares[k] *= squares[k]
    if space_code != _GAUSSIAN:
        per_space = 0.0
    if range_code >= 0:
        weigh(weights, range_code, range_scale, squares, floor, distances, per_space, int(count))
    elif space_code == _GAUSSIAN:
        for k in range(count):
            weights[k] *= exponential(-distances[k] * per_space)
    if space_code >= 0 and space_code != _GAUSSIAN:
        weigh(weights, space_code, space_scale, distances, 0.0, squares, 0.0, int(count))
    return int(count)

"""Filters of face normals: settings, weights, and the weighted mean of the normals around each face."""

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from ..checks import check_choice, check_finite, check_positive, check_whole_number
from ..compilation import compiled
from ..execution import over_range
from ..geometry import NORMAL
from ..mesh import Floats, Ints, Longs
from ..robust import KERNEL_CODES, KERNEL_NAMES, KernelName, exponential, weigh
from .face_neighbourhoods import FaceNeighbourhoods, Neighborhood

#: Kernels of the distance between face centres: an M-estimator, or "constant" for no kernel.
SpaceKernel: TypeAlias = KernelName | Literal["constant"]
SPACE_KERNELS: tuple[str, ...] = ("constant", *KERNEL_NAMES)

#: The deviation x of two normals n and m: "euclidean" |n - m| (0 to 2), "angle" (0 to pi), "squared" |n - m|^2 (0 to 4).
RangeMeasure: TypeAlias = Literal["euclidean", "angle", "squared"]

#: "mean": the weight is the area [belyaev2001]. "unilateral": area times a kernel of the deviation of normals [yadav2021].
#: "bilateral": the unilateral weight times a kernel of the distance [zheng2011]. "averaged": bilateral, but the deviations are
#: those of normals averaged over "vertex" neighbourhoods. "guided": bilateral, but with deviations of guide normals [zhang2015].
NormalFilterMethod: TypeAlias = Literal["mean", "unilateral", "bilateral", "averaged", "guided"]
_GAUSSIAN = KERNEL_CODES["gaussian"]
# About this number of neighbours is weighted at once: few enough to stay in the cache.
_BATCH = 256
# The ridge of the trend fit, as a share of the trace of the second moments. It suppresses a trend across a single row of faces.
_RIDGE = 0.02
# The factor of s^2 in `_follow_trend` [james1961].
_SHRINKAGE = 2.0
# Coefficients of a trend along the surface for each component of the normal: a value and two slopes.
_COEFFICIENTS = 3.0


@dataclass(frozen=True, kw_only=True)
class NormalFilter:
    """Settings of n_i <- normalise(sum_j A_j f(|c_i - c_j|) g(x_ij) n_j), repeated `normal_iterations` times.

    The sum goes over the faces j around face i, with area A and centre c; x_ij is the deviation of their normals, see
    `weighted_normals`. If a border cuts off the neighbourhood, the mean follows the trend of the normals, see `_follow_trend`;
    not for "mean". The defaults are those of the authors' code of [zheng2011].

    Attributes:
        method: definition of the weights; see `NormalFilterMethod`.
        range_kernel: g; not used by "mean". Kernels that reach 0 ("truncated_l1", "truncated_l2", "tukey", "hampel") keep edges;
            "huber", "lorentzian" and "gaussian" suit smooth shapes.
        space_kernel: f; not used by "mean" and "unilateral".
        range_measure: definition of the deviation x of two normals.
        range_sigma: the scale of g, in the unit of the measure; the standard deviation for "gaussian". A larger scale smooths
            more, and across sharper features.
        range_floor: lower bound of the deviations, in the unit of the measure. "l1" and "truncated_l1" have the weight 1 / x and
            would lock two normals that agree by chance; a bound such as 0.03 prevents this.
        space_sigma: the scale of f, in mean distances of the centres of faces that share an edge; the standard deviation for
            "gaussian". A larger scale smooths larger details, as far as the neighbourhood reaches.
        neighborhood: the faces to average over; see `Neighborhood`. More faces smooth larger details and take more time.
        radius: radius of the neighbourhoods "radius" and "geodesic", in mean distances of centres of adjacent input faces.
        normal_iterations: number of filter passes. More passes smooth more.

    Raises:
        FilterInputError: a value that is not allowed.
    """

    method: NormalFilterMethod = "bilateral"
    range_kernel: KernelName = "gaussian"
    space_kernel: SpaceKernel = "gaussian"
    range_measure: RangeMeasure = "euclidean"
    range_sigma: float = 0.35
    range_floor: float = 0.0
    space_sigma: float = 1.0
    neighborhood: Neighborhood = "vertex"
    radius: float = 2.0
    normal_iterations: int = 20

    def __post_init__(self) -> None:
        check_choice("method", self.method, NormalFilterMethod)
        check_choice("range_kernel", self.range_kernel, KERNEL_NAMES)
        check_choice("space_kernel", self.space_kernel, SPACE_KERNELS)
        check_choice("range_measure", self.range_measure, RangeMeasure)
        check_choice("neighborhood", self.neighborhood, Neighborhood)
        check_positive("range_sigma", self.range_sigma)
        check_finite("range_floor", self.range_floor, least=0.0)
        check_positive("space_sigma", self.space_sigma)
        check_positive("radius", self.radius)
        check_whole_number("normal_iterations", self.normal_iterations)

    @property
    def ignores_numbers_of_faces(self) -> bool:
        """Whether another order of faces in memory changes no bit, see `Adjacency.of`: not with 'guided'."""
        return self.method != "guided"


class Weighting(NamedTuple):
    """The weights of neighbours, in the form that the kernels need."""

    range_code: int  # code of the range kernel
    range_scale: float
    measure: int  # index in `RangeMeasure`
    floor: float  # lower bound of the deviations
    space_code: int  # code of the space kernel; below 0 for a constant
    space_scale: float  # in the unit of the centres
    itself: bool  # whether a face is one of its own neighbours

    @staticmethod
    def of(settings: NormalFilter, distance: float) -> "Weighting":
        """Returns the weighting for a mean centre distance. A Gaussian's sigma is a standard deviation, unlike in `robust`."""
        space = "constant" if settings.method == "unilateral" else settings.space_kernel
        return Weighting(
            KERNEL_CODES[settings.range_kernel],
            _scale(settings.range_kernel, settings.range_sigma),
            get_args(RangeMeasure).index(settings.range_measure),
            float(settings.range_floor),
            -1 if space == "constant" else KERNEL_CODES[space],
            _scale(space, settings.space_sigma * distance),
            settings.method in ("averaged", "guided"),
        )


def _scale(kernel: str, sigma: float) -> float:
    scale = math.sqrt(2.0) * sigma if kernel == "gaussian" else float(sigma)
    # The lower bound keeps squares of values over the scale finite.
    return max(scale, 1e-150)


def weighted_normals(
    normals: Floats,
    table: Floats,
    neighbourhoods: FaceNeighbourhoods,
    weighting: Weighting,
    *,
    guide: Floats | None = None,
    cut_off: Ints | None = None,
) -> Floats:
    """Returns (m, 3) n_i' = normalise(sum_j A_j f(|c_i - c_j|) g(x_ij) n_j); a normal stays if its sum is 0.

    The (m, 8) table of `measure_faces` has A and c; its normals are overwritten. x_ij is the deviation of the (m, 3)
    `guide` normals if given, else of the normals. At faces `cut_off` by a border the mean follows a trend, see `_follow_trend`.
    """
    result = np.empty_like(normals)
    # With the normals in the table, the kernel reads nearly all data of a neighbour from one row.
    table[:, NORMAL] = normals if guide is None else guide
    # The arrays of `_neighbour_weights` have room for the largest neighbourhood and `_BATCH` more neighbours.
    size = _BATCH + int(np.diff(neighbourhoods.offsets).max(initial=0)) + weighting.itself
    arguments = table if guide is None else normals, table, neighbourhoods, weighting, size, result
    over_range(_weighted_means, len(normals), *arguments)
    if cut_off is not None and len(cut_off):
        over_range(_follow_trend, len(cut_off), cut_off, *arguments)
    return result


def mean_normals(normals: Floats, table: Floats, neighbourhoods: FaceNeighbourhoods) -> Floats:
    """Returns (m, 3) the mean of each normal and its neighbours, weighted by area [belyaev2001]; see `weighted_normals`."""
    result = np.empty_like(normals)
    table[:, NORMAL] = normals
    over_range(_means, len(normals), table, *neighbourhoods, result)
    return result


# A separate kernel, since this mean needs neither distances nor deviations.
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
    normals: Floats, rows: Floats, around: FaceNeighbourhoods, weighting: Weighting, size: int, out: Floats, first: int, last: int
) -> None:
    room = _make_room(size)
    near, weights, offsets, itself = room.near, room.weights, around.offsets, weighting.itself
    begin = first
    while begin < last:
        end = _faces_with_room(offsets, begin, last, itself, size)
        _neighbour_weights(begin, end, rows, around, weighting, room)
        stop = np.uint64(0)
        for i in range(np.uint64(begin), np.uint64(end)):
            start = stop
            stop += np.uint64(offsets[i + np.uint64(1)] - offsets[i]) + np.uint64(itself)
            x = y = z = 0.0
            for k in range(start, stop):
                j, weight = np.uint32(near[k]), weights[k]
                x += weight * normals[j, 0]
                y += weight * normals[j, 1]
                z += weight * normals[j, 2]
            length = math.sqrt(x * x + y * y + z * z)
            if length > 1e-300:
                out[i, 0], out[i, 1], out[i, 2] = x / length, y / length, z / length
            else:
                out[i, 0], out[i, 1], out[i, 2] = normals[i, 0], normals[i, 1], normals[i, 2]
        begin = end


class _Room(NamedTuple):
    """Work arrays of `_neighbour_weights`."""

    near: Ints  # the neighbours
    weights: Floats
    squares: Floats  # squared deviations of normals
    distances: Floats  # squared distances of centres


@compiled(nogil=True)
def _make_room(size: int) -> _Room:
    return _Room(np.empty(size, np.int32), np.empty(size), np.empty(size), np.empty(size))


@compiled(nogil=True)
def _faces_with_room(offsets: Longs, first: int, last: int, itself: bool, room: int) -> int:
    """Returns the end of the longest range of faces from `first` whose neighbours fit into the arrays; at least one face."""
    stop = first + 1
    while stop < last and offsets[stop + 1] - offsets[first] + (stop + 1 - first if itself else 0) <= room:
        stop += 1
    return stop


# Each step is a separate loop over contiguous arrays, which the compiler vectorises. The loop covers the neighbours of several
# faces, since short loops are slower. Unsigned indices save the test for negative indices.
@compiled(nogil=True, error_model="numpy")
def _neighbour_weights(
    first: int, last: int, rows: Floats, neighbourhoods: FaceNeighbourhoods, weighting: Weighting, room: _Room
) -> int:
    """Fills `room` with the neighbours of faces (if `itself`, each face first) and their weights; returns their number."""
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
    weigh(weights, range_code, range_scale, squares, floor, distances, per_space, int(count))
    if space_code >= 0 and space_code != _GAUSSIAN:
        weigh(weights, space_code, space_scale, distances, 0.0, squares, 0.0, int(count))
    return int(count)


@compiled(nogil=True)
def _follow_trend(
    faces: Ints,
    normals: Floats,
    rows: Floats,
    around: FaceNeighbourhoods,
    weighting: Weighting,
    size: int,
    out: Floats,
    first: int,
    last: int,
) -> None:
    """Moves the weighted mean normal of each face in `faces` towards the value of a linear fit at the face centre.

    With the weights w_j of the mean and x_j = c_j - c_i, least squares fit the normals n_j by b + G x_j, with a ridge on G
    [cleveland1979]. The mean a differs from the fit b by G times the mean of x_j, and at a border this mean is far from 0. The
    residuals give the variance s^2 of b - a. The result is a + max(0, 1 - 2 s^2 / |b - a|^2) (b - a): a if no trend is clear.
    """
    room = _make_room(size)
    x, mean_x, solved, mean, at_face = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    second, mixed, trend = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for at in range(first, last):
        i = faces[at]
        count = _neighbour_weights(i, i + 1, rows, around, weighting, room)
        total = squares = 0.0
        mean[:], mean_x[:], second[:], mixed[:] = 0.0, 0.0, 0.0, 0.0
        for k in range(count):
            j, weight = room.near[k], room.weights[k]
            total += weight
            squares += weight * weight
            for u in range(3):
                x[u] = rows[j, 4 + u] - rows[i, 4 + u]
                weighted = weight * x[u]
                mean[u] += weight * normals[j, u]
                mean_x[u] += weighted
                for v in range(3):
                    mixed[u, v] += weighted * normals[j, v]
            for u in range(3):
                for v in range(u + 1):
                    second[u, v] += weight * x[v] * x[u]
        ridge = _RIDGE * (second[0, 0] + second[1, 1] + second[2, 2])
        for u in range(3):
            second[u, u] += ridge
        # The effective number of neighbours: the weighted mean has the variance of a mean of this many normals.
        number = total * total / squares if squares > 0.0 else 0.0
        if not (number > _COEFFICIENTS and ridge > 0.0):
            continue
        _factor(second)
        _solve(second, mean_x, solved)
        leverage = (solved[0] * mean_x[0] + solved[1] * mean_x[1] + solved[2] * mean_x[2]) / total
        if not leverage < 1.0:
            continue
        shift = residual = 0.0
        for v in range(3):
            pulled = solved[0] * mixed[0, v] + solved[1] * mixed[1, v] + solved[2] * mixed[2, v]
            at_face[v] = (mean[v] - pulled) / (total * (1.0 - leverage))
            for u in range(3):
                x[u] = mixed[u, v] - mean_x[u] * at_face[v]
            _solve(second, x, trend[v])
            for u in range(3):
                residual -= trend[v, u] * (x[u] + ridge * trend[v, u])
            mean[v] /= total
            # Normals have length 1, so the sum of their weighted squares is the total weight.
            residual += total * (at_face[v] * at_face[v] - 2.0 * at_face[v] * mean[v])
            shift += (at_face[v] - mean[v]) * (at_face[v] - mean[v])
        residual = max(0.0, (residual + total) / total)
        variance = residual / (number - _COEFFICIENTS) * leverage / (1.0 - leverage)
        share = 1.0 - _SHRINKAGE * variance / shift if shift > 0.0 else 0.0
        if not share > 0.0:
            continue
        for v in range(3):
            mean[v] += share * (at_face[v] - mean[v])
        length = math.sqrt(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2])
        if length > 1e-300:
            for v in range(3):
                out[i, v] = mean[v] / length


@compiled(nogil=True)
def _factor(matrix: Floats) -> None:
    """Replaces the lower triangle of a positive definite matrix by its Cholesky factor."""
    for a in range(3):
        for b in range(a + 1):
            remainder = matrix[a, b]
            for c in range(b):
                remainder -= matrix[a, c] * matrix[b, c]
            matrix[a, b] = math.sqrt(remainder) if a == b else remainder / matrix[b, b]


@compiled(nogil=True)
def _solve(factor: Floats, side: Floats, solution: Floats) -> None:
    for a in range(3):
        solution[a] = side[a]
        for b in range(a):
            solution[a] -= factor[a, b] * solution[b]
        solution[a] /= factor[a, a]
    for a in range(2, -1, -1):
        for b in range(a + 1, 3):
            solution[a] -= factor[b, a] * solution[b]
        solution[a] /= factor[a, a]

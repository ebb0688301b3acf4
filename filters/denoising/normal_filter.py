"""Filters of face normals: every normal becomes a weighted mean of those around it. The settings, the weights, the mean.

At borders, where a one-sided mean is biased inwards, a local linear fit takes its place.
"""

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
from .face_neighbourhoods import RINGS_OF_NEIGHBORHOOD, FaceNeighbourhoods, Neighborhood

#: Kernels of the distance between centres: those of the table, or none at all.
SpaceKernel: TypeAlias = KernelName | Literal["constant"]
SPACE_KERNELS: tuple[str, ...] = ("constant", *KERNEL_NAMES)

#: The deviation x of a normal from another: "euclidean" |n - m| (0 to 2), "angle" (0 to pi), "squared" |n - m|^2 (0 to 4).
RangeMeasure: TypeAlias = Literal["euclidean", "angle", "squared"]

#: "mean": weights are areas alone [belyaev2001]. "unilateral": areas and a kernel of the deviation of normals [yadav2021].
#: "bilateral": and a kernel of the distance [zheng2011]. "averaged": bilateral, the deviation measured on normals averaged over
#: the faces at the vertices of a face. "guided": bilateral, the deviation measured on guide normals [zhang2015].
#: "vertex_normals": bilateral, on the normals of vertices; a face gets the mean of its corners'. It is there to compare with.
NormalFilterMethod: TypeAlias = Literal["mean", "unilateral", "bilateral", "averaged", "guided", "vertex_normals"]
_GAUSSIAN = KERNEL_CODES["gaussian"]
# Weights of about so many neighbours are found at once: few enough to stay at hand.
_MORE = 256
# To the second moments of the centres is added this share of their sum, so that faces in a row have a trend along it alone.
_RIDGE = 0.02
# The part of the shift by the trend that is taken away is 1 - this times its variance over its square, or none [james1961].
_DOUBT = 2.0
# A trend has three numbers a component.
_NUMBERS = 3.0


@dataclass(frozen=True, kw_only=True)
class NormalFilter:
    """How face normals are filtered: n_i <- normalise(sum_j A_j f(|c_i - c_j|) g(x_ij) n_j), `normal_iterations` times.

    The sum goes over the faces j around face i, of area A and centre c; x_ij is the deviation of their normals; see
    `weighted_normals`. Where a border cuts these faces off the mean follows the trend of the normals, see `_follow_trend`. The
    defaults are those of [zheng2011] in their authors' code.

    Attributes:
        method: how weights come about; see `NormalFilterMethod`.
        range_kernel: g; not used by "mean". Kernels that reach 0 ("truncated_l1", "truncated_l2", "tukey") keep edges; "huber",
            "lorentzian" and "gaussian" suit smooth shapes.
        space_kernel: f; not used by "mean" and "unilateral".
        range_measure: how the deviation x of two normals is measured.
        range_sigma: the scale of g, in the unit of the measure. Larger smooths more and across sharper features. For "gaussian"
            the standard deviation.
        range_floor: smaller deviations count as this one, in the unit of the measure. Above 0 it keeps "l1" and "truncated_l1",
            whose weight is 1 / x, from locking the normals of two faces that happen to agree; 0.03 does them good.
        space_sigma: the scale of f, in mean distances of the centres of faces that share an edge. Larger smooths larger details,
            as far as the neighbourhood reaches. For "gaussian" the standard deviation.
        neighborhood: which faces are averaged over; see `Neighborhood`. Larger smooths larger details, and costs in proportion.
            With "vertex_normals" rings of vertices: one for "edge" and "vertex", two, or three; distances are then in mean edges.
        radius: for the neighbourhoods "radius" and "geodesic", in mean distances of the centres of the input.
        normal_iterations: filter passes. More smooth more.

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
        if self.method == "vertex_normals":
            check_choice("neighborhood of the method 'vertex_normals'", self.neighborhood, tuple(RINGS_OF_NEIGHBORHOOD))

    @property
    def ignores_numbers_of_faces(self) -> bool:
        """Whether results have the same bits however faces are numbered: 'guided' takes the lowest, 'vertex_normals' sums up."""
        return self.method not in ("guided", "vertex_normals")


class Weighting(NamedTuple):
    """How neighbours are weighted, as the kernels are told."""

    range_code: int  # of the kernel of the deviation
    range_scale: float
    measure: int  # how the deviation is measured, by its place in `RangeMeasure`
    floor: float  # smaller deviations count as this one
    space_code: int  # of the kernel of the distance; below 0 for a constant
    space_scale: float  # in the unit of the centres
    itself: bool  # whether face i is one of its own neighbours

    @staticmethod
    def of(settings: NormalFilter, distance: float) -> "Weighting":
        """That of a filter, for a mean distance of centres; a Gaussian's sigma is a standard deviation, unlike in `robust`."""
        space = "constant" if settings.method == "unilateral" else settings.space_kernel
        return Weighting(
            KERNEL_CODES[settings.range_kernel],
            _scale(settings.range_kernel, settings.range_sigma),
            get_args(RangeMeasure).index(settings.range_measure),
            float(settings.range_floor),
            -1 if space == "constant" else KERNEL_CODES[space],
            _scale(space, settings.space_sigma * distance),
            # A normal deviates from itself by 0, which outweighs all others in a kernel such as 1 / x; a guide is a mean.
            settings.method in ("averaged", "guided"),
        )


def _scale(kernel: str, sigma: float) -> float:
    scale = math.sqrt(2.0) * sigma if kernel == "gaussian" else float(sigma)
    # With a scale of 0 nothing but equal normals count.
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
    """One pass of n_i' = normalise(sum_j A_j f(|c_i - c_j|) g(x_ij) n_j), (m, 3); where all weights are 0 the normal as it was.

    The normals of the (m, 8) table of `measure_faces`, which has A and c, are overwritten. The deviation x_ij is that of the (m,
    3) guide or the normals themselves. At faces that are `cut_off` by a border the mean follows a trend, see `_follow_trend`.
    """
    result = np.empty_like(normals)
    # One row of 8 numbers, in which deviations are measured on the normal, is most that the kernel fetches of a neighbour.
    table[:, NORMAL] = normals if guide is None else guide
    # The arrays of `_neighbour_weights` hold the neighbours of any one face, and some more.
    size = _MORE + int(np.diff(neighbourhoods.offsets).max(initial=0)) + weighting.itself
    arguments = table if guide is None else normals, table, neighbourhoods, weighting, size, result
    over_range(_weighted_means, len(normals), *arguments)
    if cut_off is not None and len(cut_off):
        over_range(_follow_trend, len(cut_off), cut_off, *arguments)
    return result


def mean_normals(normals: Floats, table: Floats, neighbourhoods: FaceNeighbourhoods) -> Floats:
    """(m, 3) the mean of each normal and its neighbours', weighted by area alone [belyaev2001]; see `weighted_normals`."""
    result = np.empty_like(normals)
    table[:, NORMAL] = normals
    over_range(_means, len(normals), table, *neighbourhoods, result)
    return result


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
    """Arrays for what `_neighbour_weights` finds."""

    near: Ints  # the neighbours
    weights: Floats  # their weights
    squares: Floats  # of the deviations of their normals
    distances: Floats  # squared, of their centres


@compiled(nogil=True)
def _make_room(size: int) -> _Room:
    return _Room(np.empty(size, np.int32), np.empty(size), np.empty(size), np.empty(size))


@compiled(nogil=True)
def _faces_with_room(offsets: Longs, first: int, last: int, itself: bool, room: int) -> int:
    """The end of the faces from `first` on whose neighbours have room; one face at least."""
    stop = first + 1
    while stop < last and offsets[stop + 1] - offsets[first] + (stop + 1 - first if itself else 0) <= room:
        stop += 1
    return stop


# Each step is a loop of its own over arrays in a row, which is done for several neighbours at once. Short loops take longer: so
# it goes over the neighbours of several faces. Unsigned indices need no look whether they count from the end.
@compiled(nogil=True, error_model="numpy")
def _neighbour_weights(
    first: int, last: int, rows: Floats, neighbourhoods: FaceNeighbourhoods, weighting: Weighting, room: _Room
) -> int:
    """How many neighbours the faces of `_faces_with_room` have; writes these, a face itself first, and areas times kernels."""
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
    which: Ints,
    normals: Floats,
    rows: Floats,
    around: FaceNeighbourhoods,
    weighting: Weighting,
    size: int,
    out: Floats,
    first: int,
    last: int,
) -> None:
    """Put the value of a fit of first degree at the centre of some faces in the place of weighted means of normals.

    With the weights w_j of the mean and x_j = c_j - c_i, the normals n_j are fitted by b + G x_j, least squares, a ridge on
    G [cleveland1979]. The mean a lies off the fit at the face by G times the mean x, which is far from 0 at a border. With s^2
    the variance of b - a by the residuals, a goes to a + max(0, 1 - 2 s^2 / |b - a|^2) (b - a): where the normals scatter so
    much that no trend can be seen it stays.
    """
    room = _make_room(size)
    x, mean_x, solved, mean, at_face = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    second, mixed, trend = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for at in range(first, last):
        i = which[at]
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
        # As many neighbours of equal weight would have a mean of the same variance.
        number = total * total / squares if squares > 0.0 else 0.0
        if not (number > _NUMBERS and ridge > 0.0):
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
            # The normals have a length of 1, so that their squares sum up to the weights.
            residual += total * (at_face[v] * at_face[v] - 2.0 * at_face[v] * mean[v])
            shift += (at_face[v] - mean[v]) * (at_face[v] - mean[v])
        residual = max(0.0, (residual + total) / total)
        variance = residual / (number - _NUMBERS) * leverage / (1.0 - leverage)
        share = 1.0 - _DOUBT * variance / shift if shift > 0.0 else 0.0
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
    """Cholesky's factor of a positive definite matrix, in the place of its lower triangle."""
    for a in range(3):
        for b in range(a + 1):
            rest = matrix[a, b]
            for c in range(b):
                rest -= matrix[a, c] * matrix[b, c]
            matrix[a, b] = math.sqrt(rest) if a == b else rest / matrix[b, b]


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

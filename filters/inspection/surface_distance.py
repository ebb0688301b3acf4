"""The distance of one surface from another: samples on faces by area, with a bound for the places between samples."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..execution import blocks
from ..geometry import vector_lengths
from ..mesh import Floats, Ints, check_mesh
from .face_samples import face_samples, sample_places
from .surface import NearestPlaces, Surface

#: Samples of a surface with fewer faces.
SAMPLES = 100_000
#: Percentiles of the sizes of distances.
PERCENTILES = (50, 90, 95, 99)
#: The search for the largest distance ends when no other can be larger by more than this factor.
_PROVEN = 1.01


@dataclass(frozen=True)
class DistanceStatistics:
    """Statistics of distances, weighted with area; each with its sampling error, twice the standard error of random samples.

    Attributes:
        samples: how many there are.
        mean: of the signed distances: above 0 the surface lies outside by and large.
        mean_size: of the distances without sign.
        rms: the root of the mean of their squares.
        standard_deviation: of the signed ones about their mean.
        percentiles: the distances without sign that 50, 90, 95 and 99 % of the area keep below, by "50" ...
        within: the share of the area that lies within the tolerance; None without one.
        mean_error: the sampling error of the mean.
        mean_size_error: that of `mean_size`.
        rms_error: that of `rms`.
        within_error: that of `within`.
    """

    samples: int
    mean: float
    mean_size: float
    rms: float
    standard_deviation: float
    percentiles: dict[str, float]
    within: float | None
    mean_error: float
    mean_size_error: float
    rms_error: float
    within_error: float | None


@dataclass(frozen=True, eq=False)
class SurfaceDistance:
    """The distances of samples and of vertices of a surface from another one.

    Attributes:
        faces: (k,) the face of each sample, from which `sample_places` has its place; in a cloud the vertex.
        weights: (k,) the share of the area for which each stands; together 1.
        distances: (k,) how far to the outer side of the other surface each lies.
        elements: (k,) the face of the other surface that is nearest.
        at_vertices: (n,) how far to its outer side the vertices lie.
        largest: the largest distance that a search of all faces came upon, without sign.
        furthest: (3,) where that is.
        at_most: no place of the surface lies further than that; `largest` is at most a hundredth less, unless that would have
            taken more searching than the samples.
    """

    faces: Ints
    weights: Floats
    distances: Floats
    elements: Ints
    at_vertices: Floats
    largest: float
    furthest: Floats
    at_most: float

    def statistics(self, tolerance: float | None = None) -> DistanceStatistics:
        """Statistics of the distances of the samples.

        Args:
            tolerance: a distance, for `DistanceStatistics.within`.
        """
        d, weights = self.distances, self.weights
        sizes = np.abs(d)
        independent = 2.0 * math.sqrt(float((weights**2).sum()))

        def mean_and_error(values: Floats) -> tuple[float, float]:
            mean = float(weights @ values)
            return mean, independent * math.sqrt(max(float(weights @ (values - mean) ** 2), 0.0))

        mean, mean_error = mean_and_error(d)
        mean_size, mean_size_error = mean_and_error(sizes)
        square, square_error = mean_and_error(d**2)
        within, within_error = (None, None) if tolerance is None else mean_and_error((sizes <= tolerance).astype(np.float64))
        rms = math.sqrt(square)
        return DistanceStatistics(
            samples=len(d),
            mean=mean,
            mean_size=mean_size,
            rms=rms,
            standard_deviation=math.sqrt(float(weights @ (d - mean) ** 2)),
            percentiles=dict(zip(map(str, PERCENTILES), _percentiles(sizes, weights), strict=True)),
            within=within,
            mean_error=mean_error,
            mean_size_error=mean_size_error,
            rms_error=0.5 * square_error / rms if rms > 0.0 else 0.0,
            within_error=within_error,
        )


def surface_distance(vertices: Floats, faces: Ints, to: Surface, *, count: int = SAMPLES) -> SurfaceDistance:
    """Measure how far a mesh or a cloud lies from a surface.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles; none of a cloud, whose vertices are the samples.
        to: the other surface.
        count: samples, at least one on every face.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    at_vertices = to.nearest(points)
    samples = face_samples(points - to.mesh.middle, triangles, count)
    area = float(samples.areas.sum())
    weights = samples.areas / area if area > 0.0 else np.full(len(samples.areas), 1.0 / len(samples.areas))
    sampled = at_vertices
    if len(triangles):
        sampled = NearestPlaces(np.empty(len(weights)), np.empty(len(weights), np.int32), np.empty((0, 3)))
        for part in blocks(len(weights)):
            nearest = to.nearest(sample_places(points, triangles, samples.faces, np.arange(part.start, part.stop)))
            sampled.signed[part], sampled.elements[part] = nearest.signed, nearest.elements
    largest, furthest, at_most = _largest(points, triangles, at_vertices.signed, samples.faces, sampled, to)
    return SurfaceDistance(
        samples.faces, weights, sampled.signed, sampled.elements, at_vertices.signed, largest, furthest, at_most
    )


class _Parts(NamedTuple):
    """(t, 3, 3) corners of parts of faces, (t, 3) their distances from the other surface, and (t,) bounds of all distances."""

    corners: Floats
    distances: Floats
    bounds: Floats


def _largest(
    points: Floats, faces: Ints, at_vertices: Floats, samples: Ints, sampled: NearestPlaces, to: Surface
) -> tuple[float, Floats, float]:
    """The largest distance, its place, and a bound above all: faces that may hold a larger one are quartered until none does."""
    used = np.zeros(len(points), np.bool_)
    used[faces if len(faces) else slice(None)] = True  # other vertices are no places of the surface
    at_points, at_samples = np.where(used, np.abs(at_vertices), 0.0), sampled.distances
    vertex, sample = int(at_points.argmax()), int(at_samples.argmax())
    largest, furthest = float(at_points[vertex]), points[vertex]
    if at_samples[sample] > largest:
        largest, furthest = float(at_samples[sample]), sample_places(points, faces, samples, np.array([sample]))[0]
    if not len(faces):
        return largest, furthest, largest
    scale = to.mesh.scale
    local, at_points = to.local(points), np.abs(at_vertices) * scale
    if not len(to.faces):
        sides = np.max([vector_lengths(local[faces[:, k]] - local[faces[:, k - 1]]) for k in range(3)], axis=0)
        return largest, furthest, float((at_points[faces].max(axis=1) + sides).max()) / scale
    first = np.searchsorted(samples, np.arange(len(faces), dtype=np.int32))  # the samples of a face stand together
    bounds = np.empty(len(faces))
    for part in blocks(len(faces)):
        beside = to.cells_of(sampled.elements[first[part]])[:, None]
        bounds[part] = to.largest_distances(local[faces[part]], at_points[faces[part]], beside)
    high = bounds > largest * scale * _PROVEN
    rest, left = float(bounds[~high].max(initial=0.0)), len(points) + len(samples)
    if 3 * np.count_nonzero(high) > left:
        return largest, furthest, max(float(bounds.max()) / scale, largest)
    parts = _Parts(local[faces[high]], at_points[faces[high]], bounds[high])
    while len(parts.bounds) and 3 * len(parts.bounds) <= left:
        left -= 3 * len(parts.bounds)
        smaller = []
        for block in blocks(len(parts.bounds)):
            middles, distances, quarters = _quartered(_Parts(*(values[block] for values in parts)), to)
            if distances.max() > largest * scale:
                worst = int(distances.argmax())
                largest, furthest = float(distances[worst]) / scale, middles[worst] / scale + to.mesh.middle
            quarters, below = _above(largest * scale * _PROVEN, quarters)
            smaller.append(quarters)
            rest = max(rest, below)
        joined = _Parts(*(np.concatenate(values) for values in zip(*smaller, strict=True)))
        parts, below = _above(largest * scale * _PROVEN, joined)
        rest = max(rest, below)
    return largest, furthest, max(float(parts.bounds.max(initial=rest)) / scale, largest)


def _quartered(parts: _Parts, to: Surface) -> tuple[Floats, Floats, _Parts]:
    """(3 t, 3) the middles of the sides, (3 t,) their distances from the other surface, and the 4 t parts between them."""
    corners, d, _ = parts
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
    cells, at_middles = to.search(middles.reshape(-1, 3))
    e = at_middles.reshape(-1, 3)
    quarters = np.concatenate([*(np.stack([corners[:, k], middles[:, k], middles[:, k - 1]], axis=1) for k in range(3)), middles])
    at_quarters = np.concatenate([*(np.stack([d[:, k], e[:, k], e[:, k - 1]], axis=1) for k in range(3)), e])
    bounds = to.largest_distances(quarters, at_quarters, np.tile(cells.reshape(-1, 3), (4, 1)))
    return middles.reshape(-1, 3), at_middles, _Parts(quarters, at_quarters, bounds)


def _above(bound: float, parts: _Parts) -> tuple[_Parts, float]:
    """The parts whose bounds are above another one, and the largest bound of the others."""
    high = parts.bounds > bound
    return _Parts(*(values[high] for values in parts)), float(parts.bounds[~high].max(initial=0.0))


def _percentiles(sizes: Floats, weights: Floats) -> list[float]:
    """The sizes that so many percent of the weight keep below."""
    order = np.argsort(sizes, kind="stable")
    below = np.cumsum(weights[order])
    at = np.searchsorted(below, [p / 100.0 * below[-1] for p in PERCENTILES])
    return [float(sizes[order[min(k, len(order) - 1)]]) for k in at]

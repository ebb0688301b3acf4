"""How far one surface lies from another: sampled on its faces by area, with what the samples can have missed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..geometry import vector_lengths
from ..mesh import Floats, Ints, Longs, check_mesh
from .face_samples import FaceSamples, face_samples
from .surface import NearestPlaces, Surface

#: samples of a surface that has fewer faces
SAMPLES = 100_000
#: percentiles of the sizes of distances
PERCENTILES = (50, 90, 95, 99)
#: the largest distance is searched for until no other one can be larger by more than this factor
_PROVEN = 1.01
#: faces that are looked at together at first
_BLOCK = 1 << 16


@dataclass(frozen=True)
class DistanceStatistics:
    """What distances come to, weighted with area; each with its sampling error, twice the standard error of random samples.

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
        places: (k, 3) the samples; the vertices of a cloud.
        faces: (k,) the face of each; in a cloud the vertex.
        weights: (k,) the share of the area for which each stands; together 1.
        distances: (k,) how far to the outer side of the other surface each lies.
        elements: (k,) the face of the other surface that is nearest.
        at_vertices: (n,) how far to its outer side the vertices lie.
        largest: the largest distance that a search of all faces came upon, without sign.
        furthest: (3,) where that is.
        at_most: no place of the surface lies further than that; `largest` is at most a hundredth less, unless that would have
            taken more searching than the samples.
    """

    places: Floats
    faces: Longs
    weights: Floats
    distances: Floats
    elements: Longs
    at_vertices: Floats
    largest: float
    furthest: Floats
    at_most: float

    def statistics(self, tolerance: float | None = None) -> DistanceStatistics:
        """What the distances of the samples come to.

        Args:
            tolerance: a distance; `DistanceStatistics.within` says which share keeps below.
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
    if len(triangles):
        samples = face_samples(points - to.mesh.middle, triangles, count)
        samples = samples._replace(places=samples.places + to.mesh.middle)
        nearest = to.nearest(samples.places)
    else:
        samples, nearest = FaceSamples(points, np.arange(len(points)), np.ones(len(points))), at_vertices
    area = float(samples.areas.sum())
    weights = samples.areas / area if area > 0.0 else np.full(len(samples.areas), 1.0 / len(samples.areas))
    largest, furthest, at_most = _largest(points, triangles, at_vertices, samples, nearest, to)
    return SurfaceDistance(
        samples.places, samples.faces, weights, nearest.signed, nearest.elements, at_vertices.signed, largest, furthest, at_most
    )


def _largest(
    points: Floats, faces: Ints, at_vertices: NearestPlaces, samples: FaceSamples, nearest: NearestPlaces, to: Surface
) -> tuple[float, Floats, float]:
    """The largest distance, its place, and a bound above all: faces that may hold a larger one are quartered until none does."""
    corner = np.unique(faces) if len(faces) else np.arange(len(points))  # other vertices are no places of the surface
    every = (points[corner], at_vertices.distances[corner]), (samples.places, nearest.distances)
    places, distances = max(every, key=lambda some: some[1].max(initial=0.0))
    worst = int(distances.argmax())
    largest, furthest = float(distances[worst]), places[worst]
    if not len(faces):
        return largest, furthest, largest
    scale = to.mesh.scale
    local, at_points = to.local(points), at_vertices.distances * scale
    if not len(to.faces):
        sides = np.max([vector_lengths(local[faces[:, k]] - local[faces[:, k - 1]]) for k in range(3)], axis=0)
        return largest, furthest, float((at_points[faces].max(axis=1) + sides).max()) / scale
    beside = to.cells_of(nearest.elements[np.searchsorted(samples.faces, np.arange(len(faces)))])[:, None]
    bound = np.concatenate(
        [
            to.largest_distances(local[faces[part]], at_points[faces[part]], beside[part])
            for part in np.array_split(np.arange(len(faces)), 1 + len(faces) // _BLOCK)
        ]
    )
    high = bound > largest * scale * _PROVEN
    corners, d, rest = local[faces[high]], at_points[faces[high]], float(bound[~high].max(initial=0.0))
    bound = bound[high]
    left = len(points) + len(samples.places)
    while True:
        open_ones = np.flatnonzero(bound > largest * scale * _PROVEN)
        if not len(open_ones) or 3 * len(open_ones) > left:
            return largest, furthest, max(float(bound.max(initial=rest)) / scale, largest)
        corners, d = corners[open_ones], d[open_ones]
        middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
        cells, found = to.search(middles.reshape(-1, 3))
        left -= len(found)
        if found.max() > largest * scale:
            worst = int(found.argmax())
            largest, furthest = float(found[worst]) / scale, middles.reshape(-1, 3)[worst] / scale + to.mesh.middle
        e, beside = found.reshape(-1, 3), np.tile(cells.reshape(-1, 3), (4, 1))
        corners = np.concatenate(
            [*(np.stack([corners[:, k], middles[:, k], middles[:, k - 1]], axis=1) for k in range(3)), middles]
        )
        d = np.concatenate([*(np.stack([d[:, k], e[:, k], e[:, k - 1]], axis=1) for k in range(3)), e])
        bound = to.largest_distances(corners, d, beside)


def _percentiles(sizes: Floats, weights: Floats) -> list[float]:
    """The sizes that so many percent of the weight keep below."""
    order = np.argsort(sizes, kind="stable")
    below = np.cumsum(weights[order])
    at = np.searchsorted(below, [p / 100.0 * below[-1] for p in PERCENTILES])
    return [float(sizes[order[min(k, len(order) - 1)]]) for k in at]

"""Distances of one surface from another: of vertices, and of samples by area with a bound for the places between them.

Alignment to another surface by iterated nearest places, point to plane [chen1992], and the wall thickness of closed ones.
"""

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice
from ..execution import blocks
from ..geometry import face_areas, face_normals, vector_lengths
from ..libraries import spatial
from ..mesh import Floats, Ints, Longs, check_mesh
from .surface import NearestPlaces, Surface

#: "vertex": vertex i belongs to vertex i. "surface": every vertex belongs to the nearest place of the reference. "auto": the
#: first if both have as many vertices and the same faces, at least one; else the second.
Correspondence: TypeAlias = Literal["auto", "vertex", "surface"]
#: Samples of a surface with fewer faces.
SAMPLES = 100_000
#: Percentiles of the sizes of distances.
PERCENTILES = (50, 90, 95, 99)
#: Samples that are aligned, and the share of them, the nearest ones, that determines the motion: only one scan may have the rest.
_ALIGNED, _TRUSTED = 20_000, 0.8
#: The most iterations of an alignment, and the step at which it ends, as a share of the size of the surface.
_ITERATIONS, _SMALLEST = 200, 3e-6
#: A wall is opposite if its normal is turned by this angle at least, in radians: two faces at an edge are not.
LEAST_ANGLE = 2.0 * np.pi / 3.0
#: The most balls that are tried at a place, and the share of the radius that is rounding.
_BALLS, _SAME = 30, 1e-9
#: The search for the largest distance ends when no other can be larger by more than this factor.
_PROVEN = 1.01
#: The steps of the sequence whose points fill a square most evenly of all such sequences: 1 / g and 1 / g^2, g^3 = g + 1
#: [roberts2018].
_STEPS = (0.7548776662466927, 0.5698402909980532)


@dataclass(frozen=True, eq=False)
class Displacement:
    """The distances of n vertices from their counterparts on a reference."""

    vectors: Floats  # (n, 3) from the counterpart to the vertex, in mesh units
    distances: Floats  # (n,) their lengths
    # (n,) how far to the outer side of the reference: of vertices with the same number the part along the normal of the reference
    # there, 0 where they slid within the surface; else the distance, negative on the inner side
    signed: Floats
    by_vertex: bool  # whether vertices were compared with those of the same number


def displacement(
    vertices: ArrayLike,
    faces: ArrayLike,
    reference_vertices: ArrayLike,
    reference_faces: ArrayLike,
    *,
    correspondence: Correspondence = "auto",
) -> Displacement:
    """Measure how far the vertices of a mesh or a cloud lie from a reference.

    Exact to the digits that the coordinates have, far from the origin, too: differences come before squares. A cloud has no
    faces. Those of the mesh matter for the correspondence alone.

    Raises:
        FilterInputError: not a mesh, an empty reference, or vertices that cannot correspond as they differ in number.
    """
    check_choice("correspondence", correspondence, Correspondence)
    points, triangles = check_mesh(vertices, faces)
    targets, target_faces = check_mesh(reference_vertices, reference_faces)
    ground = Surface.of(targets, target_faces)
    same = len(points) == len(targets)
    if correspondence == "vertex" and not same:
        raise FilterInputError(
            f"the mesh has {len(points)} vertices and the reference {len(targets)}: vertices of the same number are no "
            "counterparts; take the correspondence 'surface'"
        )
    alike = same and len(triangles) > 0 and np.array_equal(triangles, target_faces)
    if correspondence == "surface" or (correspondence == "auto" and not alike):
        nearest = ground.nearest(points, vectors=True)
        return Displacement(nearest.vectors, nearest.distances, nearest.signed, by_vertex=False)
    vectors = points - targets
    heights = np.einsum("ij,ij->i", vectors, ground.normals_at_vertices())
    return Displacement(vectors, vector_lengths(vectors), heights, by_vertex=True)


def face_samples(vertices: Floats, faces: Ints, count: int) -> tuple[Ints, Floats]:
    """The faces of about `count` samples, ascending, more where there are more faces, and the area for which each stands.

    Each face has as many as its share of the area asks for, at least one. Means that are weighted with the areas miss those over
    the surface by no more than those of as many random samples. Those of a cloud are its vertices.
    """
    if not len(faces):
        return np.arange(len(vertices), dtype=np.int32), np.ones(len(vertices))
    measured = face_areas(vertices, faces)
    shares = measured * (count / total) if (total := measured.sum()) > 0.0 else measured
    per_face = np.maximum(np.rint(shares), 1.0).astype(np.int64)
    of = np.repeat(np.arange(len(faces), dtype=np.int32), per_face)
    return of, (measured / per_face)[of]


def sample_places(vertices: Floats, faces: Ints, samples: Ints, rows: Longs) -> Floats:
    """(r, 3) the places of the samples `rows` of all, whose (k,) faces are `samples`, on (m, 3) triangles or none."""
    if not len(faces):
        return vertices[samples[rows]]
    places = np.empty((len(rows), 3))
    for part in blocks(len(rows)):
        # The points of the sequence as weights of corners, those beyond the diagonal of the square mirrored at its middle.
        s, t = (step * (rows[part, None] + 1) % 1.0 for step in _STEPS)
        beyond = s + t > 1.0
        s, t = np.where(beyond, 1.0 - s, s), np.where(beyond, 1.0 - t, t)
        a, b, c = (vertices[corners] for corners in faces[samples[rows[part]]].T)
        places[part] = a + s * (b - a) + t * (c - a)
    return places


@dataclass(frozen=True)
class DistanceStatistics:
    """Statistics of distances, weighted with area; each with its sampling error, twice the standard error of random samples."""

    samples: int  # how many there are
    mean: float  # of the signed distances: above 0 the surface lies outside by and large
    mean_size: float  # of the distances without sign
    rms: float  # the root of the mean of their squares
    standard_deviation: float  # of the signed ones about their mean
    percentiles: dict[str, float]  # the distances without sign that 50, 90, 95 and 99 % of the area keep below, by name
    within: float | None  # the share of the area that lies within the tolerance; None without one
    mean_error: float  # the sampling error of the mean
    mean_size_error: float  # that of `mean_size`
    rms_error: float  # that of `rms`
    within_error: float | None  # that of `within`


@dataclass(frozen=True, eq=False)
class SurfaceDistance:
    """The distances of samples and of vertices of a surface from another one."""

    faces: Ints  # (k,) the face of each sample, from which `sample_places` has its place; in a cloud the vertex
    weights: Floats  # (k,) the share of the area for which each stands; together 1
    distances: Floats  # (k,) how far to the outer side of the other surface each lies
    elements: Ints  # (k,) the face of the other surface that is nearest
    at_vertices: Floats  # (n,) how far to its outer side the vertices lie
    largest: float  # the largest distance that a search of all faces came upon, without sign
    furthest: Floats  # (3,) where that is
    at_most: float  # no place lies further; `largest` is a hundredth less at most, unless that took more searches than samples

    def statistics(self, tolerance: float | None = None) -> DistanceStatistics:
        """Statistics of the distances of the samples; `tolerance` is for `DistanceStatistics.within`."""
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
            percentiles=_percentiles(sizes, weights),
            within=within,
            mean_error=mean_error,
            mean_size_error=mean_size_error,
            rms_error=0.5 * square_error / rms if rms > 0.0 else 0.0,
            within_error=within_error,
        )


def surface_distance(vertices: Floats, faces: Ints, to: Surface, *, count: int = SAMPLES) -> SurfaceDistance:
    """Measure how far a mesh lies from a surface, by `count` samples, at least one on every face; or a cloud, by its vertices.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    at_vertices = to.nearest(points)
    samples, areas = face_samples(points - to.mesh.middle, triangles, count)
    area = float(areas.sum())
    weights = areas / area if area > 0.0 else np.full(len(areas), 1.0 / len(areas))
    sampled = at_vertices
    if len(triangles):
        sampled = to.nearest(sample_places(points, triangles, samples, np.arange(len(weights))))
    proven = _largest(points, triangles, at_vertices.signed, samples, sampled, to)
    return SurfaceDistance(samples, weights, sampled.signed, sampled.elements, at_vertices.signed, *proven)


class _Parts(NamedTuple):
    """(t, 3, 3) corners of parts of faces, (t, 3) their distances from the other surface, (t,) bounds of all distances."""

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


def _percentiles(sizes: Floats, weights: Floats) -> dict[str, float]:
    order = np.argsort(sizes, kind="stable")
    below = np.cumsum(weights[order])
    at = np.searchsorted(below, [p / 100.0 * below[-1] for p in PERCENTILES])
    return {str(p): float(sizes[order[min(k, len(order) - 1)]]) for p, k in zip(PERCENTILES, at, strict=True)}


@dataclass(frozen=True, eq=False)
class Alignment:
    """The rigid motion of a surface onto another one."""

    vertices: Floats  # (n, 3) where its vertices are now
    degrees: float  # by which it was turned
    shift: float  # by which its middle was moved, in mesh units
    residual: float  # the root mean square of the distances of the 80 % of its samples that lie nearest
    iterations: int  # how many it took
    converged: bool  # whether the last step was below 3e-6 of the size


def align(vertices: Floats, faces: Ints, to: Surface) -> Alignment:
    """Turn and move a mesh or a cloud so that it lies on a surface with faces; it is some degrees off at most [chen1992]."""
    middle = vertices.mean(axis=0)
    local = vertices - middle
    of, _ = face_samples(local, faces, _ALIGNED)
    samples = sample_places(local, faces, of, np.arange(0, len(of), max(1, len(of) // _ALIGNED)))
    size = float(np.linalg.norm(np.ptp(samples, axis=0))) or 1.0
    turn, shift = np.eye(3), np.zeros(3)
    residual, iterations, step = math.inf, 0, math.inf
    while iterations < _ITERATIONS and step > _SMALLEST:
        iterations += 1
        places = samples @ turn.T + shift
        nearest = to.nearest(places + middle, vectors=True)
        trusted = np.argsort(nearest.distances, kind="stable")[: max(6, int(_TRUSTED * len(places)))]
        residual = math.sqrt(float((nearest.distances[trusted] ** 2).mean()))
        normals, p = to.normals_of(nearest.elements[trusted]), places[trusted] / size
        # Least squares of n (p + w x p + t - q): the turn w and the shift t, both small.
        rows = np.column_stack([np.cross(p, normals), normals])
        heights = np.einsum("ij,ij->i", nearest.vectors[trusted], normals) / size
        motion = np.linalg.lstsq(rows.T @ rows, -rows.T @ heights, rcond=1e-12)[0]
        more = spatial.transform.Rotation.from_rotvec(motion[:3]).as_matrix()
        turn, shift = more @ turn, more @ shift + size * motion[3:]
        step = float(np.linalg.norm(motion))
    angle = math.degrees(float(spatial.transform.Rotation.from_matrix(turn).magnitude()))
    moved = local @ turn.T + shift + middle
    return Alignment(moved, angle, float(np.linalg.norm(shift)), residual, iterations, step <= _SMALLEST)


class Thickness(NamedTuple):
    """The thickness at k places of a surface, in mesh units."""

    values: Floats  # (k,) the diameters of the balls; infinite where no other wall is opposite
    places: Floats  # (k, 3) where they touch
    areas: Floats  # (k,) the area for which each stands

    def below(self, share: float) -> float:
        """The thickness that this share of the area stays below, of the area where there is one; infinite without any."""
        order = np.argsort(self.values)
        reached = np.cumsum(self.areas[order]) >= share * self.areas[np.isfinite(self.values)].sum()
        return float(self.values[order][reached.argmax()])


def wall_thickness(vertices: ArrayLike, faces: ArrayLike, *, count: int = 20_000) -> Thickness:
    """The thickness of the body inside a closed surface, at places spread evenly over it [ma2012].

    A ball of the size of the box touches the place p with normal n, its centre c = p - r n. While the surface comes nearer to c
    than r, at q, it is replaced by the ball that touches both, r = |p - q|^2 / (2 n . (p - q)). The last of these counts whose q
    lies on a wall that is opposite, by `LEAST_ANGLE`: a sheet is as thick as it is near its rim, too. The faces, at least one,
    look outwards. There are about `count` places, twice as many at most.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    surface = Surface.of(points, triangles)
    samples, areas = face_samples(points, triangles, count)
    step = -(-len(samples) // (2 * count))
    places = sample_places(points, triangles, samples, np.arange(0, len(samples), step))
    of_faces = face_normals(points, triangles)
    normals = of_faces[samples[::step]]
    radii = np.full(len(normals), float(np.linalg.norm(np.ptp(points, axis=0))))
    thickness = np.full(len(normals), np.inf)
    active = np.flatnonzero((normals != 0.0).any(axis=1))
    for _ in range(_BALLS):
        to_place = radii[active, None] * normals[active]
        nearest = surface.nearest(places[active] - to_place, vectors=True)
        inside = nearest.distances < (1.0 - _SAME) * radii[active]
        active, way = active[inside], to_place[inside] + nearest.vectors[inside]
        rise = np.einsum("ij,ij->i", way, normals[active])
        opposite = np.einsum("ij,ij->i", of_faces[nearest.elements[inside]], normals[active]) <= np.cos(LEAST_ANGLE)
        active, way, rise, opposite = (a[rise > 0.0] for a in (active, way, rise, opposite))
        if not len(active):
            break
        radii[active] = np.einsum("ij,ij->i", way, way) / (2.0 * rise)
        thickness[active[opposite]] = 2.0 * radii[active[opposite]]
    return Thickness(thickness, places, step * areas[::step])

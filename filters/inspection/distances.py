"""Distances between surfaces at vertices and area samples, with an upper bound; ICP alignment [chen1992]; wall thickness."""

import math
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice
from ..execution import blocks
from ..geometry import face_areas, face_normals, vector_lengths
from ..libraries import spatial
from ..mesh import Floats, Ints, Longs, check_mesh, mask_of, normalised_mesh
from .surface import NearestPlaces, Surface

#: "vertex": vertex i corresponds to vertex i. "surface": each vertex corresponds to the nearest place on the reference. "auto":
#: "vertex" if both have equal numbers of vertices and the same faces (at least one face); else "surface".
Correspondence: TypeAlias = Literal["auto", "vertex", "surface"]
SAMPLES = 100_000  # The usual number of samples on a surface.
PERCENTILES = (50, 90, 95, 99)
#: The number of samples for an alignment, and the share of them that it uses: the nearest, as scans may overlap only in part.
_ALIGNED, _TRUSTED = 20_000, 0.8
#: The largest number of iterations of an alignment, and the step size at which it ends, as a share of the size of the surface.
_ITERATIONS, _SMALLEST = 200, 3e-6
#: Two walls are opposite if the angle between their normals is at least this, in radians; those at a right-angled edge are not.
LEAST_ANGLE = 2.0 * np.pi / 3.0
#: The largest number of balls that are tried at a place, and the relative rounding error of a radius.
_BALLS, _SAME = 30, 1e-9
#: The search for the largest distance ends when this factor times the largest distance found is an upper bound of all distances.
_PROVEN = 1.01
#: The steps of the R2 sequence, which fills a square very evenly: 1 / g and 1 / g^2 with g^3 = g + 1 [roberts2018].
_STEPS = (0.7548776662466927, 0.5698402909980532)


@dataclass(frozen=True, eq=False)
class Displacement:
    """The distances of n vertices from their counterparts on a reference."""

    vectors: Floats  # (n, 3) from the counterpart to the vertex, in mesh units
    distances: Floats  # (n,) the lengths of the vectors
    # (n,) if `by_vertex`, the component of the vector along the normal of the reference vertex, 0 for tangential motion, or the
    # distance if there is no normal; else the distance, positive outside the reference and negative inside
    signed: Floats
    by_vertex: bool  # whether vertex i was compared with vertex i of the reference


def displacement(
    vertices: ArrayLike,
    faces: ArrayLike,
    reference_vertices: ArrayLike,
    reference_faces: ArrayLike,
    *,
    correspondence: Correspondence = "auto",
) -> Displacement:
    """Measures the distances of the vertices of a mesh or a cloud from a reference.

    Exact to the digits of the coordinates, also far from the origin. A cloud has no faces. The faces of the mesh matter only for
    the correspondence.

    Raises:
        FilterInputError: not a mesh, an empty reference, an unknown correspondence, or "vertex" with different vertex counts.
    """
    check_choice("correspondence", correspondence, Correspondence)
    points, triangles = check_mesh(vertices, faces)
    targets, target_faces = check_mesh(reference_vertices, reference_faces)
    ground = Surface.of(targets, target_faces)
    same_count = len(points) == len(targets)
    if correspondence == "vertex" and not same_count:
        raise FilterInputError(
            f"the mesh has {len(points)} vertices and the reference {len(targets)}: vertex i of one is not "
            "vertex i of the other; take the correspondence 'surface'"
        )
    alike = same_count and len(triangles) > 0 and np.array_equal(triangles, target_faces)
    if correspondence == "surface" or (correspondence == "auto" and not alike):
        nearest = ground.nearest(points, vectors=True)
        return Displacement(nearest.vectors, nearest.distances, nearest.signed, by_vertex=False)
    vectors, normals = points - targets, ground.normals_at_vertices()
    distances = vector_lengths(vectors)
    heights = np.where(normals.any(axis=1), np.einsum("ij,ij->i", vectors, normals), distances)
    return Displacement(vectors, distances, heights, by_vertex=True)


def face_samples(vertices: Floats, faces: Ints, count: int) -> tuple[Ints, Floats]:
    """Returns the faces of about `count` samples, ascending, and the area that each sample represents.

    The number of samples on a face is in proportion to its area, at least one.
    Area-weighted means are at least as accurate as with equally many random samples. A cloud has its vertices as samples.
    """
    if not len(faces):
        return np.arange(len(vertices), dtype=np.int32), np.ones(len(vertices))
    measured = face_areas(vertices, faces)
    shares = measured * (count / total) if (total := measured.sum()) > 0.0 else measured
    per_face = np.maximum(np.rint(shares), 1.0).astype(np.int64)
    face_of_sample = np.repeat(np.arange(len(faces), dtype=np.int32), per_face)
    return face_of_sample, (measured / per_face)[face_of_sample]


def sample_places(vertices: Floats, faces: Ints, samples: Ints, rows: Longs) -> Floats:
    """(r, 3) the places of the samples `rows`; `samples` holds the faces of all samples, or the vertices of a cloud."""
    if not len(faces):
        return vertices[samples[rows]]
    places = np.empty((len(rows), 3))
    for part in blocks(len(rows)):
        # Points of the sequence are barycentric weights; points beyond the diagonal of the square are mirrored at its centre.
        s, t = (step * (rows[part, None] + 1) % 1.0 for step in _STEPS)
        beyond = s + t > 1.0
        s, t = np.where(beyond, 1.0 - s, s), np.where(beyond, 1.0 - t, t)
        a, b, c = (vertices[corners] for corners in faces[samples[rows[part]]].T)
        places[part] = a + s * (b - a) + t * (c - a)
    return places


@dataclass(frozen=True)
class DistanceStatistics:
    """Statistics of distances, weighted by area; a sampling error is twice the standard error of random samples."""

    samples: int
    mean: float  # mean signed distance: above 0 the surface lies outside on average
    mean_size: float  # mean absolute distance
    rms: float
    standard_deviation: float  # of the signed distances
    percentiles: dict[str, float]  # absolute distances that "50", "90", "95" and "99" % of the area do not exceed
    within: float | None  # the share of the area within the tolerance; None without a tolerance
    mean_error: float  # the sampling error of `mean`, and so on
    mean_size_error: float
    rms_error: float
    within_error: float | None


@dataclass(frozen=True, eq=False)
class SurfaceDistance:
    """The distances of the samples and the vertices of a surface from another surface."""

    faces: Ints  # (k,) the face of each sample, as `samples` in `sample_places`; for a cloud the vertex of each sample
    weights: Floats  # (k,) the share of the area that each sample represents; the sum is 1
    distances: Floats  # (k,) the signed distance of each sample, positive outside the other surface
    elements: Ints  # (k,) the face (point of a cloud) of the other surface nearest to each sample
    at_vertices: Floats  # (n,) the signed distances of the vertices
    largest: float  # the largest absolute distance found
    furthest: Floats  # (3,) the place with the distance `largest`
    furthest_face: int  # the face of this place, or the vertex of a cloud
    at_most: float  # bounds all distances; within 1 % of `largest` unless the search is cut short or the other surface is a cloud
    at_furthest: float  # the signed distance at `furthest`

    def statistics(self, tolerance: float | None = None) -> DistanceStatistics:
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
            percentiles=dict(zip(map(str, PERCENTILES), _quantiles(sizes, weights, np.divide(PERCENTILES, 100)), strict=True)),
            within=within,
            mean_error=mean_error,
            mean_size_error=mean_size_error,
            rms_error=0.5 * square_error / rms if rms > 0.0 else 0.0,
            within_error=within_error,
        )


def surface_distance(vertices: Floats, faces: Ints, to: Surface, *, count: int = SAMPLES) -> SurfaceDistance:
    """Measures the distances from `to` at about `count` samples of a mesh, at least one on each face, or at all cloud points.

    Raises:
        FilterInputError: not a mesh, or no vertices.
    """
    points, triangles = check_mesh(vertices, faces)
    if not len(points):
        raise FilterInputError("the mesh has no vertices: there is no place to measure at")
    at_vertices = to.nearest(points)
    samples, areas = face_samples(points - to.mesh.middle, triangles, count)
    area = float(areas.sum())
    weights = areas / area if area > 0.0 else np.full(len(areas), 1.0 / len(areas))
    sampled = to.nearest(sample_places(points, triangles, samples, np.arange(len(weights)))) if len(triangles) else at_vertices
    proven = _largest(points, triangles, at_vertices.signed, samples, sampled, to)
    at_furthest = math.copysign(proven[0], to.nearest(proven[1][None]).signed[0])
    return SurfaceDistance(samples, weights, sampled.signed, sampled.elements, at_vertices.signed, *proven, at_furthest)


class _Parts(NamedTuple):
    """Parts of faces: (t, 3, 3) corners, (t, 3) their distances from the other surface, (t,) upper bounds and (t,) faces."""

    corners: Floats
    distances: Floats
    bounds: Floats
    faces: Any


def _largest(
    points: Floats, faces: Ints, at_vertices: Floats, samples: Ints, sampled: NearestPlaces, to: Surface
) -> tuple[float, Floats, int, float]:
    """Finds the largest distance, its place and face, and an upper bound, see `_PROVEN`; splits faces that may be farther."""
    used = mask_of(faces, len(points)) | (len(faces) == 0)  # unused vertices do not lie on the surface
    at_points, at_samples = np.where(used, np.abs(at_vertices), 0.0), sampled.distances
    vertex, sample = int(at_points.argmax()), int(at_samples.argmax())
    if not len(faces):
        return float(at_points[vertex]), points[vertex], vertex, float(at_points[vertex])
    largest, furthest, face = float(at_points[vertex]), points[vertex], int((faces == vertex).any(axis=1).argmax())
    if at_samples[sample] > largest:
        largest, face = float(at_samples[sample]), int(samples[sample])
        furthest = sample_places(points, faces, samples, np.array([sample]))[0]
    scale = to.mesh.scale
    local, at_points = to.local(points), np.abs(at_vertices) * scale
    if not len(to.faces):
        sides = np.max([vector_lengths(local[faces[:, k]] - local[faces[:, k - 1]]) for k in range(3)], axis=0)
        return largest, furthest, face, float((at_points[faces].max(axis=1) + sides).max()) / scale
    first = np.searchsorted(samples, np.arange(len(faces), dtype=np.int32))  # the first sample of each face
    bounds = np.empty(len(faces))
    for part in blocks(len(faces)):
        beside = to.cells_of(sampled.elements[first[part]])[:, None]
        bounds[part] = to.largest_distances(local[faces[part]], at_points[faces[part]], beside)
    high = bounds > largest * scale * _PROVEN
    proven_bound, searches_left = float(bounds[~high].max(initial=0.0)), len(points) + len(samples)
    parts = _Parts(local[faces[high]], at_points[faces[high]], bounds[high], np.flatnonzero(high))
    while len(parts.bounds) and 3 * len(parts.bounds) <= searches_left:
        searches_left -= 3 * len(parts.bounds)
        smaller = []
        for block in blocks(len(parts.bounds)):
            middles, distances, quarters = _quartered(_Parts(*(values[block] for values in parts)), to)
            if distances.max() > largest * scale:
                worst = int(distances.argmax())
                face = int(parts.faces[block][worst // 3])
                largest, furthest = float(distances[worst]) / scale, middles[worst] / scale + to.mesh.middle
            quarters, below = _above(largest * scale * _PROVEN, quarters)
            smaller.append(quarters)
            proven_bound = max(proven_bound, below)
        parts, below = _above(largest * scale * _PROVEN, _Parts(*(np.concatenate(v) for v in zip(*smaller, strict=True))))
        proven_bound = max(proven_bound, below)
    return largest, furthest, face, max(float(parts.bounds.max(initial=proven_bound)) / scale, largest)


def _quartered(parts: _Parts, to: Surface) -> tuple[Floats, Floats, _Parts]:
    corners, d, _, faces = parts
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
    cells, at_middles = to.search(middles.reshape(-1, 3))
    e = at_middles.reshape(-1, 3)
    quarters = np.concatenate([*(np.stack([corners[:, k], middles[:, k], middles[:, k - 1]], axis=1) for k in range(3)), middles])
    at_quarters = np.concatenate([*(np.stack([d[:, k], e[:, k], e[:, k - 1]], axis=1) for k in range(3)), e])
    bounds = to.largest_distances(quarters, at_quarters, np.tile(cells.reshape(-1, 3), (4, 1)))
    return middles.reshape(-1, 3), at_middles, _Parts(quarters, at_quarters, bounds, np.tile(faces, 4))


def _above(bound: float, parts: _Parts) -> tuple[_Parts, float]:
    high = parts.bounds > bound
    return _Parts(*(values[high] for values in parts)), float(parts.bounds[~high].max(initial=0.0))


def _quantiles(values: Floats, weights: Floats, shares: Floats) -> list[float]:
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order])
    return list(values[order[np.searchsorted(below, shares * below[-1])]].tolist())


@dataclass(frozen=True, eq=False)
class Alignment:
    """The rigid motion of a surface onto another one."""

    vertices: Floats  # (n, 3) the moved vertices
    matrix: Floats  # (4, 4) the motion of points as columns (x, y, z, 1)
    degrees: float  # the rotation angle
    shift: float  # the displacement of the centre, in mesh units
    residual: float  # the root mean square distance of the nearest 80 % of the samples, before the last step
    iterations: int
    converged: bool  # whether the last step was at most 3e-6 of the size


def align(vertices: Floats, faces: Ints, to: Surface) -> Alignment:
    """Aligns a mesh or a cloud, rotated by at most a few degrees, to a surface with faces by point-to-plane ICP [chen1992]."""
    middle = normalised_mesh(vertices, faces).middle
    local = vertices - middle
    face_of_sample, _ = face_samples(local, faces, _ALIGNED)
    rows = np.arange(0, len(face_of_sample), max(1, len(face_of_sample) // _ALIGNED))
    samples = sample_places(local, faces, face_of_sample, rows)
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
        # Least squares of n . (p + w x p + t - q) for a small rotation w and a small shift t.
        jacobian = np.column_stack([np.cross(p, normals), normals])
        heights = np.einsum("ij,ij->i", nearest.vectors[trusted], normals) / size
        motion = np.linalg.lstsq(jacobian.T @ jacobian, -jacobian.T @ heights, rcond=1e-12)[0]
        rotation = spatial.transform.Rotation.from_rotvec(motion[:3]).as_matrix()
        turn, shift = rotation @ turn, rotation @ shift + size * motion[3:]
        step = float(np.linalg.norm(motion))
    angle = math.degrees(float(spatial.transform.Rotation.from_matrix(turn).magnitude()))
    moved, matrix = local @ turn.T + shift + middle, np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, shift + middle - turn @ middle
    return Alignment(moved, matrix, angle, float(np.linalg.norm(shift)), residual, iterations, step <= _SMALLEST)


class Thickness(NamedTuple):
    """The thickness at k places of a surface, in mesh units."""

    values: Floats  # (k,) the thickness, a ball diameter; infinite where no wall is opposite
    places: Floats  # (k, 3) the places on the surface
    areas: Floats  # (k,) the area that each place represents

    def below(self, share: float) -> float:
        finite = np.isfinite(self.values)
        return _quantiles(self.values[finite], self.areas[finite], np.array([share]))[0] if finite.any() else math.inf


def wall_thickness(vertices: ArrayLike, faces: ArrayLike, *, count: int = 20_000) -> Thickness:
    """Measures the thickness of the body inside a closed surface by shrinking balls, at places spread evenly over it [ma2012].

    The first ball touches the place p with normal n; its radius r is the diagonal of the bounding box, its centre c = p - r n.
    While the surface has a place q nearer to c than r, a ball through p and q replaces the ball, r = |p - q|^2 / (2 n . (p - q)).
    The thickness is the diameter of the last ball whose q lies on an opposite wall (`LEAST_ANGLE`). All faces must look outwards.
    There are about `count` places; a mesh of many faces has up to 2 `count`.

    Raises:
        FilterInputError: not a mesh, or one without faces.
    """
    points, triangles = check_mesh(vertices, faces)
    if not len(triangles):
        raise FilterInputError("the mesh has no triangles: only a surface has walls")
    surface = Surface.of(points, triangles)
    samples, areas = face_samples(points, triangles, count)
    step = -(-len(samples) // (2 * count))
    places = sample_places(points, triangles, samples, np.arange(0, len(samples), step))
    face_normal = face_normals(points, triangles)
    normals = face_normal[samples[::step]]
    radii = np.full(len(normals), surface.mesh.diagonal / surface.mesh.scale)
    thickness = np.full(len(normals), np.inf)
    active = np.flatnonzero((normals != 0.0).any(axis=1))
    for _ in range(_BALLS):
        to_place = radii[active, None] * normals[active]
        nearest = surface.nearest(places[active] - to_place, vectors=True)
        inside = nearest.distances < (1.0 - _SAME) * radii[active]
        active, chord = active[inside], to_place[inside] + nearest.vectors[inside]
        rise = np.einsum("ij,ij->i", chord, normals[active])
        opposite = np.einsum("ij,ij->i", face_normal[nearest.elements[inside]], normals[active]) <= np.cos(LEAST_ANGLE)
        active, chord, rise, opposite = (a[rise > 0.0] for a in (active, chord, rise, opposite))
        if not len(active):
            break
        radii[active] = np.einsum("ij,ij->i", chord, chord) / (2.0 * rise)
        thickness[active[opposite]] = 2.0 * radii[active[opposite]]
    return Thickness(thickness, places, step * areas[::step])

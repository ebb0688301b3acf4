"""Compares two meshes: distances between the surfaces, changes of shape and faces, and attributes kept, lost and gained."""

import io
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..declaration import Floats
from ..files.errors import FileError
from ..files.formats import ATTRIBUTES, contents_of
from ..files.ply_write import write_ply
from ..filters.execution import blocks
from ..filters.geometry import angles_between, face_normals, vector_lengths
from ..filters.holes.rims import outer_borders
from ..filters.inspection import (
    SHARP,
    SharpEdges,
    Surface,
    SurfaceDistance,
    sample_places,
    share_kept,
    sharp_edges,
    surface_distance,
)
from ..filters.mesh import normalised_mesh, scaled_to_unit
from ..filters.topology import boundary_loops, connected_components
from ..mesh_data import MeshData
from ..running.read import ReadMesh
from ..running.suitability import traits_of

_APART = 1.0  # the distance from the other surface above which area counts as added or removed, in mean edges of the first mesh
_LARGEST = 1e76  # fourth powers of distances between coordinates up to this one do not overflow
_ROUNDING = 256 * float(np.finfo(np.float64).eps)  # the distance up to which points coincide, relative to the largest coordinate


@dataclass(frozen=True, eq=False)
class MeshState:
    """One mesh and its measures."""

    mesh: MeshData
    #: the fields of `SurfaceMeasures`, and these: number of ``border_loops``, broken borders included; number of ``holes``,
    #: border loops with "no" in `outer_borders`; number of ``self_intersecting_faces``, None if not searched; ``noise``, the
    #: trait of `traits_of` in mesh units, None without faces; ``sharp_edge_length`` in mesh units
    measures: dict[str, Any]
    sharp: SharpEdges

    @property
    def diagonal(self) -> float:
        return float(self.measures["diagonal"])

    @property
    def mean_edge(self) -> float:
        """Returns the mean edge in mesh units; for a cloud the mean distance to the nearest point."""
        return float(self.measures["mean_edge"] or self.measures["mean_spacing"] or 0.0)


def check_size(read: ReadMesh) -> None:
    """Raises `FileError` for coordinates above `_LARGEST`."""
    if (largest := float(np.abs(read.mesh.vertices).max(initial=0.0))) > _LARGEST:
        why = f"a coordinate is {largest:.3g} in size; areas and distances are computed up to {_LARGEST:g}"
        raise FileError(read.path, f"{why}: scale the mesh down first")


def state_of(read: ReadMesh) -> MeshState:
    """Measures a mesh; raises as `check_size`, and `FilterInputError` for a vertex so far away that other edges lose digits."""
    mesh = read.mesh
    normalised_mesh(mesh.vertices, mesh.faces).check_far()
    check_size(read)
    # Relative to the mean vertex, since coordinates are squared below.
    local = mesh.vertices - mesh.vertices.mean(axis=0)
    border = boundary_loops(local, mesh.faces)
    sharp = sharp_edges(mesh.vertices, mesh.faces)
    cuts, noise = read.self_intersecting, traits_of(read.measured, ("noise",)).get("noise")
    further_measures = {
        "border_loops": len(border.loops) + len(border.broken),
        "holes": outer_borders(border.loops, local, mesh.faces).count("no"),
        "self_intersecting_faces": None if cuts is None else int(cuts.sum()),
        "noise": None if noise is None else noise * read.measured.resolution(),
        "sharp_edge_length": math.fsum(sharp.lengths),
    }
    return MeshState(mesh, {**read.measures, **further_measures}, sharp)


@dataclass(frozen=True)
class Area:
    """A part of a surface that is out of tolerance: faces connected by vertices, or a point of a cloud."""

    mesh: str  # the mesh of this surface: "before" or "after"
    place: tuple[float, float, float]  # (x, y, z) of its point that is furthest from the other surface
    amount: float  # the distance of that point in mesh units, above 0 on the outer side of the other surface
    size: float  # the diagonal of the box of its samples and vertices that are out of tolerance, in mesh units
    area: float  # in square mesh units; 0 if no sample is out of tolerance


@dataclass(frozen=True)
class LengthIn:
    """A length in three units."""

    mesh_units: float
    mean_edges: float | None  # in units of `MeshState.mean_edge` of the first mesh or cloud; None if that is 0
    percent_of_diagonal: float | None  # of the first mesh's bounding box; None if the diagonal is 0


@dataclass(frozen=True)
class Moved:
    """The displacement of vertices, if both meshes have the same number of vertices and the same faces."""

    mean: LengthIn
    rms: LengthIn
    most: LengthIn  # the 99th percentile
    largest: LengthIn
    vertex: int  # the vertex with the largest displacement
    place: tuple[float, float, float]  # (x, y, z) of that vertex in the second mesh


@dataclass(frozen=True)
class Deviation:
    """Distances of one surface from the other: at samples of its faces, weighted by area, or at the points of a cloud.

    Distances are below 0 on the inner side of faces. Errors are twice the standard error of random samples.
    """

    samples: int
    mean: LengthIn  # of the signed distances
    mean_size: LengthIn  # of the absolute distances
    rms: LengthIn
    standard_deviation: LengthIn  # of the signed distances
    percentiles: Mapping[str, LengthIn]  # of the absolute distances, for the keys "50", "90", "95" and "99"
    largest: LengthIn  # the largest absolute distance, found by a search within faces
    place: tuple[float, float, float]  # (x, y, z) of the point with the largest distance
    at_most: LengthIn  # an upper bound of the distance of every point of the surface
    within: float | None  # the share of the area within the tolerance; None without a tolerance
    mean_error: LengthIn  # the error of `mean`, and so on
    mean_size_error: LengthIn
    rms_error: LengthIn
    within_error: float | None


@dataclass(frozen=True)
class Comparison:
    """The comparison of two meshes."""

    before: dict[str, Any]  # `MeshState.measures` of the first
    after: dict[str, Any]  # `MeshState.measures` of the second
    after_from_before: Deviation  # distances of the second surface from the first
    before_from_after: Deviation  # distances of the first surface from the second
    hausdorff: LengthIn  # the larger of the two largest distances
    hausdorff_at_most: LengthIn  # an upper bound of the Hausdorff distance
    rounding: float  # the distance up to which points coincide, by the largest coordinate of both meshes
    same_surface: bool  # whether `hausdorff_at_most` is at most `rounding`
    displacement: Moved | None  # None for clouds, and unless `same_elements`
    area_change: float | None  # in percent; None if the first has no area
    volume_change: float | None  # in percent; None unless both meshes have a volume and the first volume is not 0
    normal_deviation: float | None  # the mean angle in degrees between both surfaces' normals, by area; None if one has no area
    largest_normal_deviation: float | None  # in degrees
    flipped_faces: int | None  # number of faces of the second mesh turned by over 90 degrees at more than half of their samples
    sharp_edges_kept: float | None  # share by length: sharp edges of the first with a sharp edge of the second within a mean edge
    added_area: float | None  # area of the second mesh further than a mean edge from the first, in square mesh units
    removed_area: float | None  # area of the first mesh further than a mean edge from the second, in square mesh units
    attributes_kept: tuple[str, ...]
    attributes_lost: tuple[str, ...]
    attributes_gained: tuple[str, ...]
    tolerance: LengthIn | None = None  # the largest allowed distance, or None
    passed: bool | None = None  # whether all distances are within the tolerance; None without one
    out_of_tolerance: tuple[Area, ...] = ()  # the areas beyond the tolerance, the furthest first
    sharp_angle: float = SHARP  # the least dihedral angle of a sharp edge, in degrees


def same_elements(first: MeshData, second: MeshData) -> bool:
    """Returns whether two meshes have the same number of vertices and the same faces."""
    return len(first.vertices) == len(second.vertices) and np.array_equal(first.faces, second.faces)


def rounding_of(*meshes: MeshData) -> float:
    """Returns the distance up to which points of meshes coincide."""
    return _ROUNDING * max(float(np.abs(mesh.vertices).max(initial=0.0)) for mesh in meshes)


@dataclass(frozen=True, eq=False)
class Compared:
    """Two meshes, their comparison, and the distances at each sample."""

    before: MeshState  # the first
    after: MeshState  # the second
    comparison: Comparison
    after_distance: SurfaceDistance  # of the second from the first

    @property
    def meshes(self) -> dict[str, MeshData]:
        return {"before": self.before.mesh, "after": self.after.mesh}

    @property
    def tolerance(self) -> float:
        """Returns the tolerance in mesh units; 0 without one."""
        return self.comparison.tolerance.mesh_units if self.comparison.tolerance else 0.0


def compare(before: MeshState, after: MeshState, *, tolerance: float | None = None) -> Compared:
    """Compares two meshes or clouds; the tolerance is in mesh units."""
    first, second = before.mesh, after.mesh
    # The two searches run in turn, since each takes as much memory as all the rest.
    after_distance = surface_distance(second.vertices, second.faces, Surface.of(first.vertices, first.faces))
    before_distance = surface_distance(first.vertices, first.faces, Surface.of(second.vertices, second.faces))
    has_same_faces = bool(len(first.faces)) and same_elements(first, second)

    def length(value: float) -> LengthIn:
        edge, diagonal = before.mean_edge, before.diagonal
        return LengthIn(float(value), float(value / edge) if edge else None, float(100 * value / diagonal) if diagonal else None)

    verdict: dict[str, Any] = {}
    if tolerance is not None:
        sides = ("after", after, after_distance), ("before", before, before_distance)
        areas = [area for side in sides for area in _out_of_tolerance(*side, tolerance)]
        ordered = tuple(sorted(areas, key=lambda area: -abs(area.amount)))
        verdict = {"tolerance": length(tolerance), "passed": not ordered, "out_of_tolerance": ordered}
    at_most = max(after_distance.at_most, before_distance.at_most)
    rounding = rounding_of(first, second)
    attributes_before, attributes_after = (contents_of(mesh) for mesh in (first, second))
    comparison = Comparison(
        before=before.measures,
        after=after.measures,
        after_from_before=_deviation(after_distance, tolerance, length),
        before_from_after=_deviation(before_distance, tolerance, length),
        hausdorff=length(max(after_distance.largest, before_distance.largest)),
        hausdorff_at_most=length(at_most),
        rounding=rounding,
        same_surface=at_most <= rounding,
        displacement=_moved(first.vertices, second.vertices, length) if has_same_faces else None,
        area_change=_change(before.measures["area"], after.measures["area"]),
        volume_change=_change(before.measures["volume"], after.measures["volume"]),
        sharp_edges_kept=share_kept(before.sharp, after.sharp, within=before.mean_edge),
        attributes_kept=tuple(a for a in ATTRIBUTES if a in attributes_before and a in attributes_after),
        attributes_lost=tuple(a for a in ATTRIBUTES if a in attributes_before and a not in attributes_after),
        attributes_gained=tuple(a for a in ATTRIBUTES if a in attributes_after and a not in attributes_before),
        **verdict,
        **_faces(before, after, after_distance, before_distance, same_faces=has_same_faces),
    )
    return Compared(before, after, comparison, after_distance)


def _out_of_tolerance(name: str, state: MeshState, distance: SurfaceDistance, tolerance: float) -> Iterator[Area]:
    if distance.largest <= tolerance:
        return
    mesh, over = state.mesh, np.flatnonzero(np.abs(distance.distances) > tolerance)
    faces, amounts, weights = distance.faces[over], distance.distances[over], distance.weights[over]
    part, places = np.arange(len(over)), sample_places(mesh.vertices, mesh.faces, distance.faces, over)
    if len(mesh.faces):
        # Samples miss the tips of spikes, so vertices and the furthest place are added, without area.
        face_of_vertex = np.full(len(mesh.vertices), -1)
        face_of_vertex[mesh.faces] = np.arange(len(mesh.faces))[:, None]
        tips = np.flatnonzero((np.abs(distance.at_vertices) > tolerance) & (face_of_vertex >= 0))
        faces = np.concatenate([faces, face_of_vertex[tips], [distance.furthest_face]])
        amounts = np.concatenate([amounts, distance.at_vertices[tips], [distance.at_furthest]])
        places = np.concatenate([places, mesh.vertices[tips], [distance.furthest]])
        weights = np.concatenate([weights, np.zeros(len(tips) + 1)])
        used, row = np.unique(faces, return_inverse=True)
        part = connected_components(mesh.faces[used], len(mesh.vertices))[0][mesh.faces[used, 0]][row]
    order = np.lexsort((-np.abs(amounts), part))
    for rows in np.split(order, np.flatnonzero(np.diff(part[order])) + 1):
        x, y, z = places[rows[0]].tolist()
        size = float(np.linalg.norm(np.ptp(places[rows], axis=0)))
        yield Area(name, (x, y, z), float(amounts[rows[0]]), size, float(weights[rows].sum()) * state.measures["area"])


def _moved(before: Floats, after: Floats, length: Callable[[float], LengthIn]) -> Moved:
    d = vector_lengths(after - before)
    worst = int(d.argmax())
    x, y, z = after[worst].tolist()
    mean, rms, most, largest = map(length, (d.mean(), np.sqrt((d**2).mean()), np.quantile(d, 0.99), d[worst]))
    return Moved(mean, rms, most, largest, worst, (x, y, z))


def _deviation(distance: SurfaceDistance, tolerance: float | None, length: Callable[[float], LengthIn]) -> Deviation:
    lengths = {**vars(distance.statistics(tolerance)), "largest": distance.largest, "at_most": distance.at_most}
    shares = {name: lengths.pop(name) for name in ("samples", "within", "within_error")}
    percentiles = {percent: length(value) for percent, value in lengths.pop("percentiles").items()}
    x, y, z = distance.furthest.tolist()
    return Deviation(**{**shares, **{k: length(v) for k, v in lengths.items()}}, percentiles=percentiles, place=(x, y, z))


def _change(before: float | None, after: float | None) -> float | None:
    return 100.0 * (after - before) / abs(before) if before and after is not None else None


def _faces(
    before: MeshState, after: MeshState, samples: SurfaceDistance, samples_before: SurfaceDistance, *, same_faces: bool
) -> dict[str, Any]:
    """Compares normals and areas of faces at the samples of two meshes; all values are None if a mesh has no area."""
    names = ("normal_deviation", "largest_normal_deviation", "flipped_faces", "added_area", "removed_area")
    if not (before.measures["area"] and after.measures["area"]):
        return dict.fromkeys(names)
    before_normals, after_normals = (face_normals(scaled_to_unit(m.vertices)[0], m.faces) for m in (before.mesh, after.mesh))
    angles, has_angle = np.empty(len(samples.faces)), np.empty(len(samples.faces), dtype=np.bool_)
    for part in blocks(len(angles)):
        normals = after_normals[samples.faces[part]]
        reference = before_normals[(samples.faces if same_faces else samples.elements)[part]]
        angles[part] = np.degrees(angles_between(reference, normals))
        has_angle[part] = normals.any(axis=1) & reference.any(axis=1)
    votes = np.bincount(samples.faces[has_angle], np.where(angles[has_angle] > 90.0, 1.0, -1.0))
    weights = samples.weights * has_angle
    threshold = _APART * before.mean_edge
    values = (
        float(angles @ weights / weights.sum()) if weights.any() else None,
        float(angles[has_angle].max()) if has_angle.any() else None,
        int((votes > 0.0).sum()),
        float(after.measures["area"] * samples.weights[np.abs(samples.distances) > threshold].sum()),
        float(before.measures["area"] * samples_before.weights[np.abs(samples_before.distances) > threshold].sum()),
    )
    return dict(zip(names, values, strict=True))


FORMATS = ("csv", "ply")  # of files with the distances of vertices: a table, or a mesh with the distance as its scalar


def deviations_file(mesh: MeshData, distances: Floats, extension: str) -> bytes:
    """Returns a file of `FORMATS` with the (n,) signed distances of vertices, in full precision."""
    file = io.BytesIO()
    if extension == "csv":
        rows = np.column_stack([np.arange(len(distances)), mesh.vertices, distances])
        np.savetxt(file, rows, fmt=("%d", *4 * ("%.17g",)), delimiter=",", header="vertex,x,y,z,distance", comments="")
    else:
        scalars = {"scalars": distances}
        write_ply(MeshData(vertices=mesh.vertices, faces=mesh.faces, edges=mesh.edges, vertex_attributes=scalars), file)
    return file.getvalue()

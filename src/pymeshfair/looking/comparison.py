"""Comparison of two meshes: the distance of each surface from the other, and what was kept, lost, added and removed.

Two quantities, never mixed: the distance between the surfaces, and the displacement of vertices that are the same in both.
"""

import io
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..declaration import Floats, Ints
from ..files.formats import ATTRIBUTES, attributes_of
from ..files.ply_write import write_ply
from ..filters.denoising import estimate_noise
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
from ..filters.mesh import bounding_box, scaled_to_unit
from ..filters.topology import boundary_loops, connected_components
from ..mesh_data import MeshData
from ..running.read import ReadMesh

#: vertices of a mesh beyond which a quarter of it gives the same noise, in a quarter of the time and memory
MOST_OF_NOISE = 100_000
#: cells of that part along the longest side of the box
_CELLS = 8

#: mean edges of the first mesh: a place further than that from the other surface was added or removed
_APART = 1.0
#: of the largest coordinate: points no further apart are the same place
_ROUNDING = 256 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class MeshState:
    """One mesh and its measures."""

    mesh: MeshData
    #: `pymeshfair.filters.inspection.surface_measures.SurfaceMeasures` by name, and ``border_loops``; ``holes``, the border loops
    #: that do not go round the outside of a sheet; ``self_intersecting_faces``, None if not looked for; ``noise``, the standard
    #: deviation along the normals in mesh units, None of a cloud, above `MOST_OF_NOISE` vertices that of about a quarter of them;
    #: ``sharp_edge_length``
    measures: dict[str, Any]
    sharp: SharpEdges  # the sharp edges

    @property
    def diagonal(self) -> float:
        """Of the bounding box, in mesh units."""
        return float(self.measures["diagonal"])

    @property
    def mean_edge(self) -> float:
        """In mesh units; of a cloud the mean distance to the nearest point."""
        return float(self.measures["mean_edge"] or self.measures["mean_spacing"] or 0.0)


def state_of(read: ReadMesh) -> MeshState:
    """Measure a mesh."""
    mesh = read.mesh
    # About the middle, as squares of coordinates are taken below.
    local = mesh.vertices - mesh.vertices.mean(axis=0)
    border = boundary_loops(local, mesh.faces)
    holes = [outer for outer in outer_borders(border.loops, local, mesh.faces) if outer == "no"]
    sharp = sharp_edges(mesh.vertices, mesh.faces)
    cuts = read.self_intersecting
    more = {
        "border_loops": len(border.loops) + len(border.broken),
        "holes": len(holes),
        "self_intersecting_faces": None if cuts is None else int(cuts.sum()),
        "noise": estimate_noise(*part_for_noise(mesh.vertices, mesh.faces)).length if len(mesh.faces) else None,
        "sharp_edge_length": math.fsum(sharp.lengths),
    }
    return MeshState(mesh, {**read.measures, **more}, sharp)


def part_for_noise(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """A mesh; of a large one the faces within about a quarter of the cells of a grid, spread over all of it."""
    low, high = bounding_box(vertices)
    size = float((high - low).max())
    if len(vertices) <= MOST_OF_NOISE or not size > 0.0:
        return vertices, faces
    i, j, k = ((vertices - low) * (_CELLS / size)).astype(np.int64).T
    chosen = (i * 73_856_093 ^ j * 19_349_663 ^ k * 83_492_791) % 7 < 2  # a hash, so that no plane of cells is all or nothing
    inside = chosen[faces].all(axis=1)
    if 8 * np.count_nonzero(inside) < len(faces):  # a vertex far away has made the cells too large
        return vertices, faces
    number = np.cumsum(chosen) - 1
    return vertices[chosen], number[faces[inside]].astype(faces.dtype)


@dataclass(frozen=True)
class Area:
    """A part of a surface that lies out of the tolerance; its faces share vertices."""

    mesh: str  # "after", or "before" of what the second mesh does not have
    place: tuple[float, float, float]  # (x, y, z) where it lies furthest from the other surface
    amount: float  # how far that is, above 0 on the outer side of the other surface; in mesh units, as the next one
    size: float  # the diagonal of its box
    area: float  # of it, in square mesh units


@dataclass(frozen=True)
class LengthIn:
    """A length in three units."""

    mesh_units: float  # as the coordinates have it
    mean_edges: float | None  # over the mean edge of the first mesh; None if it has none
    percent_of_diagonal: float | None  # over the diagonal of its bounding box; None if that is 0


@dataclass(frozen=True)
class Moved:
    """Displacement of the vertices that are the same in both meshes."""

    mean: LengthIn  # of the distances
    rms: LengthIn  # the root of the mean of their squares
    most: LengthIn  # the distance that 99 % of them keep below
    largest: LengthIn  # of the distances
    vertex: int  # the vertex of the second mesh that has it
    place: tuple[float, float, float]  # (x, y, z) of that vertex


@dataclass(frozen=True)
class Deviation:
    """Distances of one surface from the other, in samples on its faces by area; in a cloud in its points.

    The sign is that of the outer side of the other surface. Errors are twice the standard error of as many random samples.
    """

    samples: int  # how many
    mean: LengthIn  # of the signed distances
    mean_size: LengthIn  # of the distances without sign
    rms: LengthIn  # the root of the mean of their squares
    standard_deviation: LengthIn  # of the signed distances about their mean
    percentiles: Mapping[str, LengthIn]  # what 50, 90, 95 and 99 % of the area keep below without sign, by "50" ..
    largest: LengthIn  # the largest distance without sign, which faces were searched for
    place: tuple[float, float, float]  # (x, y, z) where that is
    at_most: LengthIn  # no place of the surface lies further
    within: float | None  # the share of the area within the tolerance; None without a tolerance
    mean_error: LengthIn  # of `mean`; of the next ones so
    mean_size_error: LengthIn
    rms_error: LengthIn
    within_error: float | None


@dataclass(frozen=True)
class Comparison:
    """Two meshes compared."""

    before: dict[str, Any]  # `MeshState.measures` of the first
    after: dict[str, Any]  # those of the second
    after_from_before: Deviation  # how far the second surface lies from the first
    before_from_after: Deviation  # how far the first lies from the second; above 0 are places on the outer side of the second
    hausdorff: LengthIn  # the larger of the two largest distances
    hausdorff_at_most: LengthIn  # it is no larger than that
    rounding: float  # of coordinates of such a size; points no further apart are the same place
    same_surface: bool  # whether the surfaces lie no further apart than that, everywhere
    displacement: Moved | None  # of the vertices; None unless both meshes have as many of them, and the same faces
    area_change: float | None  # in percent, None without area before
    volume_change: float | None  # in percent, None unless both have a volume that is not 0
    normal_deviation: float | None  # the mean angle in degrees between the normals of both, by area; None of clouds
    largest_normal_deviation: float | None  # in degrees
    flipped_faces: int | None  # faces of the second mesh that look away from where the first does there, by more than 90 degrees
    sharp_edges_kept: float | None  # the share of the length of sharp edges that have one within a mean edge; None without any
    added_area: float | None  # of the second mesh further than a mean edge from the first
    removed_area: float | None  # of the first further than a mean edge from the second
    attributes_kept: tuple[str, ...]  # attributes of both meshes; then those of one alone
    attributes_lost: tuple[str, ...]
    attributes_gained: tuple[str, ...]
    tolerance: LengthIn | None = None  # within which the surfaces should lie; without one the next two are empty
    passed: bool | None = None  # whether neither lies further from the other than the tolerance
    out_of_tolerance: tuple[Area, ...] = ()  # the areas that lie further, the furthest first
    sharp_angle: float = SHARP  # degrees from which on an edge counts as sharp


#: of `Deviation`, what the distances have by the same names
_LENGTHS = ("mean", "mean_size", "rms", "standard_deviation", "mean_error", "mean_size_error", "rms_error")


def same_elements(first: MeshData, second: MeshData) -> bool:
    """Whether both have as many vertices and the same faces, so that vertices of the same number are the same."""
    return len(first.vertices) == len(second.vertices) and np.array_equal(first.faces, second.faces)


@dataclass(frozen=True, eq=False)
class Compared:
    """Two meshes and their comparison, place by place, too."""

    before: MeshState  # the first
    after: MeshState  # the second
    comparison: Comparison
    after_distance: SurfaceDistance  # of the second from the first
    before_distance: SurfaceDistance  # of the first from the second

    @property
    def meshes(self) -> dict[str, MeshData]:
        """Both by their names."""
        return {"before": self.before.mesh, "after": self.after.mesh}

    @property
    def tolerance(self) -> float:
        """In mesh units; 0 without one."""
        return self.comparison.tolerance.mesh_units if self.comparison.tolerance else 0.0


def compare(before: MeshState, after: MeshState, *, tolerance: float | None = None) -> Compared:
    """Compare two meshes or clouds; the tolerance is in mesh units."""
    first, second = before.mesh, after.mesh
    # One after the other: what searches need takes as much memory as all the rest.
    there = surface_distance(second.vertices, second.faces, Surface.of(first.vertices, first.faces))
    here = surface_distance(first.vertices, first.faces, Surface.of(second.vertices, second.faces))
    same_vertices = bool(len(first.faces)) and same_elements(first, second)

    def length(value: float) -> LengthIn:
        edge, diagonal = before.mean_edge, before.diagonal
        return LengthIn(float(value), float(value / edge) if edge else None, float(100 * value / diagonal) if diagonal else None)

    judged: dict[str, Any] = {}
    if tolerance is not None:
        areas = [*_out_of_tolerance("after", after, there, tolerance), *_out_of_tolerance("before", before, here, tolerance)]
        ordered = tuple(sorted(areas, key=lambda area: -abs(area.amount)))
        passed = max(there.largest, here.largest) <= tolerance
        judged = {"tolerance": length(tolerance), "passed": passed, "out_of_tolerance": ordered}
    at_most = max(there.at_most, here.at_most)
    rounding = _ROUNDING * max(float(np.abs(mesh.vertices).max()) for mesh in (first, second))
    had, has = (attributes_of(mesh) for mesh in (first, second))
    comparison = Comparison(
        before=before.measures,
        after=after.measures,
        after_from_before=_deviation(there, tolerance, length),
        before_from_after=_deviation(here, tolerance, length),
        hausdorff=length(max(there.largest, here.largest)),
        hausdorff_at_most=length(at_most),
        rounding=rounding,
        same_surface=at_most <= rounding,
        displacement=_moved(first.vertices, second.vertices, length) if same_vertices else None,
        area_change=_change(before.measures["area"], after.measures["area"]),
        volume_change=_change(before.measures["volume"], after.measures["volume"]),
        sharp_edges_kept=share_kept(before.sharp, after.sharp, within=before.mean_edge),
        attributes_kept=tuple(a for a in ATTRIBUTES if a in had and a in has),
        attributes_lost=tuple(a for a in ATTRIBUTES if a in had and a not in has),
        attributes_gained=tuple(a for a in ATTRIBUTES if a in has and a not in had),
        **judged,
        **_faces(before, after, there, here, same_faces=same_vertices),
    )
    return Compared(before, after, comparison, there, here)


def _out_of_tolerance(name: str, state: MeshState, distance: SurfaceDistance, tolerance: float) -> Iterator[Area]:
    """The parts of a surface, or points of a cloud, that lie further from another one than the tolerance."""
    mesh, over = state.mesh, np.flatnonzero(np.abs(distance.distances) > tolerance)
    if not len(over):
        return
    part = np.arange(len(over))
    if len(mesh.faces):
        faces, row = np.unique(distance.faces[over], return_inverse=True)
        parts, _ = connected_components(mesh.faces[faces], len(mesh.vertices))
        part = parts[mesh.faces[faces, 0]][row]
    order = np.lexsort((-np.abs(distance.distances[over]), part))
    starts = np.flatnonzero(np.diff(part[order], prepend=-1))
    for rows in np.split(over[order], starts[1:]):
        places = sample_places(mesh.vertices, mesh.faces, distance.faces, rows)
        x, y, z = places[0].tolist()
        size = float(np.linalg.norm(np.ptp(places, axis=0)))
        area = float(distance.weights[rows].sum()) * state.measures["area"]
        yield Area(name, (x, y, z), float(distance.distances[rows[0]]), size, area)


def _moved(before: Floats, after: Floats, length: Callable[[float], LengthIn]) -> Moved:
    d = vector_lengths(after - before)
    worst = int(d.argmax())
    x, y, z = after[worst].tolist()
    mean, rms, most, largest = map(length, (d.mean(), np.sqrt((d**2).mean()), np.quantile(d, 0.99), d[worst]))
    return Moved(mean, rms, most, largest, worst, (x, y, z))


def _deviation(distance: SurfaceDistance, tolerance: float | None, length: Callable[[float], LengthIn]) -> Deviation:
    statistics = vars(distance.statistics(tolerance))
    x, y, z = distance.furthest.tolist()
    lengths = {name: length(statistics[name]) for name in _LENGTHS}
    percentiles = {percent: length(value) for percent, value in statistics["percentiles"].items()}
    more = {"percentiles": percentiles, "largest": length(distance.largest), "at_most": length(distance.at_most)}
    return Deviation(**{**statistics, **lengths, **more, "place": (x, y, z)})


def _change(before: float | None, after: float | None) -> float | None:
    """In percent."""
    return 100.0 * (after - before) / abs(before) if before and after is not None else None


def _faces(
    before: MeshState, after: MeshState, there: SurfaceDistance, here: SurfaceDistance, *, same_faces: bool
) -> dict[str, Any]:
    """Measures of faces from the samples of two meshes; all None if one of them has no faces."""
    names = ("normal_deviation", "largest_normal_deviation", "flipped_faces", "added_area", "removed_area")
    if not (len(before.mesh.faces) and len(after.mesh.faces)):
        return dict.fromkeys(names)
    old, new = (face_normals(scaled_to_unit(m.vertices)[0], m.faces) for m in (before.mesh, after.mesh))
    angles, counted = np.empty(len(there.faces)), np.empty(len(there.faces), dtype=np.bool_)
    for part in blocks(len(angles)):
        normals, ground = new[there.faces[part]], old[(there.faces if same_faces else there.elements)[part]]
        angles[part] = np.degrees(angles_between(ground, normals))
        counted[part] = normals.any(axis=1) & ground.any(axis=1)
    turned = np.bincount(there.faces[counted], np.where(angles[counted] > 90.0, 1.0, -1.0))
    weights = there.weights * counted
    apart = _APART * before.mean_edge
    values = (
        float(angles @ weights / weights.sum()) if weights.any() else None,
        float(angles[counted].max()) if counted.any() else None,
        int((turned > 0.0).sum()),
        float(after.measures["area"] * there.weights[np.abs(there.distances) > apart].sum()),
        float(before.measures["area"] * here.weights[np.abs(here.distances) > apart].sum()),
    )
    return dict(zip(names, values, strict=True))


#: the extensions of files with the distance of every vertex from the other surface: a table, or a mesh whose scalar it is
FORMATS = ("csv", "ply")


def deviations_file(mesh: MeshData, distances: Floats, extension: str) -> bytes:
    """The bytes of a file of `FORMATS` with (n,) distances, how far outwards each vertex lies, as exact as in memory."""
    file = io.BytesIO()
    if extension == "csv":
        rows = np.column_stack([np.arange(len(distances)), mesh.vertices, distances])
        np.savetxt(file, rows, fmt=("%d", *4 * ("%.17g",)), delimiter=",", header="vertex,x,y,z,distance", comments="")
    else:
        write_ply(MeshData(vertices=mesh.vertices, faces=mesh.faces, vertex_attributes={"scalars": distances}), file)
    return file.getvalue()

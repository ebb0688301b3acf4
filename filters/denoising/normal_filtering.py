"""Denoising by rounds of two steps: filters the face normals, then fits the vertices to them."""

import math
from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice, check_whole_number
from ..compilation import compiled, prange
from ..execution import Progress, ignore_progress, threads_for
from ..geometry import AREA, NORMAL, looking_away, measure_faces, squared_length
from ..mesh import Bools, Floats, Ints, Longs, NormalisedMesh, Whole, check_mesh, normalised_mesh
from ..topology import BORDER_POLICIES, BorderPolicy
from .face_neighbourhoods import RINGS_OF_NEIGHBORHOOD, Adjacency, FaceNeighbourhoods, centre_distance_sums, mean_centre_distance
from .normal_filter import NormalFilter, Weighting, mean_normals, weighted_normals
from .vertex_update import VertexUpdate, fit_vertices

# Prevents 0 / 0 in the measure of a flat patch.
_EPSILON = 1e-9
# After a round the corners of newly folded faces move back. That may fold other faces, so it is done again, at most this often.
_FOLD_TESTS = 2
# A guide normal depends on at most this many rings of faces around its face.
_RINGS_OF_GUIDE = {"averaged": 1, "guided": 3}
# The bounding box to use for points that are normalised already: normalising them again then changes no bit.
_AS_THEY_ARE = Whole(np.full(3, -0.25), np.full(3, 0.25))


def normal_filtering(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    vertex_iterations: int = 10,
    outer_iterations: int = 1,
    vertex_update: VertexUpdate = "sun",
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
    **normal_filter: Any,
) -> Floats:
    """Filters the face normals and fits the vertices to them, `outer_iterations` times.

    Areas, centres and normals are measured anew in each outer iteration. The defaults are those of the authors' code of
    [zheng2011]: one outer iteration of 20 passes, then 10 vertex steps. Many outer iterations of one pass keep features better.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        vertex_iterations: vertex steps in each outer iteration. More steps fit the normals, and their errors, more closely.
        outer_iterations: number of rounds. More rounds give a smoother mesh.
        vertex_update: method of the fit; see `VertexUpdate`.
        border: "fixed": border vertices stay. "along": they move along the mean normal of their faces only, so that the outline
            seen along that normal stays. "free": they move like any other vertex.
        movable: (n,) bool, which vertices may move, None for all. Faces of fixed vertices still count.
        progress: called after every pass and every fit; may raise to stop.
        **normal_filter: the attributes of `NormalFilter`, by name: ``method="guided", normal_iterations=5``. Each outer
            iteration has `normal_iterations` passes, and measures the unit of `space_sigma` anew.

    Returns:
        (n, 3) float64, equal for any thread count. Vertices that are unused, not `movable` or on a fixed border keep every bit.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    check_whole_number("vertex_iterations", vertex_iterations)
    outer = check_whole_number("outer_iterations", outer_iterations)
    check_choice("vertex_update", vertex_update, VertexUpdate)
    check_choice("border", border, BORDER_POLICIES)
    settings = NormalFilter(**normal_filter)
    mesh = normalised_mesh(points, triangles, movable)
    may_sort = settings.ignores_numbers_of_faces and vertex_update != "conjugate_gradient"
    sweeps = outer * (settings.normal_iterations + vertex_iterations) if may_sort else 0
    adjacency = Adjacency.of(mesh, sweeps=sweeps)
    mesh = mesh.in_order(adjacency.places)
    finished, now = 0, mesh.points
    results = rounds(
        mesh,
        adjacency,
        settings,
        vertex_iterations=vertex_iterations,
        vertex_update=vertex_update,
        border=border,
        progress=lambda share: progress((finished + 0.9 * share) / outer),
    )
    for finished, result in enumerate(islice(results, outer), 1):
        now = result
        progress(finished / outer)
    return mesh.restored(now)


def filter_face_normals(
    vertices: ArrayLike, faces: ArrayLike, *, progress: Progress = ignore_progress, **normal_filter: Any
) -> Floats:
    """Returns (m, 3) the filtered unit normals of the faces and moves no vertex; arguments as in `normal_filtering`.

    A face without area gets a mean normal of its neighbours, or 0 if all their weights are 0.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    settings = NormalFilter(**normal_filter)
    mesh = normalised_mesh(points, triangles)
    adjacency = Adjacency.of(mesh, sweeps=settings.normal_iterations if settings.ignores_numbers_of_faces else 0)
    now = mesh.in_order(adjacency.places).points
    filtered = NormalPasses(now, adjacency, settings).filtered(measure_faces(now, adjacency.faces), progress)
    if adjacency.face_places is not None:
        permuted, filtered = filtered, np.empty_like(filtered)
        filtered[adjacency.face_places] = permuted
    if len(filtered) == len(triangles):
        return filtered
    # A vertex that only degenerate faces use (faces that name a vertex twice) is not in the normalised mesh, nor are these faces.
    normals = np.zeros((len(triangles), 3))
    normals[np.isin(triangles, mesh.used).all(axis=1)] = filtered
    return normals


def rounds(
    mesh: NormalisedMesh,
    adjacency: Adjacency,
    settings: NormalFilter,
    *,
    vertex_iterations: int,
    vertex_update: VertexUpdate = "sun",
    border: BorderPolicy = "along",
    distance: float | None = None,
    progress: Progress = ignore_progress,
) -> Iterator[Floats]:
    """Yields the points after each round of `normal_filtering`, without end, or nothing if no point may move.

    The mesh is in the order of `adjacency`. `progress` gets the share of finished passes.
    """
    moves = np.diff(adjacency.at_vertices.offsets) > 0
    if mesh.movable is not None:
        moves &= mesh.movable
    if border == "fixed":
        moves &= ~adjacency.on_border
    passes = NormalPasses(mesh.points, adjacency, settings, distance)
    now = mesh.points
    table = measure_faces(now, adjacency.faces)
    folded = _folded(adjacency, table)
    while moves.any():
        after = fit_vertices(
            now,
            adjacency.faces,
            adjacency.at_vertices,
            passes.filtered(table, progress),
            update=vertex_update,
            iterations=vertex_iterations,
            moves=moves,
            along_normal=adjacency.on_border if border == "along" else None,
            overwrite=table,
        )
        for tests_left in reversed(range(2 + _FOLD_TESTS)):
            measure_faces(after, adjacency.faces, table)
            still_folded = _folded(adjacency, table)
            corners = adjacency.faces[still_folded & ~folded]
            if tests_left == 0 or len(corners) == 0:
                break
            after[corners] = now[corners]
        now, folded = after, still_folded
        yield now


def _folded(adjacency: Adjacency, table: Floats) -> Bools:
    return looking_away(table[:, [AREA]] * table[:, NORMAL], adjacency.faces, len(adjacency.at_vertices.offsets) - 1)


class NormalPasses:
    """Filters face normals in the order of `adjacency`; for part of a mesh, `distance` is `mean_centre_distance` of the whole."""

    def __init__(self, points: Floats, adjacency: Adjacency, settings: NormalFilter, distance: float | None = None) -> None:
        self._settings, self._adjacency, self._distance = settings, adjacency, distance
        self._edge = adjacency.around("edge")
        self._averaged = adjacency.within(settings.neighborhood, points, settings.radius)
        self._cut_off = adjacency.cut_off(settings.neighborhood, settings.radius)

    def filtered(self, table: Floats, progress: Progress) -> Floats:
        """Returns (m, 3) the filtered unit normals of the faces; may overwrite the normals in the table of `measure_faces`."""
        settings, around = self._settings, self._adjacency.around
        distance = mean_centre_distance(table, self._edge) if self._distance is None else self._distance
        weighting = Weighting.of(settings, distance)
        normals = np.ascontiguousarray(table[:, NORMAL])
        for iteration in range(settings.normal_iterations):
            if settings.method == "mean":
                normals = mean_normals(normals, table, self._averaged)
            else:
                guide = None
                if settings.method == "averaged":
                    guide = mean_normals(normals, table, around("vertex"))
                elif settings.method == "guided":
                    guide = guide_normals(normals, table, around("vertex"), self._edge)
                normals = weighted_normals(normals, table, self._averaged, weighting, guide=guide, cut_off=self._cut_off)
            progress((iteration + 1) / settings.normal_iterations)
        return normals


def guide_normals(normals: Floats, table: Floats, patches: FaceNeighbourhoods, edge_neighbours: FaceNeighbourhoods) -> Floats:
    """Returns (m, 3) the guide normals: the area-weighted mean normal of the most uniform patch with the face [zhang2015].

    The patch of a face is the face and those that `patches` lists: all that share a vertex with it. A patch is uniform if H = D R
    is small. D is the largest |n_j - n_k| between two faces of the patch. R is the largest |n_j - n_k| across an edge between
    faces of the patch, as a share of the sum over all such edges.
    """
    measures, means, guides = np.empty(len(normals)), np.empty_like(normals), np.empty_like(normals)
    with threads_for(len(patches.neighbours)):
        _measure_patches(normals, np.ascontiguousarray(table[:, AREA]), patches, edge_neighbours, measures, means)
        _choose(measures, means, *patches, guides)
    return guides


@compiled(parallel=True)
def _measure_patches(
    normals: Floats, areas: Floats, patches: FaceNeighbourhoods, edge: FaceNeighbourhoods, measures: Floats, means: Floats
) -> None:
    offsets, neighbours = patches
    edge_offsets, edge_neighbours = edge
    for i in prange(normals.shape[0]):
        size = offsets[i + 1] - offsets[i] + 1
        patch = np.empty(size, dtype=np.int32)
        patch[0] = i
        patch[1:] = neighbours[offsets[i] : offsets[i + 1]]
        x = y = z = 0.0
        largest = 0.0
        for a in range(size):
            j = patch[a]
            x += areas[j] * normals[j, 0]
            y += areas[j] * normals[j, 1]
            z += areas[j] * normals[j, 2]
            for b in range(a + 1, size):
                largest = max(largest, squared_length(normals, j, patch[b]))
        total = steepest = 0.0
        for a in range(size):
            j = patch[a]
            for k in range(edge_offsets[j], edge_offsets[j + 1]):
                h = edge_neighbours[k]
                if h <= j:
                    continue
                for b in range(size):
                    if patch[b] == h:
                        difference = math.sqrt(squared_length(normals, j, h))
                        total += difference
                        steepest = max(steepest, difference)
                        break
        measures[i] = math.sqrt(largest) * steepest / (total + _EPSILON)
        length = math.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            means[i, 0], means[i, 1], means[i, 2] = x / length, y / length, z / length
        else:
            means[i, 0], means[i, 1], means[i, 2] = normals[i, 0], normals[i, 1], normals[i, 2]


@compiled(parallel=True)
def _choose(measures: Floats, means: Floats, offsets: Longs, neighbours: Ints, guides: Floats) -> None:
    for i in prange(measures.shape[0]):
        best = np.int32(i)
        for k in range(offsets[i], offsets[i + 1]):
            j = neighbours[k]
            # Among equal measures, as on planes, the patch of face i wins, else that of the lowest face number.
            if measures[j] < measures[best] or (measures[j] == measures[best] and best != i and j < best):
                best = j
        guides[i, 0], guides[i, 1], guides[i, 2] = means[best, 0], means[best, 1], means[best, 2]


def rings_of_round(settings: NormalFilter, vertex_iterations: int) -> int:
    """Returns the number of rings of faces around a vertex on which its position after one round depends.

    Raises:
        FilterInputError: the filter depends on a distance, not on rings of faces.
    """
    if settings.neighborhood not in RINGS_OF_NEIGHBORHOOD:
        raise FilterInputError(f"neighborhood {settings.neighborhood!r} has no rings of faces")
    rings_of_iteration = RINGS_OF_NEIGHBORHOOD[settings.neighborhood] + _RINGS_OF_GUIDE.get(settings.method, 0)
    return 2 + vertex_iterations + settings.normal_iterations * rings_of_iteration + 2 * _FOLD_TESTS


def needs_distance(settings: NormalFilter) -> bool:
    """Whether a round needs the mean distance between the centres of adjacent faces of the whole mesh."""
    return settings.method in ("bilateral", "averaged", "guided") and settings.space_kernel != "constant"


def round_of_part(
    points: Floats,
    faces: Ints,
    settings: NormalFilter,
    *,
    distance: float,
    vertex_iterations: int,
    vertex_update: VertexUpdate,
    border: BorderPolicy,
) -> Floats:
    """Returns (n, 3) the points of a part of a mesh after one round of `normal_filtering`.

    Points with `rings_of_round` rings around them get the same bits as in a run on the whole mesh. Points and faces are in the
    order of the whole mesh, and the points are normalised with its bounding box. `distance`: see `needs_distance`.
    """
    mesh = normalised_mesh(points, faces, whole=_AS_THEY_ARE)
    adjacency = Adjacency.of(mesh)
    mesh = mesh.in_order(adjacency.places)
    options: dict[str, Any] = {"vertex_iterations": vertex_iterations, "vertex_update": vertex_update, "border": border}
    results = rounds(mesh, adjacency, settings, distance=distance, **options)
    moved = points.copy()
    moved[mesh.used] = next(results, mesh.points)
    return moved


def distances_of_part(points: Floats, faces: Ints, counted: Bools) -> tuple[list[float], int]:
    """Returns numbers that add up exactly to the sum of the centre distances of edge neighbours, and the number of distances.

    The sum is over the faces in the mask `counted`; each needs two rings of faces around it. The points are normalised.
    One `math.fsum` over the lists of all parts gives the sum of the whole mesh, rounded once.
    """
    mesh = normalised_mesh(points, faces, whole=_AS_THEY_ARE)
    kept = np.isin(faces, mesh.used).all(axis=1)
    adjacency = Adjacency.of(mesh)
    edge = adjacency.around("edge")
    sums = centre_distance_sums(measure_faces(mesh.in_order(adjacency.places).points, adjacency.faces), edge)[counted[kept]]
    parts: list[float] = []
    while remainder := math.fsum([*sums.tolist(), *(-part for part in parts)]):
        parts.append(remainder)
    return parts, int(np.diff(edge.offsets)[counted[kept]].sum())

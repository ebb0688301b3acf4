"""Meshes by tiles: files of vertices and faces, tiles with rings of faces around them, and steps that move vertices.

`Cells` stores the vertices in groups of near ones, the cells; the slot of a vertex is its row. `Surface` stores the faces at the
vertices of each cell, with slots as corners. A tile is a range of cells. All tiles end a round of a filter before the next round
starts.
"""

import contextlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FilterInputError
from ..filters import denoising
from ..filters.execution import ignore_progress, part_of
from ..filters.geometry import vertex_normals_by_angle
from ..filters.inspection import folded_faces
from ..filters.mesh import Bools, Floats, Ints, Longs, NormalisedMesh, Whole, check_healthy, mask_of, normalised_mesh
from ..filters.topology import border_vertices, proper_faces
from .cells import Cells, Column, Part, Ranges, Results, Stored
from .cloud import Cloud
from .plan import NORMALS, Filtering, PlannedStep, apply, choose, cost_of, filtering_of, rings_of, slice_rows, surface_vertices
from .sources import MeshFile
from .workers import Tasks

_NO_FACES = np.empty((0, 3), np.int32)
#: vertices in the sample on which settings are chosen, and cells in each patch of the sample
_SAMPLE, _PATCH = 60_000, 4
#: the most vertices of a bucket if a step chooses its settings, so that patches do not depend on the tile size
_BUCKET = 1 << 16
#: a record of a face: the slots of its corners, and its number
FACE = np.dtype([("corners", "<i4", 3), ("number", "<i8")])


@dataclass(frozen=True)
class Surface:
    """The files of a mesh: its cells, the faces at the vertices of each bucket, and coordinates by slot."""

    cells: Cells
    #: (b + 1,) the first slot of each bucket, then the number of vertices; a bucket is a range of cells that fits into memory
    buckets: tuple[int, ...]
    faces: int = 0  # number of faces

    slots = Stored("<i4")  # the slot of each vertex, by vertex number
    moved = Stored("<f8", 3)  # new coordinates by slot
    before = Stored("<f8", 3)  # coordinates before a step that may fold faces
    state = Stored("<f8", 3)  # normalised coordinates between rounds; before the rounds, a result of `FilteringTiles.relax`
    next_state = Stored("<f8", 3)  # the state after a round; before the rounds, the result of `FilteringTiles.keep`

    def _file(self, kind: str, bucket: int) -> Path:
        return self.cells.folder / f"{kind}-{bucket}"

    def _starts(self, bucket: int) -> Column:
        """Returns the column with the first row of each cell in the bucket's file of faces, then the number of rows."""
        return Column(self.cells.folder / f"faces-{bucket}.starts", "<i8")

    def sort_in(self, slices: Callable[[], Iterable[NDArray[Any]]], size: int) -> int:
        """Writes each face, given by numbers of vertices, to the files of the buckets of its corners; counts the faces."""
        cells = self.cells
        self.slots.write(cells.count - 1, np.zeros(1))
        slots = np.memmap(self.slots.path, "<i4", "r+")
        for first, numbers in zip(range(0, cells.count, size), cells.numbers.slices(size), strict=True):
            slots[numbers] = np.arange(first, first + len(numbers))
        starts, count = np.array(self.buckets), 0
        self.remove_unordered()  # a process that was killed here may have left files
        for corners in slices():
            wrong = ((corners < 0) | (corners >= cells.count)).any(axis=1)
            if wrong.any():
                bad = int(wrong.argmax())
                raise FilterInputError(
                    f"face {count + bad} is {corners[bad].tolist()}, but the vertices are 0 to {cells.count - 1}: remove it"
                )
            faces = np.empty(len(corners), FACE)
            faces["corners"], faces["number"] = slots[corners], np.arange(count, count + len(corners))
            rows, bucket_of = _by_part(np.searchsorted(starts, faces["corners"], "right") - 1)
            buckets, firsts = np.unique(bucket_of, return_index=True)
            for bucket, part in zip(buckets.tolist(), np.split(rows, firsts[1:]), strict=False):
                with self._file("corners", bucket).open("ab") as file:
                    file.write(faces[part].tobytes())
            count += len(corners)
        return count

    def order_faces(self, bucket: int) -> None:
        """Sorts the faces of a bucket by cell; a face is repeated for each cell that has one of its corners."""
        raw = self._file("corners", bucket)
        faces = np.fromfile(raw, FACE) if raw.exists() else np.empty(0, FACE)
        starts = self.cells.starts
        first, last = np.searchsorted(starts, self.buckets[bucket : bucket + 2])
        cell = np.searchsorted(starts, faces["corners"], "right") - 1
        cell[(cell < first) | (cell >= last)] = -1
        rows, cell = _by_part(cell)
        self._file("faces", bucket).write_bytes(faces[rows].tobytes())
        counts = np.bincount(cell - first, minlength=last - first)
        self._starts(bucket).write(0, np.append(0, np.cumsum(counts)))

    def remove_unordered(self) -> None:
        for bucket in range(len(self.buckets) - 1):
            self._file("corners", bucket).unlink(missing_ok=True)

    def faces_at(self, cells: Longs) -> NDArray[Any]:
        """Returns the faces at the vertices of some cells, given in ascending order; faces at several cells are repeated."""
        faces = [np.empty(0, FACE)]
        bucket_of = np.searchsorted(np.array(self.buckets), self.cells.starts[cells], "right") - 1
        for bucket in np.unique(bucket_of).tolist():
            starts = self._starts(bucket).read(0, len(self._starts(bucket)))
            rows = cells[bucket_of == bucket] - np.searchsorted(self.cells.starts, self.buckets[bucket])
            for run in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1):
                begin, end = int(starts[run[0]]), int(starts[run[-1] + 1])
                faces.append(np.fromfile(self._file("faces", bucket), FACE, end - begin, offset=begin * FACE.itemsize))
        return np.concatenate(faces)

    def replace_column(self, new: Column, old: Column) -> None:
        with contextlib.suppress(FileNotFoundError):  # a killed process may have replaced the column before
            new.path.replace(old.path)


def _by_part(parts: Longs) -> tuple[Longs, Longs]:
    """Returns each face's row once for each of its (m, 3) `parts` (cells or buckets; -1: none), sorted by part, and the parts."""
    parts = np.sort(parts, axis=1)
    row, column = np.nonzero(np.diff(parts, axis=1, prepend=-1))
    parts = parts[row, column]
    order = np.argsort(parts, kind="stable")
    return row[order], parts[order]


@dataclass(frozen=True, eq=False)
class TileMesh:
    """A tile with rings of faces around it; vertices and faces are in the order of the mesh."""

    vertices: Floats  # (n, 3) coordinates
    faces: Ints  # (m, 3) triangles
    numbers: Longs  # (n,) the numbers of the vertices in the input
    inside: Bools  # (n,) the mask of the vertices of the tile itself, which have all their faces here
    slots: Longs  # (n,)
    face_numbers: Longs  # (m,) the numbers of the faces in the input

    def write(self, column: Column, values: NDArray[Any]) -> None:
        """Writes the rows of (n, ...) values whose vertices are inside; these vertices have consecutive slots."""
        column.write(int(self.slots[self.inside].min()), values[self.inside][np.argsort(self.slots[self.inside])])

    @property
    def inside_faces(self) -> Bools:
        """Returns the (m,) mask of the faces that count for this tile: their vertex with the lowest number is inside."""
        return np.asarray(self.inside[self.faces.min(axis=1)])


def tile_with_rings(surface: Surface, first: int, last: int, rings: int, *, points: Column | None = None) -> TileMesh:
    """Returns the cells from `first` to before `last`, with `rings` rings of faces around them, at least one.

    Every vertex that is fewer than `rings` edges away from the tile has all its faces. `points` has the coordinates by slot; None
    takes the coordinates of the cells.
    """
    cells = surface.cells
    begin, end = cells.slots_of(first, last)
    outside, frontier, loaded = np.empty(0, np.int64), np.arange(first, last), np.zeros(len(cells.starts), np.bool_)
    faces, blocks = np.empty(0, FACE), []
    for _ in range(max(rings, 1)):
        new_cells = frontier[~loaded[frontier]]
        loaded[new_cells] = True
        faces = np.concatenate([faces, surface.faces_at(new_cells)])
        corners = np.ascontiguousarray(faces["corners"])
        reached = (corners >= begin) & (corners < end)
        reached[~reached] = np.isin(corners[~reached], outside)
        touching = np.asarray(reached.any(axis=1))
        blocks.append(faces[touching])
        new_outside = np.unique(corners[touching[:, None] & ~reached]).astype(np.int64)
        outside = np.union1d(outside, new_outside)
        frontier = np.unique(np.searchsorted(cells.starts, new_outside, "right") - 1)
        faces = faces[~touching]
    faces = np.concatenate(blocks)
    faces = faces[np.unique(faces["number"], return_index=True)[1]]
    part = Part(begin, end, outside)
    numbers = part.read_all(cells.numbers)
    order = np.argsort(numbers)
    row_of = np.empty(len(order), np.int32)
    row_of[order] = np.arange(len(order), dtype=np.int32)
    vertices = part.read_all(cells.points if points is None else points)[order]
    corners, inside = row_of[part.rows(faces["corners"])], order < end - begin
    return TileMesh(vertices, corners, numbers[order], inside, part.slots[order], faces["number"])


@dataclass(frozen=True)
class MeshTiles:
    """Tasks of the steps that move vertices; each can be repeated. A tile has the cells from `first` to before `last`."""

    surface: Surface
    with_normals: bool = False  # whether `finish` writes normals, too

    def box(self, first: int, last: int) -> tuple[Floats, Floats, bool, Floats]:
        """Returns the box of the tile's vertices with a proper face, whether some are on borders, and corners of some faces."""
        tile = tile_with_rings(self.surface, first, last, 1)
        proper = proper_faces(tile.faces)
        points = tile.vertices[mask_of(tile.faces[proper], len(tile.vertices)) & tile.inside]
        border = bool((border_vertices(tile.faces, len(tile.vertices)) & tile.inside).any())
        sampled = proper & tile.inside_faces & (tile.face_numbers % max(1, self.surface.faces // Whole.sampled) == 0)
        low, high = points.min(axis=0, initial=np.inf), points.max(axis=0, initial=-np.inf)
        return low, high, border, tile.vertices[tile.faces[sampled]]

    def farthest(self, place: Floats, whole: Whole, first: int, last: int) -> tuple[float, int, Floats]:
        """Finds the farthest vertex of a face, see `Whole.farthest`: scaled distance (-1: no face), number and coordinates."""
        tile = tile_with_rings(self.surface, first, last, 1)
        rows = np.flatnonzero(mask_of(tile.faces[proper_faces(tile.faces)], len(tile.vertices)) & tile.inside)
        if not len(rows):
            return -1.0, 0, place
        away, i = whole.farthest(tile.vertices[rows], place)
        return away, int(tile.numbers[rows[i]]), tile.vertices[rows[i]]

    def choose(self, values: Mapping[str, Any], is_open: bool) -> tuple[dict[str, Any], dict[str, Any]]:
        """As `plan.choose`, on patches of the mesh, or on all of a small mesh."""
        cells = self.surface.cells
        count, patches = len(cells.starts) - 1, max(1, _SAMPLE // (_PATCH * cells.cell))
        ranges = [(0, count)]
        if cells.count > _SAMPLE and count > patches * _PATCH:
            ranges = [(first, first + _PATCH) for first in np.linspace(0, count - _PATCH, patches).astype(int).tolist()]
        parts = [tile_with_rings(self.surface, first, last, 1) for first, last in ranges]
        starts = accumulate((len(part.vertices) for part in parts), initial=0)
        faces = np.concatenate([part.faces + np.int32(start) for part, start in zip(parts, starts, strict=False)])
        return choose(values, np.concatenate([part.vertices for part in parts]), faces, is_open=is_open)

    def move(self, step: PlannedStep, whole: Whole, first: int, last: int) -> None:
        tile = tile_with_rings(self.surface, first, last, rings_of(step))
        moved = apply(step, tile.vertices, tile.faces, whole)
        check_healthy(tile.vertices[tile.inside], moved[tile.inside], whole.diagonal, tile.numbers[tile.inside].astype(np.int32))
        tile.write(self.surface.moved, moved)

    @property
    def results(self) -> Results:
        """Returns the file of final coordinates and normals, sorted by number within each tile."""
        return Results(Column(self.surface.cells.folder / "final", "<f8", 6 if self.with_normals else 3))

    def finish(self, first: int, last: int) -> tuple[Floats, Floats]:
        """Writes the tile's final coordinates, and normals if wanted; returns the corners of the bounding box.

        The normal of a vertex of no face is NaN: the file's normal stays.
        """
        cells = self.surface.cells
        begin, end = cells.slots_of(first, last)
        points = cells.points.read(begin, end)
        if self.with_normals:
            tile = tile_with_rings(self.surface, first, last, 1)
            normals = vertex_normals_by_angle(tile.vertices, tile.faces)
            normals[~mask_of(tile.faces, len(normals))] = np.nan
            self.results.write(begin, tile.numbers[tile.inside], np.hstack([tile.vertices, normals])[tile.inside])
        else:
            self.results.write(begin, cells.numbers.read(begin, end), points)
        return points.min(axis=0), points.max(axis=0)


@dataclass(frozen=True)
class FilteringTiles:
    """The tasks of normal filtering; each task can be repeated."""

    surface: Surface
    filtering: Filtering
    whole: Whole  # the bounding box of the vertices of faces
    is_open: bool  # whether the mesh has borders

    def remember(self, first: int, last: int) -> None:
        """Stores the coordinates to which `unfold` may move vertices back."""
        begin, end = self.surface.cells.slots_of(first, last)
        self.surface.before.write(begin, self.surface.cells.points.read(begin, end))

    def relax(self, first: int, last: int) -> tuple[tuple[float, int], tuple[float, int]]:
        """Writes the two arrays of `relaxed_part` to `moved` and `state`; returns its sums of squares."""
        filtering = self.filtering
        tile = tile_with_rings(self.surface, first, last, denoising.rings_of_relaxation(filtering.relaxation))
        moved, across, squares = denoising.relaxed_part(
            tile.vertices,
            tile.faces,
            tile.inside,
            iterations=filtering.relaxation,
            direction=filtering.relaxation_direction,
            border=filtering.border,
            whole=self.whole,
            is_open=self.is_open,
        )
        tile.write(self.surface.moved, moved)
        tile.write(self.surface.state, across)
        return squares

    def keep(self, share: float, first: int, last: int) -> None:
        """Moves the vertices to the result of `relax`; border vertices keep only `share` of their move along the surface."""
        cells = self.surface.cells
        begin, end = cells.slots_of(first, last)
        moved, across = self.surface.moved.read(begin, end), self.surface.state.read(begin, end)
        kept = np.where(moved == across, moved, across + share * (moved - across))
        check_healthy(cells.points.read(begin, end), kept, self.whole.diagonal, cells.numbers.read(begin, end).astype(np.int32))
        self.surface.next_state.write(begin, kept)

    def begin(self, first: int, last: int) -> None:
        """Stores the normalised coordinates as the state."""
        start, mesh = self._normalised(first, last)
        self.surface.state.write(start, mesh.points)

    def measure(self, first: int, last: int) -> tuple[list[float], int]:
        """Returns the contribution of a tile to the mean distance of neighbouring face centres."""
        tile = tile_with_rings(self.surface, first, last, 3, points=self.surface.state)
        return denoising.distances_of_part(tile.vertices, tile.faces, tile.inside_faces)

    def round(self, distance: float, first: int, last: int) -> None:
        filtering = self.filtering
        rings = denoising.rings_of_round(filtering.settings, filtering.vertex_iterations)
        tile = tile_with_rings(self.surface, first, last, rings, points=self.surface.state)
        moved = denoising.round_of_part(
            tile.vertices,
            tile.faces,
            filtering.settings,
            distance=distance,
            vertex_iterations=filtering.vertex_iterations,
            vertex_update=filtering.vertex_update,
            border=filtering.border,
        )
        tile.write(self.surface.next_state, moved)

    def end(self, first: int, last: int) -> None:
        """Scales the state back to coordinates."""
        start, mesh = self._normalised(first, last)
        moved = mesh.restored(self.surface.state.read(start, start + len(mesh)))
        numbers = self.surface.cells.numbers.read(start, start + len(mesh))
        check_healthy(mesh.vertices, moved, self.whole.diagonal, numbers.astype(np.int32))
        self.surface.moved.write(start, moved)

    def _normalised(self, first: int, last: int) -> tuple[int, NormalisedMesh]:
        start, end = self.surface.cells.slots_of(first, last)
        return start, normalised_mesh(self.surface.cells.points.read(start, end), _NO_FACES, whole=self.whole)

    def unfold(self, share: float, first: int, last: int) -> tuple[int, int]:
        """Moves vertices at new folds back to a share of their move; counts the folds before the filter and before this task."""
        tile = tile_with_rings(self.surface, first, last, denoising.RINGS_OF_UNFOLDING)
        before, after = self.surface.before.gather(tile.slots), tile.vertices
        folded_before, folded_after = (folded_faces(vertices, tile.faces) for vertices in (before, after))
        tile.write(self.surface.moved, denoising.going_back(before, after, tile.faces, folded_after & ~folded_before, share))
        return int(folded_before[tile.inside_faces].sum()), int(folded_after[tile.inside_faces].sum())

    def causes_of_folds(self, first: int, last: int) -> tuple[int, int, int]:
        tile = tile_with_rings(self.surface, first, last, 1, points=self.surface.before)
        return denoising.causes_of_folds(tile.vertices, tile.faces, tile.inside)


def cut(
    mesh: MeshFile,
    folder: Path,
    tasks: Tasks,
    tile: int,
    *,
    steps: Sequence[PlannedStep],
    most: int | None,
    progress: Callable[[float], None],
) -> tuple[Surface, dict[str, Any]]:
    """Divides a mesh into cells; returns its files and sizes."""
    cloud = Cloud(mesh, folder)
    size = slice_rows(tile, mesh.row)
    count, low, high = tasks.run(cloud.survey, size)
    if count > np.iinfo(np.int32).max:
        raise FilterInputError(f"{count} vertices are more than the 2,147,483,647 that an index of 32 bits reaches")
    each, rings = map(max, zip(*map(cost_of, steps), strict=True))
    vertices = surface_vertices(tile, each, rings) if most is None else most
    chooses = any(step.filter == NORMALS and filtering_of(step.values) is None for step in steps)
    buckets = tasks.run(cloud.divide, count, folder, _BUCKET if chooses else vertices, size)
    progress(0.2)
    cells = Cells.of(buckets, folder, 1.0, tasks, part_of(progress, 0.2, 0.4))
    surface = Surface(cells, tuple(accumulate((bucket.count for bucket in buckets), initial=0)))
    surface = replace(surface, faces=tasks.run(surface.sort_in, partial(mesh.faces, size), size))
    progress(0.7)
    tasks.map(surface.order_faces, [(bucket,) for bucket in range(len(buckets))], part_of(progress, 0.7, 1.0))
    tasks.run(surface.remove_unordered)
    return surface, {"points": count, "faces": surface.faces, "low": low, "high": high, "points_per_tile": vertices}


def do_move(
    surface: Surface, step: PlannedStep, tiles: Ranges, tasks: Tasks, progress: Callable[[float], None]
) -> dict[str, Any]:
    """Does a step; returns the report of the filter."""
    work, values = MeshTiles(surface), step.values
    report: dict[str, Any] = {}
    whole, is_open, corners = _whole(work, tiles, tasks, part_of(progress, 0.0, 0.1))
    progress = part_of(progress, 0.1, 1.0)
    if not step.is_builtin and (place := whole.place_if_far(corners)) is not None:
        found = tasks.map(work.farthest, [(place, whole, *tile) for tile in tiles])
        _, number, coordinates = max(found, key=lambda vertex: (vertex[0], -vertex[1]))
        raise whole.far_vertex(number, coordinates)
    if step.filter == NORMALS and filtering_of(values) is None:
        chosen_values, report = tasks.run(work.choose, values, is_open)
        values = {**values, **chosen_values}
        progress = part_of(progress, 0.3, 1.0)
    filtering = filtering_of(values) if step.filter == NORMALS else None
    if filtering is None:
        if step.is_builtin:
            report = {"notes": (f"Smoothed {surface.cells.count} vertices",)}  # MeshLab's sentence
        tasks.map(work.move, [(step, whole, *tile) for tile in tiles], progress)
        tasks.run(surface.replace_column, surface.moved, surface.cells.points)
        return report
    report = {**filtering.parameters, **report}
    filters = FilteringTiles(surface, filtering, whole, is_open)
    tasks.map(filters.remember, tiles)
    if filtering.relaxation:
        squares = tasks.map(filters.relax, tiles, part_of(progress, 0.0, 0.2))
        sums = [(math.fsum(of_tile[k][0] for of_tile in squares), sum(of_tile[k][1] for of_tile in squares)) for k in (0, 1)]
        share = denoising.share_along(*(total / max(1, number) for total, number in sums))
        tasks.map(filters.keep, [(share, *tile) for tile in tiles])
        tasks.run(surface.replace_column, surface.next_state, surface.cells.points)
        progress = part_of(progress, 0.2, 1.0)
        if filtering.outer_iterations:
            filters = replace(filters, whole=_whole(work, tiles, tasks)[0])
    if filtering.outer_iterations:
        _do_rounds(filters, tiles, tasks, progress)
    share = denoising.HALF_WAY
    while True:
        folded_before, folded_after = np.sum(tasks.map(filters.unfold, [(share, *tile) for tile in tiles]), axis=0).tolist()
        if folded_after <= folded_before:
            break
        tasks.run(surface.replace_column, surface.moved, surface.cells.points)
        share = 0.0
    notes = report.get("notes", ())
    if folded_after:
        causes = np.sum(tasks.map(filters.causes_of_folds, tiles), axis=0).tolist()
        notes += denoising.notes_on_folds(folded_before, folded_after, *causes)
    return {**report, "folded_before": folded_before, "folded_after": folded_after, "notes": notes}


def _do_rounds(work: FilteringTiles, tiles: Ranges, tasks: Tasks, progress: Callable[[float], None]) -> None:
    surface, count = work.surface, work.filtering.outer_iterations
    tasks.map(work.begin, tiles)
    for done in range(count):
        distance = 0.0
        if denoising.needs_distance(work.filtering.settings):
            sums = tasks.map(work.measure, tiles)
            number = sum(n for _, n in sums)
            distance = math.fsum(part for parts, _ in sums for part in parts) / number if number else 0.0
        tasks.map(work.round, [(distance, *tile) for tile in tiles], part_of(progress, done / count, (done + 1) / count))
        tasks.run(surface.replace_column, surface.next_state, surface.state)
    tasks.map(work.end, tiles)
    tasks.run(surface.replace_column, surface.moved, surface.cells.points)


def _whole(
    work: MeshTiles, tiles: Ranges, tasks: Tasks, progress: Callable[[float], None] = ignore_progress
) -> tuple[Whole, bool, Floats]:
    """Returns the box of the vertices of faces (0 if none), whether the mesh has a border, and corners of some faces."""
    lows, highs, borders, corners = zip(*tasks.map(work.box, tiles, progress), strict=True)
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    if not np.isfinite(low).all():
        low = high = np.zeros(3)  # no vertex moves
    return Whole(low, high), any(borders), np.concatenate(corners)

"""A mesh by tiles: its vertices and faces in the files of cells, tiles with rings of faces, and steps that move its vertices.

The files are those of `Cells`, and the faces at the vertices of each cell, each face by the slots of its corners. A tile keeps
the order of the whole. Normal filtering goes round by round: after each all tiles see what the others made of their vertices.
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
from ..filters.inspection import folded_faces
from ..filters.mesh import Bools, Floats, Ints, Longs, NormalisedMesh, Whole, check_healthy, normalised_mesh
from ..filters.topology import border_vertices, proper_faces
from .cells import Cells, Column, Part, Ranges, Results, Stored
from .cloud import Cloud
from .plan import NORMALS, Filtering, PlannedStep, apply, chosen, cost_of, filtering_of, rings_of, slice_rows, surface_vertices
from .sources import MeshFile
from .workers import Tasks

_NO_FACES = np.empty((0, 3), np.int32)
#: vertices of the sample that settings are chosen on, and cells of each of its patches
_SAMPLE, _PATCH = 60_000, 4
#: a face: the slots of its corners, and its number
FACE = np.dtype([("corners", "<i4", 3), ("number", "<i8")])


@dataclass(frozen=True)
class Surface:
    """The files of a mesh."""

    cells: Cells  # of its vertices
    #: (b + 1,) the slot at which each bucket begins; the faces at its vertices are in a file of their own
    buckets: tuple[int, ...]

    slots = Stored("<i4")  # of each vertex, by its number
    moved = Stored("<f8", 3)  # new coordinates by slot
    before = Stored("<f8", 3)  # those before a step that may fold faces
    state = Stored("<f8", 3)  # what a filter keeps between its passes
    next_state = Stored("<f8", 3)  # that after a pass

    def _raw(self, bucket: int) -> Path:
        return self.cells.folder / f"corners-{bucket}"

    def _faces(self, bucket: int) -> Path:
        return self.cells.folder / f"faces-{bucket}"

    def _starts(self, bucket: int) -> Column:
        """The begin and end of the faces of each cell of a bucket in its file."""
        return Column(self.cells.folder / f"faces-{bucket}.starts", "<i8")

    def sort_in(self, slices: Callable[[], Iterable[NDArray[Any]]], size: int) -> int:
        """Give each face, of slices of (m, 3) numbers of vertices, to the buckets of its corners; how many faces there are.

        Of the vertices `size` may be in memory.
        """
        cells = self.cells
        self.slots.write(cells.count - 1, np.zeros(1))
        slots = np.memmap(self.slots.path, "<i4", "r+")
        for first in range(0, cells.count, size):
            last = min(first + size, cells.count)
            slots[cells.numbers.read(first, last)] = np.arange(first, last)
        starts, count = np.array(self.buckets), 0
        self.remove_unordered()  # of a process that was killed here
        for corners in slices():
            wrong = ((corners < 0) | (corners >= cells.count)).any(axis=1)
            if wrong.any():
                bad = int(wrong.argmax())
                raise FilterInputError(
                    f"face {count + bad} is {corners[bad].tolist()}, but the vertices are 0 to {cells.count - 1}: remove it"
                )
            faces = np.empty(len(corners), FACE)
            faces["corners"], faces["number"] = slots[corners], np.arange(count, count + len(corners))
            there = np.searchsorted(starts, faces["corners"], "right") - 1
            for bucket in np.unique(there).tolist():
                with self._raw(bucket).open("ab") as file:
                    file.write(faces[(there == bucket).any(axis=1)].tobytes())
            count += len(corners)
        return count

    def order_faces(self, bucket: int) -> None:
        """Put the faces of a bucket into the order of its cells; a face stands once with every cell that it touches."""
        raw = self._raw(bucket)
        faces = np.fromfile(raw, FACE) if raw.exists() else np.empty(0, FACE)
        starts = self.cells.starts
        first, last = np.searchsorted(starts, self.buckets[bucket : bucket + 2])
        cell = np.searchsorted(starts, faces["corners"], "right") - 1
        cell[(cell < first) | (cell >= last)] = -1
        cell = np.sort(cell, axis=1)
        cell[:, 1:][cell[:, 1:] == cell[:, :-1]] = -1  # each cell of a face once
        row, column = np.nonzero(cell >= 0)
        order = np.argsort(cell[row, column], kind="stable")
        self._faces(bucket).write_bytes(faces[row[order]].tobytes())
        counts = np.bincount(cell[row, column] - first, minlength=last - first)
        self._starts(bucket).write(0, np.append(0, np.cumsum(counts)))

    def remove_unordered(self) -> None:
        """Remove the faces as they were before `order_faces`."""
        for bucket in range(len(self.buckets) - 1):
            self._raw(bucket).unlink(missing_ok=True)

    def faces_at(self, cells: Longs) -> NDArray[Any]:
        """The faces at the vertices of some cells, given in ascending order; those at several cells stand there several times."""
        faces = [np.empty(0, FACE)]
        bucket_of = np.searchsorted(np.array(self.buckets), self.cells.starts[cells], "right") - 1
        for bucket in np.unique(bucket_of).tolist():
            starts = self._starts(bucket).read(0, len(self._starts(bucket)))
            own = cells[bucket_of == bucket] - np.searchsorted(self.cells.starts, self.buckets[bucket])
            for run in np.split(own, np.flatnonzero(np.diff(own) > 1) + 1):
                begin, end = int(starts[run[0]]), int(starts[run[-1] + 1])
                faces.append(np.fromfile(self._faces(bucket), FACE, end - begin, offset=begin * FACE.itemsize))
        return np.concatenate(faces)

    def turn(self, new: Column, old: Column) -> None:
        """Put new values in the place of the old ones."""
        with contextlib.suppress(FileNotFoundError):  # it was done before the process was killed
            new.path.replace(old.path)


@dataclass(frozen=True, eq=False)
class TileMesh:
    """A part of a mesh; vertices and faces in the order of the whole."""

    vertices: Floats  # (n, 3) coordinates
    faces: Ints  # (m, 3) triangles
    numbers: Longs  # (n,) of the vertices in the whole
    own: Bools  # (n,) which vertices are the tile's; those that a face uses have all their faces here
    slots: Longs  # (n,) where the vertices are stored

    def write(self, column: Column, values: NDArray[Any]) -> None:
        """Write of (n, ...) values those of the tile's own vertices, which have consecutive slots."""
        column.write(int(self.slots[self.own].min()), values[self.own][np.argsort(self.slots[self.own])])

    @property
    def own_faces(self) -> Bools:
        """(m,) which faces count with the tile: those whose first vertex is its own."""
        return np.asarray(self.own[self.faces.min(axis=1)])


def tile_with_rings(surface: Surface, first: int, last: int, rings: int, *, places: Column | None = None) -> TileMesh:
    """The cells from `first` to before `last`, with the faces that are at most so many rings away, at least one.

    Every vertex that is less than `rings` faces away from one of the tile has all its faces. The coordinates are those in
    `places`, by slot; None for those of the cells.
    """
    cells = surface.cells
    begin, end = cells.slots_of(first, last)
    outside, frontier, loaded = np.empty(0, np.int64), np.arange(first, last), np.zeros(len(cells.starts), np.bool_)
    faces, found = np.empty(0, FACE), []
    for _ in range(max(rings, 1)):
        new = frontier[~loaded[frontier]]
        loaded[new] = True
        faces = np.concatenate([faces, surface.faces_at(new)])
        corners = np.ascontiguousarray(faces["corners"])
        reached = (corners >= begin) & (corners < end)
        reached[~reached] = np.isin(corners[~reached], outside)
        touching = np.asarray(reached.any(axis=1))
        found.append(faces[touching])
        fresh = np.unique(corners[touching[:, None] & ~reached]).astype(np.int64)
        outside = np.union1d(outside, fresh)
        frontier = np.unique(np.searchsorted(cells.starts, fresh, "right") - 1)
        faces = faces[~touching]
    faces = np.concatenate(found)
    faces = faces[np.unique(faces["number"], return_index=True)[1]]
    part = Part(begin, end, outside)
    numbers = part.of_all(cells.numbers)
    order = np.argsort(numbers)
    place = np.empty(len(order), np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    vertices = part.of_all(cells.points if places is None else places)[order]
    return TileMesh(vertices, place[part.rows(faces["corners"])], numbers[order], order < end - begin, part.slots[order])


@dataclass(frozen=True)
class MeshTiles:
    """The tasks of moving the vertices of a mesh, each for the cells from `first` to before `last`; each may be done twice."""

    surface: Surface

    def box(self, first: int, last: int) -> tuple[Floats, Floats, bool]:
        """The box of the vertices that a face with three different corners uses; whether there is a border."""
        tile = tile_with_rings(self.surface, first, last, 1)
        used = np.zeros(len(tile.vertices), np.bool_)
        used[tile.faces[proper_faces(tile.faces)]] = True
        points = tile.vertices[used & tile.own]
        border = bool((border_vertices(tile.faces, len(used)) & tile.own).any())
        return points.min(axis=0, initial=np.inf), points.max(axis=0, initial=-np.inf), border

    def choose(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The parameters of normal filtering, those that are automatic chosen on patches of the mesh, or all of a small one."""
        cells = self.surface.cells
        count, patches = len(cells.starts) - 1, max(1, _SAMPLE // (_PATCH * cells.cell))
        ranges = [(0, count)]
        if cells.count > _SAMPLE and count > patches * _PATCH:
            ranges = [(first, first + _PATCH) for first in np.linspace(0, count - _PATCH, patches).astype(int).tolist()]
        parts = [tile_with_rings(self.surface, first, last, 1) for first, last in ranges]
        starts = accumulate((len(part.vertices) for part in parts), initial=0)
        faces = np.concatenate([part.faces + np.int32(start) for part, start in zip(parts, starts, strict=False)])
        return chosen(values, np.concatenate([part.vertices for part in parts]), faces)

    def move(self, step: PlannedStep, whole: Whole, first: int, last: int) -> None:
        """One step that looks at rings around each vertex."""
        tile = tile_with_rings(self.surface, first, last, rings_of(step))
        moved = apply(step, tile.vertices, tile.faces, whole)
        check_healthy(tile.vertices[tile.own], moved[tile.own], whole.diagonal, tile.numbers[tile.own].astype(np.int32))
        tile.write(self.surface.moved, moved)

    @property
    def results(self) -> Results:
        """The final coordinates, those of each tile in the rows of its slots."""
        return Results(Column(self.surface.cells.folder / "final", "<f8", 3))

    def finish(self, first: int, last: int) -> tuple[Floats, Floats]:
        """Write down the final coordinates by number; the corners of their box."""
        cells = self.surface.cells
        begin, end = cells.slots_of(first, last)
        points = cells.points.read(begin, end)
        self.results.write(begin, cells.numbers.read(begin, end), points)
        return points.min(axis=0), points.max(axis=0)


@dataclass(frozen=True)
class FilteringTiles:
    """The tasks of normal filtering: Taubin's steps, rounds, and folds of both taken back; each may be done twice."""

    surface: Surface
    filtering: Filtering
    whole: Whole  # the box of the vertices that faces use
    is_open: bool  # whether the mesh has borders

    def remember(self, first: int, last: int) -> None:
        """Write down the coordinates, to which vertices may go back."""
        begin, end = self.surface.cells.slots_of(first, last)
        self.surface.before.write(begin, self.surface.cells.points.read(begin, end))

    def relax(self, first: int, last: int) -> tuple[tuple[float, int], tuple[float, int]]:
        """Taubin's steps; the sums of `relaxed_part`."""
        filtering = self.filtering
        tile = tile_with_rings(self.surface, first, last, denoising.rings_of_relaxation(filtering.relaxation))
        moved, across, squares = denoising.relaxed_part(
            tile.vertices,
            tile.faces,
            tile.own,
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
        """Put the vertices where they are after these, the outline with that share of its way along the surface."""
        cells = self.surface.cells
        begin, end = cells.slots_of(first, last)
        moved, across = self.surface.moved.read(begin, end), self.surface.state.read(begin, end)
        kept = np.where(moved == across, moved, across + share * (moved - across))
        check_healthy(cells.points.read(begin, end), kept, self.whole.diagonal, cells.numbers.read(begin, end).astype(np.int32))
        self.surface.next_state.write(begin, kept)

    def begin(self, first: int, last: int) -> None:
        """Write down the normalised coordinates."""
        start, mesh = self._normalised(first, last)
        self.surface.state.write(start, mesh.points)

    def measure(self, first: int, last: int) -> tuple[list[float], int]:
        """The contribution of a tile to the mean distance of centres."""
        tile = tile_with_rings(self.surface, first, last, 3, places=self.surface.state)
        return denoising.distances_of_part(tile.vertices, tile.faces, tile.own_faces)

    def round(self, distance: float, first: int, last: int) -> None:
        """One round."""
        filtering = self.filtering
        rings = denoising.rings_of_round(filtering.settings, filtering.vertex_iterations)
        tile = tile_with_rings(self.surface, first, last, rings, places=self.surface.state)
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
        """Give the vertices their coordinates."""
        start, mesh = self._normalised(first, last)
        moved = mesh.restored(self.surface.state.read(start, start + len(mesh)))
        numbers = self.surface.cells.numbers.read(start, start + len(mesh))
        check_healthy(mesh.vertices, moved, self.whole.diagonal, numbers.astype(np.int32))
        self.surface.moved.write(start, moved)

    def _normalised(self, first: int, last: int) -> tuple[int, NormalisedMesh]:
        start, end = self.surface.cells.slots_of(first, last)
        return start, normalised_mesh(self.surface.cells.points.read(start, end), _NO_FACES, whole=self.whole)

    def unfold(self, share: float, first: int, last: int) -> int:
        """How many more faces are folded than before; writes down where the vertices are if some keep that share of their way."""
        tile = tile_with_rings(self.surface, first, last, denoising.RINGS_OF_UNFOLDING)
        before, after = self.surface.before.gather(tile.slots), tile.vertices
        folded, now = (folded_faces(vertices, tile.faces) for vertices in (before, after))
        tile.write(self.surface.moved, denoising.going_back(before, after, tile.faces, now & ~folded, share))
        return int(now[tile.own_faces].sum()) - int(folded[tile.own_faces].sum())


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
    """Cut a mesh into cells for some steps; the mesh, and its numbers."""
    cloud = Cloud(mesh, folder)
    size = slice_rows(tile, mesh.row)
    count, low, high = tasks.run(cloud.survey, size)
    if count > np.iinfo(np.int32).max:
        raise FilterInputError(f"{count} vertices are more than the 2,147,483,647 that an index of 32 bits reaches")
    each, rings = map(max, zip(*map(cost_of, steps), strict=True))
    vertices = surface_vertices(tile, each, rings) if most is None else most
    buckets = tasks.run(cloud.divide, count, folder, vertices, size)
    progress(0.2)
    cells = Cells.of(buckets, folder, 1.0, tasks, part_of(progress, 0.2, 0.4))
    surface = Surface(cells, tuple(accumulate((bucket.count for bucket in buckets), initial=0)))
    faces = tasks.run(surface.sort_in, partial(mesh.faces, size), size)
    progress(0.7)
    tasks.map(surface.order_faces, [(bucket,) for bucket in range(len(buckets))], part_of(progress, 0.7, 1.0))
    tasks.run(surface.remove_unordered)
    sizes = {"points": count, "faces": faces, "low": low.tolist(), "high": high.tolist(), "points_per_tile": vertices}
    return surface, sizes


def do_move(
    surface: Surface, step: PlannedStep, tiles: Ranges, tasks: Tasks, progress: Callable[[float], None]
) -> dict[str, Any]:
    """One step; what the filter reports."""
    work, values = MeshTiles(surface), step.values
    chosen_values: dict[str, Any] = {}
    if step.filter == NORMALS and filtering_of(values) is None:
        chosen_values = tasks.run(work.choose, values)
        values = {**values, **chosen_values}
        progress = part_of(progress, 0.3, 1.0)
    filtering = filtering_of(values) if step.filter == NORMALS else None
    if filtering is not None and not (filtering.relaxation or filtering.outer_iterations):
        return {**chosen_values, "notes": ("there is nothing to remove: the vertices stay where they are",)}
    whole, is_open = _whole(work, tiles, tasks, part_of(progress, 0.0, 0.1))
    progress = part_of(progress, 0.1, 1.0)
    if filtering is None:
        tasks.map(work.move, [(step, whole, *tile) for tile in tiles], progress)
        tasks.run(surface.turn, surface.moved, surface.cells.points)
        return {}
    filters = FilteringTiles(surface, filtering, whole, is_open)
    tasks.map(filters.remember, tiles)
    if filtering.relaxation:
        _relax(filters, tiles, tasks, part_of(progress, 0.0, 0.2))
        progress = part_of(progress, 0.2, 1.0)
        if filtering.outer_iterations:
            filters = replace(filters, whole=_whole(work, tiles, tasks)[0])
    if filtering.outer_iterations:
        _do_rounds(filters, tiles, tasks, progress)
    share = denoising.HALF_WAY
    while sum(tasks.map(filters.unfold, [(share, *tile) for tile in tiles])) > 0:
        tasks.run(surface.turn, surface.moved, surface.cells.points)
        share = 0.0
    return chosen_values


def _relax(work: FilteringTiles, tiles: Ranges, tasks: Tasks, progress: Callable[[float], None]) -> None:
    """Taubin's steps, after which the mesh has other coordinates."""
    squares = tasks.map(work.relax, tiles, progress)
    sums = [(math.fsum(one[k][0] for one in squares), sum(one[k][1] for one in squares)) for k in (0, 1)]
    share = denoising.share_along(*(total / max(1, number) for total, number in sums))
    tasks.map(work.keep, [(share, *tile) for tile in tiles])
    tasks.run(work.surface.turn, work.surface.next_state, work.surface.cells.points)


def _do_rounds(work: FilteringTiles, tiles: Ranges, tasks: Tasks, progress: Callable[[float], None]) -> None:
    """All rounds, after which the mesh has other coordinates."""
    surface, count = work.surface, work.filtering.outer_iterations
    tasks.map(work.begin, tiles)
    for done in range(count):
        distance = 0.0
        if denoising.needs_distance(work.filtering.settings):
            sums = tasks.map(work.measure, tiles)
            number = sum(n for _, n in sums)
            distance = math.fsum(part for parts, _ in sums for part in parts) / number if number else 0.0
        tasks.map(work.round, [(distance, *tile) for tile in tiles], part_of(progress, done / count, (done + 1) / count))
        tasks.run(surface.turn, surface.next_state, surface.state)
    tasks.map(work.end, tiles)
    tasks.run(surface.turn, surface.moved, surface.cells.points)


def _whole(
    work: MeshTiles, tiles: Ranges, tasks: Tasks, progress: Callable[[float], None] = ignore_progress
) -> tuple[Whole, bool]:
    """The box of the vertices that faces use, one place where no face has an area; whether the mesh has a border."""
    lows, highs, borders = zip(*tasks.map(work.box, tiles, progress), strict=True)
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    if not np.isfinite(low).all():
        low = high = np.zeros(3)  # nothing moves
    return Whole(low, high), any(borders)

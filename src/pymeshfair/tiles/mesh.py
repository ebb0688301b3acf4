"""A mesh by tiles: steps that move its vertices, and the result written by slices.

Normal filtering goes round by round: after each all tiles see what the others have made of their vertices.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, repeat
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FilterInputError
from ..files.errors import ContentsError
from ..files.ply import CORNERS
from ..filters import denoising
from ..filters.execution import ignore_progress, part_of
from ..filters.inspection import folded_faces
from ..filters.mesh import NormalisedMesh, Whole, check_healthy, normalised_mesh
from ..filters.topology import border_vertices, proper_faces
from .cells import Cells, Ranges
from .cloud import Cloud
from .columns import Part, in_order
from .division import Floats
from .memory import slice_rows, surface_vertices
from .plan import NORMALS, Filtering, Move, apply, chosen, filtering_of, rings_of
from .sources import PlyCloud, PlySlices, SlicedTable
from .surface import Surface, tile_with_rings
from .workers import Tasks

_NO_FACES = np.empty((0, 3), np.int32)


@dataclass(frozen=True)
class Rounds:
    """The tasks of the rounds; each may be done twice."""

    surface: Surface  # the mesh
    filtering: Filtering  # the step
    whole: Whole  # the box of the vertices that faces use

    def begin(self, first: int, last: int) -> None:
        """Write down the normalised coordinates of some cells."""
        start, mesh = self._normalised(first, last)
        self.surface.state.write(start, mesh.points)

    def measure(self, first: int, last: int) -> tuple[list[float], int]:
        """The contribution of some cells to the mean distance of centres: each face counts with its first vertex."""
        tile = tile_with_rings(self.surface, first, last, 3, places=self.surface.state)
        return denoising.distances_of_part(tile.vertices, tile.faces, tile.own[tile.faces.min(axis=1)])

    def round(self, distance: float, first: int, last: int) -> None:
        """One round on the vertices of some cells."""
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
        self.surface.next_state.write(self.surface.cells.slots_of(first, last)[0], tile.own_by_slot(moved))

    def end(self, first: int, last: int) -> None:
        """Give some cells their coordinates."""
        start, mesh = self._normalised(first, last)
        moved = mesh.restored(self.surface.state.read(start, start + len(mesh)))
        numbers = self.surface.cells.numbers.read(start, start + len(mesh))
        check_healthy(mesh.vertices, moved, self.whole.diagonal, numbers.astype(np.int32))
        self.surface.moved.write(start, moved)

    def _normalised(self, first: int, last: int) -> tuple[int, NormalisedMesh]:
        start, end = self.surface.cells.slots_of(first, last)
        return start, normalised_mesh(self.surface.cells.points.read(start, end), _NO_FACES, whole=self.whole)

    def do(self, tiles: Ranges, tasks: Tasks, progress: Callable[[float], None]) -> None:
        """All rounds, after which the mesh has other coordinates."""
        surface, count = self.surface, self.filtering.outer_iterations
        for column in (surface.state, surface.moved):
            tasks.run(column.create, surface.cells.count)
        tasks.map(self.begin, tiles)
        for done in range(count):
            distance = 0.0
            if denoising.needs_distance(self.filtering.settings):
                sums = tasks.map(self.measure, tiles)
                number = sum(n for _, n in sums)
                distance = math.fsum(part for parts, _ in sums for part in parts) / number if number else 0.0
            tasks.run(surface.next_state.create, surface.cells.count)
            part = lambda share, done=done: progress((done + share) / count)  # noqa: E731
            tasks.map(self.round, [(distance, *tile) for tile in tiles], part)
            tasks.run(surface.turn, surface.next_state, surface.state)
        tasks.map(self.end, tiles)
        tasks.run(surface.turn, surface.moved, surface.cells.points)


@dataclass(frozen=True)
class Relaxation:
    """The tasks of Taubin's steps before normal filtering; each may be done twice."""

    surface: Surface  # the mesh
    filtering: Filtering  # says how many, and where they go
    whole: Whole  # the box of the vertices that faces use
    is_open: bool  # whether the mesh has borders

    def step(self, first: int, last: int) -> tuple[tuple[float, int], tuple[float, int]]:
        """The steps on the vertices of some cells; of `RelaxedPart` the squares."""
        filtering = self.filtering
        tile = tile_with_rings(self.surface, first, last, denoising.rings_of_relaxation(filtering.relaxation))
        part = denoising.RelaxedPart.of(
            tile.vertices,
            tile.faces,
            tile.own,
            iterations=filtering.relaxation,
            direction=filtering.relaxation_direction,
            border=filtering.border,
            whole=self.whole,
            is_open=self.is_open,
        )
        begin = self.surface.cells.slots_of(first, last)[0]
        for name in ("moved", "across", "outline"):
            getattr(self.surface, name).write(begin, tile.own_by_slot(getattr(part, name)))
        return part.squares

    def keep(self, share: float, first: int, last: int) -> None:
        """Put the vertices where they are, the outline with that share of its way along."""
        begin, end = self.surface.cells.slots_of(first, last)
        moved, across = self.surface.moved.read(begin, end), self.surface.across.read(begin, end)
        outline = self.surface.outline.read(begin, end) > 0
        kept = np.where(outline[:, None], across + share * (moved - across), moved)
        numbers = self.surface.cells.numbers.read(begin, end)
        check_healthy(self.surface.cells.points.read(begin, end), kept, self.whole.diagonal, numbers.astype(np.int32))
        self.surface.next_state.write(begin, kept)

    def do(self, tiles: Ranges, tasks: Tasks, progress: Callable[[float], None]) -> None:
        """All of them, after which the mesh has other coordinates."""
        count = self.surface.cells.count
        for column in (self.surface.moved, self.surface.across, self.surface.outline, self.surface.next_state):
            tasks.run(column.create, count)
        squares = tasks.map(self.step, tiles, progress)
        sums = [(math.fsum(one[k][0] for one in squares), sum(one[k][1] for one in squares)) for k in (0, 1)]
        share = denoising.share_along(*(total / max(1, number) for total, number in sums))
        tasks.map(self.keep, [(share, *tile) for tile in tiles])
        tasks.run(self.surface.turn, self.surface.next_state, self.surface.cells.points)
        tasks.run(self.forget)

    def forget(self) -> None:
        """Remove the files that nothing needs any more."""
        for column in (self.surface.across, self.surface.outline):
            column.path.unlink(missing_ok=True)


@dataclass(frozen=True)
class Unfolding:
    """The tasks of taking back the folds of the steps between, see `unfolded`; each may be done twice."""

    surface: Surface  # the mesh

    def begin(self, first: int, last: int) -> None:
        """Write down the coordinates of some cells, to which they may go back."""
        begin, end = self.surface.cells.slots_of(first, last)
        self.surface.before.write(begin, self.surface.cells.points.read(begin, end))

    def look(self, share: float, first: int, last: int) -> int:
        """Of faces that count with some cells how many more are folded than before.

        Writes down where the vertices are if some go back and keep that share of their way.
        """
        tile = tile_with_rings(self.surface, first, last, denoising.RINGS_OF_UNFOLDING)
        before, after = self.surface.before.gather(tile.slots), tile.vertices
        folded, now = (folded_faces(vertices, tile.faces) for vertices in (before, after))
        back = denoising.going_back(before, after, tile.faces, now & ~folded, share)
        self.surface.moved.write(self.surface.cells.slots_of(first, last)[0], tile.own_by_slot(back))
        own = tile.own[tile.faces.min(axis=1)]
        return int(now[own].sum()) - int(folded[own].sum())

    def do(self, tiles: Ranges, tasks: Tasks) -> None:
        """Take vertices back while more faces are folded than before."""
        for share in chain([denoising.HALF_WAY], repeat(0.0)):
            tasks.run(self.surface.moved.create, self.surface.cells.count)
            if sum(tasks.map(self.look, [(share, *tile) for tile in tiles])) <= 0:
                return
            tasks.run(self.surface.turn, self.surface.moved, self.surface.cells.points)


#: vertices of the sample that settings are chosen on, and cells of each of its patches
_SAMPLE, _PATCH = 60_000, 4


def _lists_of_corners(table: SlicedTable) -> list[str]:
    return [p.name for p in table.element.properties if p.name in CORNERS and p.count_type]


class MeshFile(PlySlices):
    """A binary PLY file of triangles."""

    def check(self) -> None:
        """Refuse what is no mesh of triangles."""
        self.vertices  # noqa: B018 - is checked
        table = self.tables.get("face")
        if table is None or not table.element.count or not _lists_of_corners(table):
            raise ContentsError("it has no faces; by tiles, vertices are moved on meshes of triangles")
        corners = table.dtype[_lists_of_corners(table)[0]].shape[0]
        if corners != 3:
            raise ContentsError(f"its first face has {corners} corners; by tiles, all faces must be triangles")
        others = [e for e in self.header.elements if e.name not in ("vertex", "face") and e.count]
        if others:
            raise ContentsError(f"it has {others[0].count:,} of {others[0].name!r}; by tiles a mesh has vertices and faces alone")

    def faces(self, size: int) -> Iterator[NDArray[Any]]:
        """(m, 3) numbers of vertices, so many faces at a time."""
        table = self.tables["face"]
        name = _lists_of_corners(table)[0]
        for rows in table.slices(size):
            yield rows[name].astype(np.int64)

    def write(self, target: Path, parts: tuple[Part, ...], size: int) -> None:
        """Write the mesh with other coordinates, which are then numbers of double precision; all else as it was."""
        properties = self.vertices.element.properties
        other = tuple(replace(p, type="double") if p.name in "xyz" else p for p in properties)
        elements = [replace(e, properties=other) if e.name == "vertex" else e for e in self.header.elements]
        vertices = (
            {p.name: places[:, "xyz".index(p.name)] if p.name in "xyz" else rows[p.name] for p in properties}
            for rows, places in zip(self.vertices.slices(size), in_order(parts, len(self), size), strict=True)
        )
        self.rewrite(target, elements, vertices, size)


@dataclass(frozen=True)
class MeshTiles:
    """The tasks of moving the vertices of a mesh; each may be done twice."""

    surface: Surface

    def box(self, first: int, last: int) -> tuple[Floats, Floats, bool]:
        """The box of the vertices of some cells that a face with three different corners uses; whether there is a border."""
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
        starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
        faces = np.concatenate([part.faces + np.int32(start) for part, start in zip(parts, starts, strict=False)])
        return chosen(values, np.concatenate([part.vertices for part in parts]), faces)

    def move(self, move: Move, whole: Whole, first: int, last: int) -> None:
        """One step on the vertices of some cells."""
        tile = tile_with_rings(self.surface, first, last, rings_of(move.filter, move.values))
        moved = apply(move.filter, move.values, tile, whole)
        check_healthy(tile.vertices[tile.own], moved[tile.own], whole.diagonal, tile.numbers[tile.own].astype(np.int32))
        self.surface.moved.write(self.surface.cells.slots_of(first, last)[0], tile.own_by_slot(moved))

    def part(self, first: int) -> Part:
        """The final coordinates of the tile that begins with a cell."""
        return Part(self.surface.cells.folder / f"final-{first}", "<f8", 3)

    def finish(self, first: int, last: int) -> tuple[Floats, Floats]:
        """Write down the final coordinates of some cells by number; the corners of their box."""
        cells = self.surface.cells
        begin, end = cells.slots_of(first, last)
        points = cells.points.read(begin, end)
        self.part(first).write(cells.numbers.read(begin, end), points)
        return points.min(axis=0), points.max(axis=0)


def cut(
    mesh: MeshFile,
    folder: Path,
    tasks: Tasks,
    tile: int,
    *,
    costs: list[tuple[int, int]],
    most: int | None,
    progress: Callable[[float], None],
) -> tuple[Surface, dict[str, Any]]:
    """Cut a mesh into cells, for steps of these costs (see `pymeshfair.tiles.plan.cost_of`); the mesh, and its numbers."""
    cloud = Cloud(PlyCloud(mesh.path), folder)
    size = slice_rows(tile, mesh.vertices.dtype.itemsize)
    count, low, high = tasks.run(cloud.survey, size)
    if count > np.iinfo(np.int32).max:
        raise FilterInputError(f"{count} vertices are more than the 2,147,483,647 that an index of 32 bits reaches")
    each, rings = max(cost[0] for cost in costs), max(cost[1] for cost in costs)
    vertices = surface_vertices(tile, each, rings) if most is None else most
    buckets = tasks.run(cloud.divide, count, folder, vertices, size)
    progress(0.2)
    cells = tasks.run(Cells.make, folder, count, 1.0)
    starts = np.cumsum([0, *(bucket.count for bucket in buckets)]).tolist()
    surface = Surface(cells, tuple(starts))
    tasks.run(surface.slots.create, count)
    filled = tasks.map(surface.fill, list(zip(buckets, starts, strict=False)), part_of(progress, 0.2, 0.4))
    tasks.run(cells.index, filled, buckets)
    faces = tasks.run(surface.sort_in, partial(mesh.faces, size))
    progress(0.7)
    tasks.map(surface.order_faces, [(bucket,) for bucket in range(len(buckets))], part_of(progress, 0.7, 1.0))
    tasks.run(surface.remove_unordered)
    sizes = {"points": count, "faces": faces, "low": low.tolist(), "high": high.tolist(), "points_per_tile": vertices}
    return surface, sizes


def do_move(surface: Surface, move: Move, tiles: Ranges, tasks: Tasks, progress: Callable[[float], None]) -> dict[str, Any]:
    """One step; what the filter reports."""
    work, values = MeshTiles(surface), move.values
    chosen_values: dict[str, Any] = {}
    if move.filter == NORMALS and filtering_of(values) is None:
        chosen_values = tasks.run(work.choose, values)
        values = {**values, **chosen_values}
    rest = part_of(progress, 0.3 if chosen_values else 0.0, 1.0)
    whole, is_open = _whole(work, tiles, tasks, part_of(rest, 0.0, 0.1))
    rest = part_of(rest, 0.1, 1.0)
    filtering = filtering_of(values) if move.filter == NORMALS else None
    if filtering is None:
        tasks.run(surface.moved.create, surface.cells.count)
        tasks.map(work.move, [(move, whole, *tile) for tile in tiles], rest)
        tasks.run(surface.turn, surface.moved, surface.cells.points)
        return chosen_values
    if not (filtering.relaxation or filtering.outer_iterations):
        return {**chosen_values, "notes": ("there is nothing to remove: the vertices stay where they are",)}
    unfolding = Unfolding(surface)
    tasks.run(surface.before.create, surface.cells.count)
    tasks.map(unfolding.begin, tiles)
    if filtering.relaxation:
        Relaxation(surface, filtering, whole, is_open).do(tiles, tasks, part_of(rest, 0.0, 0.2))
        rest = part_of(rest, 0.2, 1.0)
    if filtering.outer_iterations:
        if filtering.relaxation:
            whole = _whole(work, tiles, tasks)[0]
        Rounds(surface, filtering, whole).do(tiles, tasks, rest)
    unfolding.do(tiles, tasks)
    return chosen_values


def _whole(
    work: MeshTiles, tiles: Ranges, tasks: Tasks, progress: Callable[[float], None] = ignore_progress
) -> tuple[Whole, bool]:
    """The box of the vertices that faces use, one place where no face has an area; whether the mesh has a border."""
    boxes = tasks.map(work.box, tiles, progress)
    low, high = box_around([(low, high) for low, high, _ in boxes])
    if not np.isfinite(low).all():
        low = high = np.zeros(3)  # nothing moves
    return Whole(low, high), any(is_open for _, _, is_open in boxes)


def box_around(boxes: list[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    """The corners of the box around some boxes."""
    return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)

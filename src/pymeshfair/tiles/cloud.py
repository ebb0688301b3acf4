"""A cloud by tiles: a step selects points and may delete them, or gives them normals; the result is written by slices.

Of coincident points, and of those in a cell of a grid, all but the first go. For LoOP neighbours are sought in the tile and in
the cells around it, and then compared with theirs. `strays` has the third selection, `point_normals` the normals.
"""

import math
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FilterInputError
from ..files.polygons import numbered
from ..filters import outliers
from ..filters.execution import part_of
from ..filters.inspection.surface_measures import box_diagonal
from ..filters.neighbours import Nearest, tree_scale
from .cells import Cells, Ranges
from .columns import Column, Part, Stored, in_order
from .division import Bucket, Floats, Longs, divide
from .memory import cloud_points, points_with_normals, slice_rows
from .neighbours import PointTiles, TilePoints
from .plan import DUPLICATES, LOOP, POINT_NORMALS, STRAYS, SURPLUS, CloudStep
from .point_normals import NormalTiles
from .sources import Source
from .strays import StrayTiles
from .workers import Tasks


def coincident(buckets: Sequence[Bucket], tasks: Tasks, progress: Callable[[float], None]) -> tuple[Part, ...]:
    """Of each bucket which points are at the place of one with a smaller number; see `mark_later`."""
    groups = [tuple(group) for _, group in groupby(buckets, lambda bucket: bucket.whole or bucket.path)]
    tasks.map(mark_later, [(group,) for group in groups], progress)
    return tuple(_part(bucket) for bucket in buckets)


def mark_later(buckets: Sequence[Bucket]) -> None:
    """Write down which points are at the place of one before, for buckets that no others share a place with."""
    places = np.empty((0, 3))
    for bucket in buckets:
        here, numbers = bucket.read()
        count, together = len(places), np.concatenate([places, here])
        first, _ = numbered(together)
        later = np.ones(len(here), np.uint8)
        later[first[count:] - count] = 0
        _part(bucket).write(numbers, later)
        places = together[first]


def _part(bucket: Bucket) -> Part:
    return Part(bucket.path.with_name(f"{bucket.path.name}-later"), "u1")


class OutlierTiles(PointTiles):
    """The tasks of LoOP; the results are the factors."""

    result = "<f8", 1

    distances = Stored("<f8")  # the standard ones by slot, in the unit of trees

    def do(self, tasks: Tasks, tiles: Ranges, size: int, progress: Callable[[float], None]) -> None:
        tasks.run(self.distances.create, self.cells.count)
        tasks.map(self.find, tiles, part_of(progress, 0.0, 0.85))
        tasks.map(self.finish, [(first,) for first, _ in tiles], part_of(progress, 0.85, 1.0))

    def find(self, first: int, last: int) -> None:
        """The standard distances of the points in the cells from `first` to before `last`; the factors of those far inside."""
        count = int(self.cells.starts[last] - self.cells.starts[first])
        distances = np.empty(count)
        asking = [np.empty(0, np.intp)]
        asked_slots = [np.empty((0, self.k), np.int64)]

        def inside(rows: slice, squared: Floats) -> None:
            distances[rows] = outliers.standard_distances(squared)

        def around(tile: TilePoints, rows: NDArray[np.intp], nearest: Nearest) -> None:
            distances[rows] = outliers.standard_distances(nearest.squared)
            asking.append(rows)
            asked_slots.append(nearest.slots)

        tile = self.search(first, last, inside, around)
        asks = np.concatenate(asking)
        factors = np.full(count, np.nan)
        if len(asks) < count:
            outliers.compare(distances, tile.nearest, 0, count, factors)
            factors[asks] = np.nan
        self.distances.write(tile.begin, tile.by_slot(distances))
        self.part(first).write(tile.numbers[tile.index], factors)
        np.savez(self.aside(first), rows=tile.index[asks], own=distances[asks], slots=np.concatenate(asked_slots))

    def finish(self, first: int) -> None:
        """The factors of those points of a tile that had asked around; every tile must have been through `find`."""
        with np.load(self.aside(first)) as asked:
            rows, own, slots = asked["rows"], asked["own"], asked["slots"]
        if len(rows):
            self.part(first).replace(rows, outliers.compare_rows(own, self.distances.gather(slots)))


@dataclass(frozen=True)
class Cloud:
    """The points of a file that are left."""

    source: Source
    folder: Path  # for the files of the work
    kept: Column | None = None  # of each of its points whether it is left, None if all are

    scalars = Stored("<f8")  # the probability of each point of the file in the last stage that it was in
    normals = Stored("<f8", 3)  # the normal of each point of the file in the last stage that gave it one

    def left(self, first: int, last: int) -> NDArray[np.bool_]:
        """Which of some points of the file are left."""
        return np.ones(last - first, np.bool_) if self.kept is None else self.kept.read(first, last) > 0

    def slices(self, size: int) -> Iterator[tuple[Floats, Longs]]:
        """(m, 3) coordinates and (m,) numbers of the points that are left, counted without the others."""
        first = read = 0
        for places in self.source.points(size):
            start, read = read, read + len(places)
            places = places[self.left(start, read)]
            yield np.ascontiguousarray(places), np.arange(first, first + len(places))
            first += len(places)

    def survey(self, size: int) -> tuple[int, Floats, Floats]:
        """The number of points that are left, and the corners of their box; refuses coordinates that are not finite."""
        count, low, high = 0, np.full(3, np.inf), np.full(3, -np.inf)
        for places, numbers in self.slices(size):
            if not np.isfinite(places).all():
                bad = int(np.argmax(~np.isfinite(places).all(axis=1)))
                raise FilterInputError(
                    f"point {numbers[bad]} is {places[bad].tolist()}, which is not finite: remove such points first"
                )
            count += len(places)
            if len(places):
                low, high = np.minimum(low, places.min(axis=0)), np.maximum(high, places.max(axis=0))
        return count, low, high

    def divide(self, count: int, folder: Path, most: int, size: int, grid: float | None = None) -> list[Bucket]:
        """The points in buckets, see `pymeshfair.tiles.division.divide`; with a `grid` their cells in one of such cubes."""

        def slices() -> Iterator[tuple[Floats, Longs]]:
            for places, numbers in self.slices(size):
                yield places if grid is None else outliers.grid_cells(places, grid), numbers

        return divide(slices, count, folder, most=most)

    def put_in_order(self, results: Column, parts: Sequence[Part], count: int, size: int) -> None:
        """Write what was found of the points that are left, by tiles, in their order."""
        results.path.unlink(missing_ok=True)
        for block in in_order(parts, count, size):
            results.append(block)

    def with_results(self, results: Column, size: int) -> Iterator[tuple[int, NDArray[np.bool_], NDArray[Any]]]:
        """Of the points of the file, `size` at a time: the first, which are left, and what was found of those, in their order."""
        total, done = len(self.source), 0
        for first in range(0, total, size):
            left = self.left(first, min(first + size, total))
            count = int(left.sum())
            yield first, left, results.read(done, done + count)
            done += count

    def update(self, column: Column, first: int, left: NDArray[np.bool_], values: NDArray[Any]) -> None:
        """Give the points of the file from one on that are left other values in a column, which is made if need be."""
        if not column.path.exists():
            column.create(len(self.source))
        whole = column.read(first, first + len(left))
        whole[left] = values
        column.write(first, whole)

    def give_normals(self, parts: tuple[Part, ...], count: int, size: int) -> None:
        """Give the points that are left the normals of the tiles."""
        results = Column(self.folder / "found", "<f8", 3)
        self.put_in_order(results, parts, count, size)
        for first, left, values in self.with_results(results, size):
            self.update(self.normals, first, left, values)
        results.path.unlink()


@dataclass(frozen=True)
class Judgement:
    """The end of a stage, as tasks: what was found in the order of the points, and who is selected."""

    cloud: Cloud  # the points that are left
    parts: tuple[Part, ...]  # of each tile, the factors of LoOP, or which points are stray
    count: int  # the points
    selection: CloudStep  # the step
    target: Column  # the column that marks the points that remain

    @property
    def results(self) -> Column:
        """The result for each point that is left, in their order."""
        return Column(self.cloud.folder / "found", self.parts[0].dtype)

    def gather(self, size: int) -> float:
        """Put it in order; the spread of factors, 0 of stray points."""
        self.cloud.put_in_order(self.results, self.parts, self.count, size)
        if self.selection.filter != LOOP:
            return 0.0
        return outliers.spread_of(lambda: self.results.slices(outliers.SPREAD_BLOCK), self.selection.values["extent"])

    def select(self, spread: float, size: int) -> dict[str, Any]:
        """Write down what is left, and probabilities if there are any; what the filter reports."""
        probable = self.selection.filter == LOOP
        self.target.create(len(self.cloud.source))
        selected, largest, sums = 0, 0.0, []
        for first, left, results in self.cloud.with_results(self.results, size):
            goes = results
            if probable:
                probabilities = outliers.probabilities_of(results, spread)
                self.cloud.update(self.cloud.scalars, first, left, probabilities)
                goes = probabilities > self.selection.values["threshold"]
                largest = max(largest, float(probabilities.max(initial=0.0)))
                sums.append(float(probabilities.sum()))
            if self.selection.deletes:
                left[left] = goes == 0
            self.target.write(first, left.astype(np.uint8))
            selected += int(np.count_nonzero(goes))
        reported = {"largest_probability": largest, "mean_probability": math.fsum(sums) / self.count} if probable else {}
        return {("removed_vertices" if self.selection.filter == DUPLICATES else "selected_vertices"): selected} | reported


def do_step(
    cloud: Cloud,
    step: CloudStep,
    tasks: Tasks,
    tile: int,
    *,
    progress: Callable[[float], None],
    most: int | None = None,
) -> tuple[Cloud, dict[str, Any], dict[str, Any]]:
    """One stage with tiles of at most `tile` bytes: what is left, the filter's report, the numbers of the cloud and its tiles.

    Raises:
        FilterInputError: there are too few points, or nothing is left.
    """
    size = slice_rows(tile, cloud.source.row)
    count, low, high = tasks.run(cloud.survey, size)
    if step.neighbors >= count:
        raise FilterInputError(f"{step.neighbors} neighbours need a cloud of at least {step.neighbors + 1} points, got {count}")
    progress(0.02)
    folder = cloud.folder / f"step-{step.step}"
    folder.mkdir(exist_ok=True)
    fitting = points_with_normals if step.filter == POINT_NORMALS else cloud_points
    points = fitting(tile, step.neighbors) if most is None else most
    grid = None
    if step.filter == SURPLUS:
        grid = step.values["side"].resolve(diagonal=box_diagonal(np.stack([low, high])), mean_edge=lambda: 0.0)
    alike = step.filter in (DUPLICATES, SURPLUS)
    buckets = tasks.run(cloud.divide, count, folder, points, size, grid)
    progress(0.1)
    if alike:
        parts, tiles = coincident(buckets, tasks, part_of(progress, 0.1, 0.9)), len(buckets)
    else:
        cells = tasks.run(Cells.make, folder, count, tree_scale(float(max(high.max(), -low.min()))))
        starts = np.cumsum([0, *(bucket.count for bucket in buckets)]).tolist()
        filled = tasks.map(cells.fill, list(zip(buckets, starts, strict=False)), part_of(progress, 0.1, 0.2))
        tasks.run(cells.index, filled, buckets)
        ranges = tasks.run(cells.tiles, points)
        kinds: dict[str, type[PointTiles]] = {LOOP: OutlierTiles, POINT_NORMALS: NormalTiles, STRAYS: StrayTiles}
        work = kinds[step.filter](cells, step.values, step.neighbors, points)
        work.do(tasks, ranges, size, part_of(progress, 0.2, 0.9))
        parts, tiles = tuple(work.part(first) for first, _ in ranges), len(ranges)
    sizes = {"points": count, "low": low.tolist(), "high": high.tolist(), "tiles": tiles, "points_per_tile": points}
    if step.filter == POINT_NORMALS:
        tasks.run(cloud.give_normals, parts, count, size)
        shutil.rmtree(folder, ignore_errors=True)
        progress(1.0)
        return cloud, {}, sizes
    judgement = Judgement(cloud, parts, count, step, Column(cloud.folder / f"kept-{step.step}", "u1"))
    spread = tasks.run(judgement.gather, size)
    shutil.rmtree(folder, ignore_errors=True)
    values = tasks.run(judgement.select, spread, size)
    judgement.results.path.unlink(missing_ok=True)
    if step.deletes and values.get("selected_vertices") == count:
        raise FilterInputError(f"all {count} points were selected, so that nothing is left of the cloud")
    progress(1.0)
    return replace(cloud, kept=judgement.target), values, sizes


def write_cloud(cloud: Cloud, target: Path, size: int) -> int:
    """Write what is left, as it was read, with the probabilities and the normals if there are any; how many points that are."""
    total = len(cloud.source)
    slices = [(first, min(first + size, total)) for first in range(0, total, size)]
    names = cloud.source.names
    additions = (("scalars", cloud.scalars), ("normals", cloud.normals))
    columns = [(names[name], column) for name, column in additions if column.path.exists()]
    count = sum(int(np.count_nonzero(cloud.left(*rows))) for rows in slices)
    marks = (
        (cloud.left(*rows), {n: v for own, c in columns for n, v in zip(own, np.atleast_2d(c.read(*rows).T), strict=True)})
        for rows in slices
    )
    cloud.source.write(target, count, marks, size, added=tuple(name for own, _ in columns for name in own))
    return count

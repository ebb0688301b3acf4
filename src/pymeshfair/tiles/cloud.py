"""A cloud by tiles: a step selects points and may delete them, or gives them normals; the result is written by slices.

Of coincident points, and of those in a cell of a grid, all but the first go. For LoOP neighbours are sought in the tile and in
the cells around it, and then compared with theirs. `neighbours` has the other steps.
"""

import math
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, groupby, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FilterInputError
from ..files.polygons import numbered
from ..filters import outliers
from ..filters.execution import part_of
from ..filters.inspection.surface_measures import box_diagonal
from ..filters.mesh import Bools, Floats, Longs
from ..filters.neighbours import tree_scale
from .cells import Bucket, Cells, Column, Ranges, Results, Stored, divide
from .neighbours import NormalTiles, PointTiles, StrayTiles, TilePoints
from .plan import DUPLICATES, LOOP, POINT_NORMALS, STRAYS, SURPLUS, PlannedStep, cloud_points, slice_rows
from .sources import Source
from .workers import Tasks


def mark_later(results: Results, buckets: Sequence[tuple[int, Bucket]]) -> None:
    """Write down which points are at the place of one before, for buckets, each with its row, that share no place with others."""
    places = np.empty((0, 3))
    for first, bucket in buckets:
        here, numbers = bucket.read()
        count, together = len(places), np.concatenate([places, here])
        firsts, _ = numbered(together)
        later = np.ones(len(here), np.uint8)
        later[firsts[count:] - count] = 0
        results.write(first, numbers, later)
        places = together[firsts]


class OutlierTiles(PointTiles):
    """The tasks of LoOP; the results are the factors."""

    result = "<f8", 1

    distances = Stored("<f8")  # the standard ones by slot, in the unit of trees

    def do(self, tasks: Tasks, tiles: Ranges, size: int, progress: Callable[[float], None]) -> None:
        tasks.map(self.find, tiles, part_of(progress, 0.0, 0.85))
        tasks.map(self.finish, tiles, part_of(progress, 0.85, 1.0))

    def find(self, first: int, last: int) -> None:
        """The standard distances of the points in the cells from `first` to before `last`; the factors of those far inside."""
        tile = TilePoints.of(self.cells, first, last, self.k)
        asking, asked = [np.empty(0, np.intp)], [np.empty((0, self.k), np.int64)]
        for some, nearest in tile.ask_around(self.most):
            asking.append(some)
            asked.append(nearest.slots)
        rows, factors = np.concatenate(asking), np.zeros(len(tile.slots))
        if len(rows) < len(factors):
            factors = outliers.compare_rows(tile.distances, tile.distances.take(tile.nearest))
        self.distances.write(tile.begin, tile.by_slot(tile.distances))
        self.results.write(tile.begin, tile.numbers, factors)
        np.savez(self.aside(first), numbers=tile.numbers[rows], own=tile.distances[rows], slots=np.concatenate(asked))

    def finish(self, first: int, last: int) -> None:
        """The factors of those points of a tile that had asked around; every tile must have been through `find`."""
        numbers, own, slots = self.all_aside([(first, last)], "numbers", "own", "slots")
        self.amend(first, last, numbers, outliers.compare_rows(own, self.distances.gather(slots)))


@dataclass(frozen=True)
class Cloud:
    """The points of a file that are left."""

    source: Source
    folder: Path  # for the files of the work
    kept: Column | None = None  # of each of its points whether it is left, None if all are

    scalars = Stored("<f8")  # the probability of each point of the file in the last stage that it was in
    normals = Stored("<f8", 3)  # the normal of each point of the file in the last stage that gave it one

    def left(self, first: int, last: int) -> Bools:
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
            low = np.minimum(low, places.min(axis=0, initial=np.inf))
            high = np.maximum(high, places.max(axis=0, initial=-np.inf))
        return count, low, high

    def divide(self, count: int, folder: Path, most: int, size: int, grid: float | None = None) -> list[Bucket]:
        """The points in buckets, see `divide`; with a `grid` their cells in one of such cubes."""

        def slices() -> Iterator[tuple[Floats, Longs]]:
            for places, numbers in self.slices(size):
                yield places if grid is None else outliers.grid_cells(places, grid), numbers

        return divide(slices, count, folder, most=most)

    def take(self, step: PlannedStep, results: Results, tiles: Ranges, size: int, target: Column) -> dict[str, Any]:
        """Give the points that are left what the tiles have found; what the filter reports.

        A selection writes down in `target` which points of the file are left after it.
        """
        found = replace(results.values, path=self.folder / "found")  # of the points that are left, in their order
        count, total, done = tiles[-1][1], len(self.source), 0
        for first, block in zip(range(0, count, size), results.in_order(tiles, size), strict=True):
            found.write(first, block)
        column = {LOOP: self.scalars, POINT_NORMALS: self.normals}.get(step.filter)
        if column is not None and not column.path.exists():
            column.write(total - 1, np.zeros((1, column.width)))
        spread = 0.0
        if step.filter == LOOP:
            spread = outliers.spread_of(lambda: found.slices(outliers.SPREAD_BLOCK), step.values["extent"])
        selected, largest, sums = 0, 0.0, []
        for first in range(0, total, size):
            left = self.left(first, min(first + size, total))
            values = found.read(done, done + int(left.sum()))
            done += len(values)
            if step.filter == LOOP:
                values = outliers.probabilities_of(values, spread)
                largest = max(largest, float(values.max(initial=0.0)))
                sums.append(float(values.sum()))
            if column is not None:
                whole = column.read(first, first + len(left))
                whole[left] = values
                column.write(first, whole)
            if step.filter != POINT_NORMALS:
                goes = values > step.values.get("threshold", 0)
                selected += int(np.count_nonzero(goes))
                left[left] = ~(goes & step.deletes)
                target.write(first, left)
        found.path.unlink()
        if step.filter == POINT_NORMALS:
            return {}
        reported = {"largest_probability": largest, "mean_probability": math.fsum(sums) / count} if step.filter == LOOP else {}
        return {"removed_vertices" if step.filter == DUPLICATES else "selected_vertices": selected, **reported}


def do_step(
    cloud: Cloud, step: PlannedStep, tasks: Tasks, tile: int, *, progress: Callable[[float], None], most: int | None = None
) -> tuple[Cloud, dict[str, Any], dict[str, Any]]:
    """One step with tiles of at most `tile` bytes: what is left, the filter's report, the numbers of the cloud and its tiles."""
    size = slice_rows(tile, cloud.source.row)
    count, low, high = tasks.run(cloud.survey, size)
    if step.neighbors >= count:
        raise FilterInputError(f"{step.neighbors} neighbours need a cloud of at least {step.neighbors + 1} points, got {count}")
    progress(0.02)
    folder, target = cloud.folder / f"step-{step.step}", Column(cloud.folder / f"kept-{step.step}", "u1")
    folder.mkdir(exist_ok=True)
    points = most or cloud_points(tile, step.neighbors, normals=step.filter == POINT_NORMALS)
    grid = None
    if step.filter == SURPLUS:
        grid = step.values["side"].resolve(diagonal=box_diagonal(np.stack([low, high])), mean_edge=lambda: 0.0)
    buckets = tasks.run(cloud.divide, count, folder, points, size, grid)
    progress(0.1)
    if step.filter in (DUPLICATES, SURPLUS):
        tiles = list(pairwise(accumulate((bucket.count for bucket in buckets), initial=0)))
        results = Results(Column(folder / "results", "u1"))
        placed = zip([first for first, _ in tiles], buckets, strict=True)
        groups = [(results, tuple(group)) for _, group in groupby(placed, lambda one: one[1].path)]
        tasks.map(mark_later, groups, part_of(progress, 0.1, 0.9))
    else:
        scale = tree_scale(float(max(high.max(), -low.min())))
        cells = Cells.of(buckets, folder, scale, tasks, part_of(progress, 0.1, 0.2))
        ranges = tasks.run(cells.tiles, points)
        kinds: dict[str, type[PointTiles]] = {LOOP: OutlierTiles, POINT_NORMALS: NormalTiles, STRAYS: StrayTiles}
        work = kinds[step.filter](cells, step.values, step.neighbors, points)
        work.do(tasks, ranges, size, part_of(progress, 0.2, 0.9))
        tiles, results = tasks.run(cells.slots_of_tiles, ranges), work.results
    values = tasks.run(cloud.take, step, results, tiles, size, target)
    shutil.rmtree(folder, ignore_errors=True)
    progress(1.0)
    if step.deletes and values.get("selected_vertices") == count:
        raise FilterInputError(f"all {count} points were selected, so that nothing is left of the cloud")
    sizes = {"points": count, "low": low.tolist(), "high": high.tolist(), "tiles": len(tiles), "points_per_tile": points}
    return cloud if step.filter == POINT_NORMALS else replace(cloud, kept=target), values, sizes


def write_cloud(cloud: Cloud, target: Path, size: int) -> int:
    """Write what is left, as it was read, with the probabilities and the normals if there are any; how many points that are."""
    total, names = len(cloud.source), cloud.source.names
    slices = [(first, min(first + size, total)) for first in range(0, total, size)]
    additions = (("scalars", cloud.scalars), ("normals", cloud.normals))
    columns = [(names[name], column) for name, column in additions if column.path.exists()]
    count = sum(int(np.count_nonzero(cloud.left(*rows))) for rows in slices)
    marks = (
        (cloud.left(*rows), {n: v for own, c in columns for n, v in zip(own, np.atleast_2d(c.read(*rows).T), strict=True)})
        for rows in slices
    )
    cloud.source.write(target, count, marks, size, added=tuple(name for own, _ in columns for name in own))
    return count

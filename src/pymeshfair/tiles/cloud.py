"""Steps on clouds by tiles: they select points and may delete them, or compute normals; the result is written by slices.

This module has LoOP (local outlier probability), and the steps that keep one point at each place or in each cell of a grid.
`neighbours` has the other steps.
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
from ..files.errors import ContentsError
from ..files.polygons import numbered
from ..filters import outliers
from ..filters.execution import ignore_progress, part_of
from ..filters.inspection.surface_measures import box_diagonal
from ..filters.mesh import Bools, Floats, Longs
from ..filters.neighbours import tree_scale
from .cells import Bucket, Cells, Column, Ranges, Results, Stored, divide
from .neighbours import NormalTiles, PointTiles, StrayTiles, TilePoints
from .plan import DUPLICATES, LOOP, POINT_NORMALS, STRAYS, SURPLUS, PlannedStep, cloud_points, slice_rows
from .sources import Source
from .workers import Tasks


def mark_later(results: Results, buckets: Sequence[tuple[int, Bucket]]) -> None:
    """Marks all but the first point of each place or grid cell; `buckets` are pairs of a first row in `results` and a bucket."""
    points = np.empty((0, 3))
    for first, bucket in buckets:
        coordinates, numbers = bucket.read()
        count, points = len(points), np.concatenate([points, coordinates])
        firsts, _ = numbered(points)
        later = np.ones(len(coordinates), np.uint8)
        later[firsts[count:] - count] = 0
        results.write(first, numbers, later)
        points = points[firsts]


def mark_copies(
    buckets: Sequence[Bucket], folder: Path, tasks: Tasks, progress: Callable[[float], None] = ignore_progress
) -> tuple[Ranges, Results]:
    """Does `mark_later` for all buckets; returns the tiles and the marks."""
    tiles = list(pairwise(accumulate((bucket.count for bucket in buckets), initial=0)))
    results = Results(Column(folder / "results", "u1"))
    placed = zip([first for first, _ in tiles], buckets, strict=True)
    groups = [(results, tuple(group)) for _, group in groupby(placed, lambda placed_bucket: placed_bucket[1].path)]
    tasks.map(mark_later, groups, progress)
    return tiles, results


class OutlierTiles(PointTiles):
    """The tasks of LoOP (local outlier probability); the results are the probabilistic local outlier factors (PLOF)."""

    result = "<f8", 1

    distances = Stored("<f8")  # root mean square distances of the neighbours by slot (see `Cells`), divided by `Cells.scale`

    def do(self, tasks: Tasks, tiles: Ranges, size: int, progress: Callable[[float], None]) -> None:
        tasks.map(self.find, tiles, part_of(progress, 0.0, 0.85))
        tasks.map(self.finish, tiles, part_of(progress, 0.85, 1.0))

    def find(self, first: int, last: int) -> None:
        """Writes the root mean square distances in a tile, and the factors of points without neighbours in other tiles."""
        tile = TilePoints.of(self.cells, first, last, self.k)
        row_blocks, slot_blocks = [np.empty(0, np.intp)], [np.empty((0, self.k), np.int64)]
        for rows, nearest in tile.search_around(self.most):
            row_blocks.append(rows)
            slot_blocks.append(nearest.slots)
        rows, factors = np.concatenate(row_blocks), np.zeros(len(tile.slots))
        if len(rows) < len(factors):
            factors = outliers.compare_rows(tile.distances, tile.distances.take(tile.nearest))
        self.distances.write(tile.begin, tile.by_slot(tile.distances))
        self.results.write(tile.begin, tile.numbers, factors)
        np.savez(self.saved(first), numbers=tile.numbers[rows], distances=tile.distances[rows], slots=np.concatenate(slot_blocks))

    def finish(self, first: int, last: int) -> None:
        """Writes the factors of points with neighbours in other tiles, after `find` on every tile."""
        numbers, distances, slots = self.load_saved([(first, last)], "numbers", "distances", "slots")
        self.amend(first, last, numbers, outliers.compare_rows(distances, self.distances.gather(slots)))


@dataclass(frozen=True)
class Cloud:
    """The points of a file, without those that steps have deleted."""

    source: Source
    folder: Path  # of temporary files
    kept: Column | None = None  # for each point the sum of 1 if it remains and 2 if the last step selected it; None: all remain
    bit: int = 1  # which points of `kept` this cloud has: 1 for those that remain, 2 for the selected ones

    scalars = Stored("<f8")  # outlier probabilities of all points of the file, each from the last LoOP step with this point
    normals = Stored("<f8", 3)  # normals of all points of the file, each from the last step that gave the point a normal

    def mask(self, first: int, last: int) -> Bools:
        return np.ones(last - first, np.bool_) if self.kept is None else self.kept.read(first, last) & self.bit > 0

    def has_scalars(self) -> bool:
        return self.scalars.path.exists() or self.source.has("scalars")

    def slices(self, size: int) -> Iterator[tuple[Floats, Longs]]:
        """Yields (m, 3) coordinates and (m,) numbers of the remaining points; the numbers do not count deleted points."""
        first = read = 0
        for points in self.source.points(size):
            start, read = read, read + len(points)
            points = points[self.mask(start, read)]
            yield np.ascontiguousarray(points), np.arange(first, first + len(points))
            first += len(points)

    def survey(self, size: int) -> tuple[int, Floats, Floats]:
        """Returns the number of remaining points, and the corners of their box; refuses coordinates that are not finite."""
        count, low, high = 0, np.full(3, np.inf), np.full(3, -np.inf)
        for points, numbers in self.slices(size):
            finite = np.isfinite(points).all(axis=1)
            if not finite.all():
                text = f"point {numbers[finite.argmin()]} is {points[finite.argmin()].tolist()}, which is not finite"
                raise ContentsError(f"{text}: drop --tiles, and such points are left out")
            count += len(points)
            low = np.minimum(low, points.min(axis=0, initial=np.inf))
            high = np.maximum(high, points.max(axis=0, initial=-np.inf))
        return count, low, high

    def divide(self, count: int, folder: Path, most: int, size: int, grid: float | None = None) -> list[Bucket]:
        """Divides the remaining points into buckets by coordinates, or by the indices of their cells in a grid of side `grid`."""

        def slices() -> Iterator[tuple[Floats, Longs]]:
            for points, numbers in self.slices(size):
                yield points if grid is None else outliers.grid_cells(points, grid), numbers

        return divide(slices, count, folder, most=most)

    def take(self, step: PlannedStep, results: Results, tiles: Ranges, size: int, target: Column) -> dict[str, Any]:
        """Stores probabilities or normals, writes `kept` to `target`; returns the filter's report."""
        point_results = replace(results.values, path=self.folder / "found")  # in the order of the points
        count, total, done = tiles[-1][1], len(self.source), 0
        for first, block in zip(range(0, count, size), results.in_order(tiles, size), strict=True):
            point_results.write(first, block)
        column = {LOOP: self.scalars, POINT_NORMALS: self.normals}.get(step.filter)
        if column is not None and not column.path.exists():
            column.write(total - 1, np.zeros((1, column.width)))
        spread = 0.0
        if step.filter == LOOP:
            spread = outliers.spread_of(lambda: point_results.slices(outliers.SPREAD_BLOCK), step.values["extent"])
        selected, largest, sums = 0, 0.0, []
        for first in range(0, total, size):
            remaining = self.mask(first, min(first + size, total))
            values = point_results.read(done, done + int(remaining.sum()))
            done += len(values)
            if step.filter == LOOP:
                values = outliers.probabilities_of(values, spread)
                largest = max(largest, float(values.max(initial=0.0)))
                sums.append(float(values.sum()))
            if column is not None:
                block = column.read(first, first + len(remaining))
                block[remaining] = values
                column.write(first, block)
            if step.filter != POINT_NORMALS:
                is_selected = values > step.values.get("threshold", 0)
                selected += int(np.count_nonzero(is_selected))
                states = remaining.astype(np.uint8)
                states[remaining] = ~(is_selected & step.deletes) + 2 * is_selected
                target.write(first, states)
        point_results.path.unlink()
        if step.filter == POINT_NORMALS:
            return {}
        reported = {"largest_probability": largest, "mean_probability": math.fsum(sums) / count} if step.filter == LOOP else {}
        return {"removed_vertices" if step.filter == DUPLICATES else "selected_vertices": selected, **reported}


def do_step(
    cloud: Cloud, step: PlannedStep, tasks: Tasks, tile: int, *, progress: Callable[[float], None], most: int | None = None
) -> tuple[Cloud, dict[str, Any], dict[str, Any]]:
    """Does a step with tiles of at most `most` points, or of `tile` bytes; returns the new cloud, report, and sizes before.

    The sizes include the resolved "lengths", and the number of stray points that are "copies" of other stray points.
    """
    size = slice_rows(tile, cloud.source.row)
    count, low, high = tasks.run(cloud.survey, size)
    if step.neighbors >= count:
        raise FilterInputError(f"{step.neighbors} neighbours need a cloud of at least {step.neighbors + 1} points, got {count}")
    progress(0.02)
    folder, target = cloud.folder / f"step-{step.step}", Column(cloud.folder / f"kept-{step.step}", "u1")
    folder.mkdir(exist_ok=True)
    points = most or cloud_points(tile, step.neighbors, normals=step.filter == POINT_NORMALS)
    lengths = dict[str, float]()  # in mesh units, by parameter
    if step.filter == SURPLUS:
        lengths["side"] = step.values["side"].resolve(diagonal=box_diagonal(np.stack([low, high])), mean_edge=lambda: 0.0)
    buckets = tasks.run(cloud.divide, count, folder, points, size, *lengths.values())
    progress(0.1)
    if step.filter in (DUPLICATES, SURPLUS):
        tiles, results = mark_copies(buckets, folder, tasks, part_of(progress, 0.1, 0.9))
    else:
        cells = Cells.of(buckets, folder, tree_scale(float(max(high.max(), -low.min()))), tasks, part_of(progress, 0.1, 0.2))
        ranges = tasks.run(cells.tiles, points)
        kinds: dict[str, type[PointTiles]] = {LOOP: OutlierTiles, POINT_NORMALS: NormalTiles, STRAYS: StrayTiles}
        work = kinds[step.filter](cells, step.values, step.neighbors, points)
        work.do(tasks, ranges, size, part_of(progress, 0.2, 0.9))
        tiles, results = tasks.run(cells.slots_of_tiles, ranges), work.results
    replaces = step.filter == LOOP and tasks.run(cloud.has_scalars)
    values, copies = tasks.run(cloud.take, step, results, tiles, size, target), 0
    if replaces:
        values["notes"] = (outliers.REPLACED_SCALARS,)
    shutil.rmtree(folder, ignore_errors=True)
    if step.filter == STRAYS and values["selected_vertices"]:
        folder = cloud.folder / f"strays-{step.step}"  # not the `folder` that a resumed run removes above
        folder.mkdir(exist_ok=True)
        buckets = tasks.run(replace(cloud, kept=target, bit=2).divide, values["selected_vertices"], folder, points, size)
        copies = tasks.run(mark_copies(buckets, folder, tasks)[1].values.total, size)
        shutil.rmtree(folder, ignore_errors=True)
    progress(1.0)
    if step.deletes and values.get("selected_vertices") == count:
        raise FilterInputError(f"all {count} points were selected, so that nothing is left of the cloud")
    sizes = {"points": count, "low": low.tolist(), "high": high.tolist(), "tiles": len(tiles), "points_per_tile": points}
    sizes |= {"lengths": lengths, "copies": copies}
    return cloud if step.filter == POINT_NORMALS else replace(cloud, kept=target), values, sizes


def write_cloud(cloud: Cloud, target: Path, size: int) -> int:
    """Writes the remaining points, with probabilities and normals if steps computed them; returns the number of points."""
    total = len(cloud.source)
    slices = [(first, min(first + size, total)) for first in range(0, total, size)]
    columns = [(names, getattr(cloud, name)) for name, names in cloud.source.names.items() if getattr(cloud, name).path.exists()]
    count = sum(int(np.count_nonzero(cloud.mask(*rows))) for rows in slices)
    marks = (
        (cloud.mask(*rows), {n: v for names, c in columns for n, v in zip(names, np.atleast_2d(c.read(*rows).T), strict=True)})
        for rows in slices
    )
    cloud.source.write(target, count, marks, size, added=tuple(name for names, _ in columns for name in names))
    return count

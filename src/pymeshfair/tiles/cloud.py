"""A cloud by tiles: stages of selecting outliers, each of which may delete them, and the result written by slices."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FilterInputError
from ..filters.neighbours import tree_scale
from ..filters.outliers import SPREAD_BLOCK, probabilities_of, spread_of
from .by_number import Part, in_order
from .cells import Cells
from .columns import Column
from .division import Bucket, Floats, Longs, Shape, divide
from .memory import outlier_points, slice_rows
from .outliers import OutlierTiles
from .plan import Selection
from .sources import Source
from .workers import Pool


@dataclass(frozen=True)
class Cloud:
    """The points of a file that are left.

    Attributes:
        source: the file.
        folder: for the files of the work.
        kept: of each of its points whether it is left, None if all are.
    """

    source: Source
    folder: Path
    kept: Column | None = None

    @property
    def scalars(self) -> Column:
        """The probability of each point of the file in the last stage that it was in."""
        return Column(self.folder / "scalars", "<f8")

    def slices(self, size: int) -> Iterator[tuple[Floats, Longs]]:
        """(m, 3) coordinates and (m,) numbers of the points that are left, counted without the others."""
        first = read = 0
        for places in self.source.points(size):
            start, read = read, read + len(places)
            if self.kept is not None:
                places = places[self.kept.read(start, read) > 0]
            yield np.ascontiguousarray(places), np.arange(first, first + len(places))
            first += len(places)

    def survey(self, size: int) -> tuple[int, Floats, Floats]:
        """How many points are left, and the corners of their box; refuses coordinates that are not finite."""
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

    def divide(self, count: int, folder: Path, most: int, shape: Shape, size: int) -> list[Bucket]:
        """The points in buckets; see `pymeshfair.tiles.division.divide`."""
        return divide(lambda: self.slices(size), count, folder, most=most, shape=shape)


@dataclass(frozen=True)
class Judgement:
    """The end of a stage, as tasks: factors in the order of the points, their spread, and who is selected.

    Attributes:
        cloud: the points that are left.
        parts: of each tile, its factors.
        count: the points.
        selection: what was asked for.
        target: where what is left now is written down.
    """

    cloud: Cloud
    parts: tuple[Part, ...]
    count: int
    selection: Selection
    target: Column

    @property
    def factors(self) -> Column:
        """PLOF of each point that is left, in their order."""
        return Column(self.cloud.folder / "factors", "<f8")

    def gather(self, size: int) -> float:
        """Put the factors in order; their spread."""
        self.factors.path.unlink(missing_ok=True)
        for block in in_order(self.parts, self.count, size):
            self.factors.append(block)
        return spread_of(self._blocks, self.selection.extent)

    def _blocks(self) -> Iterable[Floats]:
        return (self.factors.read(at, min(at + SPREAD_BLOCK, self.count)) for at in range(0, self.count, SPREAD_BLOCK))

    def select(self, spread: float, size: int) -> dict[str, Any]:
        """Write down probabilities, and what is left; what the filter reports."""
        cloud, total, done = self.cloud, len(self.cloud.source), 0
        cloud.scalars.path.touch()
        if not len(cloud.scalars):
            cloud.scalars.create(total)
        self.target.create(total)
        selected, largest, sums = 0, 0.0, []
        for first in range(0, total, size):
            last = min(first + size, total)
            left = np.ones(last - first, np.bool_) if cloud.kept is None else cloud.kept.read(first, last) > 0
            count = int(left.sum())
            probabilities = probabilities_of(self.factors.read(done, done + count), spread)
            done += count
            scalars = cloud.scalars.read(first, last)
            scalars[left] = probabilities
            cloud.scalars.write(first, scalars)
            goes = probabilities > self.selection.threshold
            if self.selection.deletes:
                left[left] = ~goes
            self.target.write(first, left.astype(np.uint8))
            selected += int(goes.sum())
            largest = max(largest, float(probabilities.max(initial=0.0)))
            sums.append(float(probabilities.sum()))
        return {"selected_vertices": selected, "largest_probability": largest, "mean_probability": math.fsum(sums) / self.count}


def do_selection(
    cloud: Cloud,
    selection: Selection,
    pool: Pool,
    tile: int,
    *,
    shape: Shape,
    progress: Callable[[float], None],
    most: int | None = None,
) -> tuple[Cloud, dict[str, Any], dict[str, Any]]:
    """One stage.

    Args:
        cloud: what is left before.
        selection: what to do.
        pool: of workers.
        tile: bytes that a tile may take.
        shape: of tiles.
        progress: called with the share that is done.
        most: points of a tile, in place of what fits.

    Returns:
        What is left; what the filter reports; what is known of the cloud and the tiles.
    """
    size = slice_rows(tile, cloud.source.row)
    count, low, high = pool.run(cloud.survey, size)
    if selection.neighbors >= count:
        raise FilterInputError(
            f"{selection.neighbors} neighbours need a cloud of at least {selection.neighbors + 1} points, got {count}"
        )
    progress(0.02)
    folder = cloud.folder / f"step-{selection.step}"
    folder.mkdir()
    points = outlier_points(tile, selection.neighbors) if most is None else most
    buckets = pool.run(cloud.divide, count, folder, points, shape, size)
    progress(0.1)
    cells = Cells.make(folder, count, tree_scale(float(max(high.max(), -low.min()))))
    starts = np.cumsum([0, *(bucket.count for bucket in buckets)]).tolist()
    filled = pool.map(cells.fill, list(zip(buckets, starts, strict=False)), lambda share: progress(0.1 + 0.1 * share))
    cells.index(filled)
    tiles = cells.tiles(points)
    work = OutlierTiles(cells, selection.neighbors, points)
    work.distances.create(count)
    pool.map(work.find, tiles, lambda share: progress(0.2 + 0.6 * share))
    pool.map(work.finish, [(first,) for first, _ in tiles], lambda share: progress(0.8 + 0.1 * share))
    judgement = Judgement(
        cloud,
        tuple(work.part(first) for first, _ in tiles),
        count,
        selection,
        Column(cloud.folder / f"kept-{selection.step}", "u1"),
    )
    spread = pool.run(judgement.gather, size)
    shutil.rmtree(folder)
    values = pool.run(judgement.select, spread, size)
    judgement.factors.path.unlink()
    progress(1.0)
    known = {"points": count, "low": low.tolist(), "high": high.tolist(), "tiles": len(tiles), "points_per_tile": points}
    return replace(cloud, kept=judgement.target), values, known


def write_cloud(cloud: Cloud, target: Path, size: int) -> int:
    """Write what is left, as it was read, with the probabilities; how many points that are."""
    assert cloud.kept is not None
    count = 0
    for first in range(0, len(cloud.source), size):
        count += int((cloud.kept.read(first, min(first + size, len(cloud.source))) > 0).sum())

    def marks() -> Iterator[tuple[NDArray[np.bool_], Floats]]:
        for first in range(0, len(cloud.source), size):
            last = min(first + size, len(cloud.source))
            yield cloud.kept.read(first, last) > 0, cloud.scalars.read(first, last)  # type: ignore[union-attr]

    cloud.source.write(target, count, marks(), size)
    return count

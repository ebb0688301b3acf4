"""A cloud in cells: runs of some hundred points that lie close together, each with its box, in files read by cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..filters.execution import ignore_progress
from ..filters.neighbours import CellTree, build_tree
from .columns import Column, Stored
from .division import Bucket, Floats, Longs

#: the first cell (or slot) of each tile, and the one behind its last
Ranges: TypeAlias = list[tuple[int, int]]

#: points in a cell, unless that would make too many cells for the memory of a worker
CELL, MOST_CELLS = 512, 1 << 18


@dataclass(frozen=True)
class Cells:
    """The files of a cloud; a point's place in them is its slot, its place in the input its number."""

    folder: Path  # of the files
    count: int  # points
    scale: float  # the power of two that coordinates are divided by, of `tree_scale`
    cell: int = CELL  # points of a cell, the last one of a bucket may have fewer

    points = Stored("<f8", 3)  # coordinates by slot, as in the input
    numbers = Stored("<i8")  # by slot
    _starts, _boxes = Stored("<i8"), Stored("<f8", 6)  # of the cells

    @classmethod
    def make(cls, folder: Path, count: int, scale: float) -> Cells:
        """The files, of a cloud of so many points."""
        cell = max(CELL, -(-count // MOST_CELLS))
        made = cls(folder, count, scale, cell)
        made.points.create(count)
        made.numbers.create(count)
        return made

    def fill(self, bucket: Bucket, first: int) -> tuple[Longs, Floats]:
        """Put the points of a bucket into the slots from `first` on; (c,) first slots and (c, 2, 3) boxes of its cells."""
        places, numbers = bucket.read()
        order = build_tree(places, ignore_progress, scale=self.scale).indices[: len(places)]
        places, numbers = places[order], numbers[order]
        self.points.write(first, places)
        self.numbers.write(first, numbers)
        starts = np.arange(0, len(places), self.cell)
        boxes = np.stack([np.minimum.reduceat(places, starts), np.maximum.reduceat(places, starts)], axis=1)
        return starts + first, boxes

    def index(self, filled: Sequence[tuple[Longs, Floats]], buckets: Sequence[Bucket]) -> None:
        """Write the first slots and the boxes of all cells, in the order of the buckets, whose files are removed."""
        starts = np.concatenate([starts for starts, _ in filled])
        boxes = np.concatenate([boxes for _, boxes in filled])
        self._starts.create(len(starts) + 1).write(0, np.append(starts, self.count))
        self._boxes.create(len(boxes)).write(0, boxes.reshape(-1, 6))
        for bucket in buckets:
            bucket.path.unlink(missing_ok=True)

    @property
    def starts(self) -> Longs:
        """(c + 1,) the slot at which each cell begins."""
        return _index(self._starts, self._boxes, self.scale)[0]

    def slots_of(self, first: int, last: int) -> tuple[int, int]:
        """The first slot of the cells from `first` to before `last`, and the one behind their last."""
        starts = self.starts
        return int(starts[first]), int(starts[last])

    def ranges_of(self, cells: NDArray[np.int64]) -> Ranges:
        """The first slot and the one behind the last of each run of consecutive cells."""
        runs = np.split(cells, np.flatnonzero(np.diff(cells) != 1) + 1) if len(cells) else []
        return [self.slots_of(run[0], run[-1] + 1) for run in runs]

    @property
    def tree(self) -> CellTree:
        """The boxes of the cells, in the unit of trees."""
        return _index(self._starts, self._boxes, self.scale)[1]

    def tiles(self, most: int) -> Ranges:
        """Cells from one to before another for each tile, in which there are at most so many points, or one cell."""
        starts = self.starts
        ranges, first = [], 0
        while first < len(starts) - 1:
            last = int(np.searchsorted(starts, starts[first] + most, "right")) - 1
            ranges.append((first, max(last, first + 1)))
            first = ranges[-1][1]
        return ranges

    def read(self, cells: NDArray[np.int64]) -> tuple[Floats, Longs, Longs, Longs]:
        """The points of some cells, in ascending order: coordinates in the unit of trees, numbers, slots, and the cells' rows.

        The rows are (c, 2) for every cell of the cloud: where its points begin and end among these, 0 and 0 of the others.
        """
        starts, ranges = self.starts, self.ranges_of(cells)
        places = np.concatenate([np.empty((0, 3)), *(self.points.read(*r) for r in ranges)])
        numbers = np.concatenate([np.empty(0, np.int64), *(self.numbers.read(*r) for r in ranges)])
        slots = np.concatenate([np.empty(0, np.int64), *(np.arange(*r) for r in ranges)])
        rows = np.zeros((len(starts) - 1, 2), np.int64)
        ends = np.cumsum(starts[cells + 1] - starts[cells])
        rows[cells, 1] = ends
        rows[cells, 0] = ends - (starts[cells + 1] - starts[cells])
        return places / self.scale, numbers, slots, rows


@lru_cache(maxsize=1)
def _index(starts: Column, boxes: Column, scale: float) -> tuple[Longs, CellTree]:
    """The index of all cells, read once by every process."""
    first = starts.read(0, len(starts))
    places = boxes.read(0, len(boxes)).reshape(-1, 2, 3) / scale
    return first, CellTree.over(places, np.diff(first))

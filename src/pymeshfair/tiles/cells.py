"""Points into buckets that fit into memory, and from these into cells, in files that are read by rows.

Buckets divide by place, as the upper levels of a k-d tree would. Pivots are medians of a sample, so that the division follows the
density. A bucket that gets too many points all the same is divided again; points at one place, which nothing divides, are cut by
their number. A cell has some hundred points of a bucket that lie close together, and a box. No result depends on any of that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import accumulate
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..filters.compilation import compiled
from ..filters.execution import ignore_progress
from ..filters.mesh import Floats, Ints, Longs
from ..filters.neighbours import CellTree, build_tree
from .workers import Tasks

#: the first cell (or slot) of each tile, and the one behind its last
Ranges: TypeAlias = list[tuple[int, int]]
#: points in a cell, unless that would make too many cells for the memory of a worker
CELL, MOST_CELLS = 512, 1 << 18
#: gives (n, 3) coordinates and (n,) numbers, a slice at a time; may be called more than once
Slices: TypeAlias = Callable[[], Iterable[tuple[Floats, Longs]]]

#: points of the sample for each bucket, and at most in all
_SAMPLED, _LARGEST_SAMPLE = 4096, 1 << 19
#: buckets that are written at a time, each through a file that is open only to be appended to
MOST_BUCKETS = 512
#: a row of a bucket: the coordinates, and the number
ROW = np.dtype([("place", "<f8", 3), ("number", "<i8")])


@dataclass(frozen=True)
class Column:
    """An array in a file of its own, read and written by rows; processes may write to different rows at once."""

    path: Path
    dtype: str  # the type of a number in numpy's notation, such as ``"<f8"``
    width: int = 1  # numbers in a row

    @property
    def row(self) -> int:
        """Bytes of a row."""
        return np.dtype(self.dtype).itemsize * self.width

    def __len__(self) -> int:
        return self.path.stat().st_size // self.row

    def read(self, first: int, last: int) -> NDArray[Any]:
        """The rows from `first` to before `last`: (n,) if a row is one number, else (n, width)."""
        numbers = np.fromfile(self.path, self.dtype, (last - first) * self.width, offset=first * self.row)
        return numbers if self.width == 1 else numbers.reshape(-1, self.width)

    def slices(self, size: int) -> Iterator[NDArray[Any]]:
        """All rows, `size` at a time."""
        for first in range(0, len(self), size):
            yield self.read(first, first + size)

    def write(self, first: int, values: NDArray[Any]) -> None:
        """Write rows from `first` on; the file is made if need be, and rows that were never written are 0."""
        self.path.touch()
        with self.path.open("r+b") as file:
            file.seek(first * self.row)
            file.write(np.ascontiguousarray(values, self.dtype).data)

    def gather(self, rows: NDArray[np.int64]) -> NDArray[Any]:
        """The rows of an index array of any shape, by a memory map: for few rows that lie in groups."""
        if not rows.size:
            return np.empty(rows.shape if self.width == 1 else (*rows.shape, self.width), self.dtype)
        whole = np.memmap(self.path, self.dtype, "r")
        return np.array(whole[rows] if self.width == 1 else whole.reshape(-1, self.width)[rows])


@dataclass(frozen=True, eq=False)
class Part:
    """The points of a tile, which have consecutive slots, and after them others from around it."""

    begin: int  # the first slot
    end: int  # the slot after the last
    outside: Longs  # (o,) slots of the others, ascending

    @property
    def slots(self) -> Longs:
        """(n + o,) the slots of all."""
        return np.concatenate([np.arange(self.begin, self.end), self.outside])

    def rows(self, slots: NDArray[Any]) -> NDArray[Any]:
        """The places of some slots among these."""
        rows, others = slots - self.begin, (slots < self.begin) | (slots >= self.end)
        rows[others] = self.end - self.begin + np.searchsorted(self.outside, slots[others])
        return rows

    def of_own(self, column: Column) -> NDArray[Any]:
        """The values of the points of the tile."""
        return column.read(self.begin, self.end)

    def of_all(self, column: Column) -> NDArray[Any]:
        """The values of all."""
        return np.concatenate([self.of_own(column), column.gather(self.outside)])


class Stored:
    """A column of something in cells, in the file of its name in their folder."""

    def __init__(self, dtype: str, width: int = 1) -> None:
        self._kind = dtype, width

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name.strip("_")

    def __get__(self, stored: Any, owner: type) -> Column:
        return Column(getattr(stored, "cells", stored).folder / self._name, *self._kind)


@dataclass(frozen=True)
class Results:
    """Values of points by tiles: each tile has a range of rows, in which its points stand by ascending number."""

    values: Column

    @property
    def numbers(self) -> Column:
        """The number of the point of each row."""
        return Column(self.values.path.with_name(f"{self.values.path.name}.numbers"), "<i8")

    def write(self, first: int, numbers: Longs, values: NDArray[Any]) -> None:
        """Write the values of the points of a tile, in any order, into the rows from `first` on."""
        order = np.argsort(numbers)
        self.numbers.write(first, numbers[order])
        self.values.write(first, values[order])

    def in_order(self, tiles: Ranges, size: int) -> Iterator[NDArray[Any]]:
        """The values in the order of the points, `size` at a time; the tiles have all points, which are numbered from 0."""
        at, width = [first for first, _ in tiles], self.values.width
        ahead, count = max(1, size // max(1, len(tiles))), sum(end - first for first, end in tiles)
        for first in range(0, count, size):
            last, filled = min(first + size, count), 0
            block = np.empty((last - first, width), self.values.dtype)
            for i, (_, end) in enumerate(tiles):
                here = read = 0
                while at[i] < end and here == read:
                    numbers = self.numbers.read(at[i], min(at[i] + ahead, end))
                    read, here = len(numbers), int(np.searchsorted(numbers, last))
                    block[numbers[:here] - first] = self.values.read(at[i], at[i] + here).reshape(-1, width)
                    at[i], filled = at[i] + here, filled + here
            assert filled == last - first, f"points {first} to {last}: {filled} values"
            yield block if width > 1 else block[:, 0]


@dataclass(frozen=True)
class Bucket:
    """Points that fit into memory, in a file of rows of `ROW`, by ascending number."""

    path: Path  # of the file
    count: int  # points
    first: int = 0  # row in the file; points that nothing divides are cut by number, and then several buckets share it

    def read(self) -> tuple[Floats, Longs]:
        """The coordinates and the numbers."""
        rows = np.fromfile(self.path, ROW, self.count, offset=self.first * ROW.itemsize)
        assert len(rows) == self.count, f"{self.path}: {len(rows)} of {self.count} points"
        return np.ascontiguousarray(rows["place"]), np.ascontiguousarray(rows["number"])


def divide(slices: Slices, count: int, folder: Path, *, most: int, name: str = "bucket") -> list[Bucket]:
    """The points, given by ascending number, in buckets of at most `most` each; neighbours in the list are near in space."""
    wanted = min(MOST_BUCKETS, 1 << max(0, int(np.ceil(np.log2(1.15 * count / most)))))
    axes, pivots, leaves = _pivots(_sample(slices, count, wanted), wanted)
    paths = [folder / f"{name}-{leaf}" for leaf in range(leaves)]
    for path in paths:  # of a process that was killed here
        path.unlink(missing_ok=True)
    counts = np.zeros(leaves, np.int64)
    for places, numbers in slices():
        chosen = np.empty(len(places), np.int32)
        _assign(places, axes, pivots, chosen)
        order = np.argsort(chosen, kind="stable")
        rows = np.empty(len(places), ROW)
        rows["place"], rows["number"] = places[order], numbers[order]
        sizes = np.bincount(chosen, minlength=leaves)
        for path, part in zip(paths, np.split(rows, np.cumsum(sizes)[:-1]), strict=True):
            if len(part):
                with path.open("ab") as file:
                    file.write(part.tobytes())
        counts += sizes
    buckets: list[Bucket] = []
    for path, held in zip(paths, counts.tolist(), strict=True):
        pieces = [Bucket(path, min(most, held - first), first) for first in range(0, held, most)]
        if len(pieces) > 1 and leaves > 1:
            buckets += divide(partial(map, Bucket.read, pieces), held, folder, most=most, name=path.name)
            path.unlink()
        else:
            buckets += pieces
    return buckets


def _sample(slices: Slices, count: int, buckets: int) -> Floats:
    """Every so many-th point."""
    step = max(1, count // min(buckets * _SAMPLED, _LARGEST_SAMPLE))
    parts, skipped = [np.empty((0, 3))], 0
    for places, _ in slices():
        parts.append(places[skipped::step].copy())
        skipped = (skipped - len(places)) % step
    return np.concatenate(parts)


def _pivots(sample: Floats, wanted: int) -> tuple[Ints, Floats, int]:
    """A tree of cuts across the longest side: from node i to 2 i where a coordinate is below the pivot, else to 2 i + 1.

    Returns:
        The axis of each node, or minus one minus the number of the leaf that it is; the pivots; the number of leaves.
    """
    axes, pivots = np.zeros(2 * wanted, np.int32), np.zeros(2 * wanted)
    leaves = 0
    stack: list[tuple[int, Floats]] = [(1, sample)]
    while stack:
        node, points = stack.pop()
        axis = int(np.argmax(np.ptp(points, axis=0)))
        values = np.sort(points[:, axis])
        pivot = values[len(values) // 2]
        if pivot == values[0]:  # so many coincide that none is below the median: cut above them
            pivot = values[np.searchsorted(values, pivot, "right") % len(values)]
        if node >= wanted or pivot == values[0]:
            axes[node] = -1 - leaves
            leaves += 1
            continue
        axes[node], pivots[node] = axis, pivot
        below = points[:, axis] < pivot
        stack += [(2 * node + 1, points[~below]), (2 * node, points[below])]
    return axes, pivots, leaves


@compiled
def _assign(places: Any, axes: Any, pivots: Any, chosen: Any) -> None:
    for p in range(places.shape[0]):
        node = 1
        while axes[node] >= 0:
            node = 2 * node if places[p, axes[node]] < pivots[node] else 2 * node + 1
        chosen[p] = -1 - axes[node]


@dataclass(frozen=True)
class Cells:
    """The files of the points; a point's place in them is its slot, its place in the input its number."""

    folder: Path  # of the files
    count: int  # points
    scale: float  # the power of two that coordinates are divided by, of `tree_scale`

    points = Stored("<f8", 3)  # coordinates by slot, as in the input
    numbers = Stored("<i8")  # by slot
    _starts, _boxes = Stored("<i8"), Stored("<f8", 6)  # of the cells

    @classmethod
    def of(cls, buckets: Sequence[Bucket], folder: Path, scale: float, tasks: Tasks, progress: Callable[[float], None]) -> Cells:
        """Put the points of buckets, whose files are then removed, into cells."""
        cells = cls(folder, sum(bucket.count for bucket in buckets), scale)
        starts = accumulate((bucket.count for bucket in buckets), initial=0)
        tasks.run(cells._index, tasks.map(cells._fill, list(zip(buckets, starts, strict=False)), progress), buckets)
        return cells

    @property
    def cell(self) -> int:
        """Points of a cell; the last one of a bucket may have fewer."""
        return max(CELL, -(-self.count // MOST_CELLS))

    def _fill(self, bucket: Bucket, first: int) -> tuple[Longs, Floats]:
        """Put the points of a bucket into the slots from `first` on; (c,) first slots and (c, 2, 3) boxes of its cells."""
        places, numbers = bucket.read()
        order = build_tree(places, ignore_progress, scale=self.scale).indices[: len(places)]
        places = places[order]
        self.points.write(first, places)
        self.numbers.write(first, numbers[order])
        starts = np.arange(0, len(places), self.cell)
        boxes = np.stack([np.minimum.reduceat(places, starts), np.maximum.reduceat(places, starts)], axis=1)
        return starts + first, boxes

    def _index(self, filled: Sequence[tuple[Longs, Floats]], buckets: Sequence[Bucket]) -> None:
        """Write the first slots and the boxes of all cells, in the order of the buckets."""
        self._starts.write(0, np.concatenate([*(starts for starts, _ in filled), [self.count]]))
        self._boxes.write(0, np.concatenate([boxes for _, boxes in filled]).reshape(-1, 6))
        for bucket in buckets:
            bucket.path.unlink(missing_ok=True)

    @property
    def starts(self) -> Longs:
        """(c + 1,) the slot at which each cell begins."""
        return _read_index(self._starts, self._boxes, self.scale)[0]

    @property
    def tree(self) -> CellTree:
        """The boxes of the cells, in the unit of trees."""
        return _read_index(self._starts, self._boxes, self.scale)[1]

    def slots_of(self, first: int, last: int) -> tuple[int, int]:
        """The first slot of the cells from `first` to before `last`, and the one behind their last."""
        starts = self.starts
        return int(starts[first]), int(starts[last])

    def slots_of_tiles(self, tiles: Ranges) -> Ranges:
        """The same for each of some tiles."""
        return [self.slots_of(*tile) for tile in tiles]

    def ranges_of(self, cells: Longs) -> Ranges:
        """The first slot and the one behind the last of each run of consecutive cells."""
        runs = np.split(cells, np.flatnonzero(np.diff(cells) != 1) + 1) if len(cells) else []
        return [self.slots_of(run[0], run[-1] + 1) for run in runs]

    def tiles(self, most: int) -> Ranges:
        """Cells from one to before another for each tile, in which there are at most so many points, or one cell."""
        starts = self.starts
        ranges, first = [], 0
        while first < len(starts) - 1:
            last = int(np.searchsorted(starts, starts[first] + most, "right")) - 1
            ranges.append((first, max(last, first + 1)))
            first = ranges[-1][1]
        return ranges


@lru_cache(maxsize=1)
def _read_index(starts: Column, boxes: Column, scale: float) -> tuple[Longs, CellTree]:
    """The index of all cells, read once by every process."""
    first = starts.read(0, len(starts))
    places = boxes.read(0, len(boxes)).reshape(-1, 2, 3) / scale
    return first, CellTree.over(places, np.diff(first))

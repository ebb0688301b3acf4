"""Divides points into buckets that fit into memory, and buckets into cells; a point's slot is its row in the files of `Cells`.

Buckets are the leaves of a k-d tree. Its pivots are medians of a sample, so that the division follows the density. A bucket with
too many points is divided again, coincident points by their numbers. A cell has 512 points of a bucket that lie close
together (more in a huge cloud), and their bounding box; a tile is a range of cells.
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

#: for each tile the first cell (or slot), and the cell (or slot) after the last one
Ranges: TypeAlias = list[tuple[int, int]]
#: points of a cell, and about the most cells of a cloud: a huge cloud has larger cells, so that lists of cells stay small
CELL, MOST_CELLS = 512, 1 << 18
#: yields (n, 3) coordinates and (n,) numbers (see `Cells`), slice by slice; can be called more than once
Slices: TypeAlias = Callable[[], Iterable[tuple[Floats, Longs]]]

#: wanted sample: points for each bucket, and the most points in total; a sample has up to twice as many as wanted
_SAMPLED, _LARGEST_SAMPLE = 4096, 1 << 19
#: the most buckets of one division; their files are opened one at a time
MOST_BUCKETS = 512
#: a row of a bucket: the coordinates of a point and its number
ROW = np.dtype([("point", "<f8", 3), ("number", "<i8")])


@dataclass(frozen=True)
class Column:
    """An array in its own file, read and written by rows; processes may write different rows at the same time."""

    path: Path
    dtype: str
    width: int = 1  # numbers in a row

    @property
    def row(self) -> int:
        return np.dtype(self.dtype).itemsize * self.width

    def __len__(self) -> int:
        return self.path.stat().st_size // self.row

    def read(self, first: int, last: int) -> NDArray[Any]:
        """Returns the rows from `first` to before `last`: (n,) if a row is one number, else (n, width)."""
        numbers = np.fromfile(self.path, self.dtype, (last - first) * self.width, offset=first * self.row)
        return numbers if self.width == 1 else numbers.reshape(-1, self.width)

    def slices(self, size: int) -> Iterator[NDArray[Any]]:
        for first in range(0, len(self), size):
            yield self.read(first, first + size)

    def total(self, size: int) -> int:
        """Returns the sum of whole numbers, read `size` rows at a time."""
        return sum(int(values.sum()) for values in self.slices(size))

    def write(self, first: int, values: NDArray[Any]) -> None:
        """Writes rows from `first` on. Rows that were never written are 0."""
        self.path.touch()
        with self.path.open("r+b") as file:
            file.seek(first * self.row)
            file.write(np.ascontiguousarray(values, self.dtype).data)

    def gather(self, rows: NDArray[np.int64]) -> NDArray[Any]:
        """Returns rows by an array of indices of any shape, through a memory map; use it for few rows that lie in groups."""
        if not rows.size:
            return np.empty(rows.shape if self.width == 1 else (*rows.shape, self.width), self.dtype)
        mapped = np.memmap(self.path, self.dtype, "r")
        return np.array(mapped[rows] if self.width == 1 else mapped.reshape(-1, self.width)[rows])


@dataclass(frozen=True, eq=False)
class Part:
    """The points of a tile, which have consecutive slots, followed by points from outside of it."""

    begin: int  # the first slot
    end: int  # the slot after the last one
    outside: Longs  # (o,) slots of the points outside, ascending

    @property
    def slots(self) -> Longs:
        return np.concatenate([np.arange(self.begin, self.end), self.outside])

    def rows(self, slots: NDArray[Any]) -> NDArray[Any]:
        """Returns the index in `self.slots` of each given slot."""
        rows, is_outside = slots - self.begin, (slots < self.begin) | (slots >= self.end)
        rows[is_outside] = self.end - self.begin + np.searchsorted(self.outside, slots[is_outside])
        return rows

    def read_inside(self, column: Column) -> NDArray[Any]:
        return column.read(self.begin, self.end)

    def read_all(self, column: Column) -> NDArray[Any]:
        return np.concatenate([self.read_inside(column), column.gather(self.outside)])


class Stored:
    """An attribute that is a column. Its file has the attribute's name, in `folder` of the object or of the object's `cells`."""

    def __init__(self, dtype: str, width: int = 1) -> None:
        self._kind = dtype, width

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name.strip("_")

    def __get__(self, stored: Any, owner: type) -> Column:
        return Column(getattr(stored, "cells", stored).folder / self._name, *self._kind)


@dataclass(frozen=True)
class Results:
    """Values of points by tiles: each tile has a range of rows, in which its points are sorted by number."""

    values: Column

    @property
    def numbers(self) -> Column:
        return Column(self.values.path.with_name(f"{self.values.path.name}.numbers"), "<i8")

    def write(self, first: int, numbers: Longs, values: NDArray[Any]) -> None:
        """Writes values of the points of a tile, in any order, into the rows from `first` on."""
        order = np.argsort(numbers)
        self.numbers.write(first, numbers[order])
        self.values.write(first, values[order])

    def in_order(self, tiles: Ranges, size: int) -> Iterator[NDArray[Any]]:
        """Yields the values by ascending number, `size` at a time; together the tiles have all points, numbered from 0."""
        next_row, width = [first for first, _ in tiles], self.values.width
        chunk, count = max(1, size // max(1, len(tiles))), sum(end - first for first, end in tiles)
        for first in range(0, count, size):
            last, filled = min(first + size, count), 0
            block = np.empty((last - first, width), self.values.dtype)
            for i, (_, end) in enumerate(tiles):
                used = read = 0
                while next_row[i] < end and used == read:
                    numbers = self.numbers.read(next_row[i], min(next_row[i] + chunk, end))
                    read, used = len(numbers), int(np.searchsorted(numbers, last))
                    block[numbers[:used] - first] = self.values.read(next_row[i], next_row[i] + used).reshape(-1, width)
                    next_row[i], filled = next_row[i] + used, filled + used
            assert filled == last - first, f"points {first} to {last}: {filled} values"
            yield block if width > 1 else block[:, 0]


@dataclass(frozen=True)
class Bucket:
    """Points that fit into memory, in a file of `ROW` records, sorted by number."""

    path: Path
    count: int  # number of points
    first: int = 0  # its first row in the file; buckets of coincident points share a file

    def read(self) -> tuple[Floats, Longs]:
        rows = np.fromfile(self.path, ROW, self.count, offset=self.first * ROW.itemsize)
        assert len(rows) == self.count, f"{self.path}: {len(rows)} of {self.count} points"
        return np.ascontiguousarray(rows["point"]), np.ascontiguousarray(rows["number"])


def divide(slices: Slices, count: int, folder: Path, *, most: int, name: str = "bucket") -> list[Bucket]:
    """Divides points, given by ascending number, into buckets of at most `most`; consecutive buckets are close in space."""
    wanted = min(MOST_BUCKETS, 1 << max(0, int(np.ceil(np.log2(1.15 * count / most)))))
    axes, pivots, leaves = _pivots(_sample(slices, count, wanted), wanted)
    paths = [folder / f"{name}-{leaf}" for leaf in range(leaves)]
    for path in paths:  # a killed process may have left them
        path.unlink(missing_ok=True)
    counts = np.zeros(leaves, np.int64)
    for points, numbers in slices():
        leaf_of = np.empty(len(points), np.int32)
        _assign(points, axes, pivots, leaf_of)
        order = np.argsort(leaf_of, kind="stable")
        rows = np.empty(len(points), ROW)
        rows["point"], rows["number"] = points[order], numbers[order]
        sizes = np.bincount(leaf_of, minlength=leaves)
        for path, part in zip(paths, np.split(rows, np.cumsum(sizes)[:-1]), strict=True):
            if len(part):
                with path.open("ab") as file:
                    file.write(part.tobytes())
        counts += sizes
    buckets: list[Bucket] = []
    for path, size in zip(paths, counts.tolist(), strict=True):
        pieces = [Bucket(path, min(most, size - first), first) for first in range(0, size, most)]
        if len(pieces) > 1 and leaves > 1:
            buckets += divide(partial(map, Bucket.read, pieces), size, folder, most=most, name=path.name)
            path.unlink()
        else:
            buckets += pieces
    return buckets


def _sample(slices: Slices, count: int, buckets: int) -> Floats:
    step = max(1, count // min(buckets * _SAMPLED, _LARGEST_SAMPLE))
    parts, skipped = [np.empty((0, 3))], 0
    for points, _ in slices():
        parts.append(points[skipped::step].copy())
        skipped = (skipped - len(points)) % step
    return np.concatenate(parts)


def _pivots(sample: Floats, wanted: int) -> tuple[Ints, Floats, int]:
    """Builds a k-d tree that cuts boxes across their longest side: child 2 i of node i is below its pivot, 2 i + 1 is not.

    Returns the axis of each node, or -1 - i for the leaf i; the pivot of each node; the number of leaves.
    """
    axes, pivots = np.zeros(2 * wanted, np.int32), np.zeros(2 * wanted)
    leaves = 0
    stack: list[tuple[int, Floats]] = [(1, sample)]
    while stack:
        node, points = stack.pop()
        axis = int(np.argmax(np.ptp(points, axis=0)))
        values = np.sort(points[:, axis])
        pivot = values[len(values) // 2]
        if pivot == values[0]:  # no value is below the median: cut above it
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
    """The files of the points. The number of a point is its index among the points of the input that no step has deleted."""

    folder: Path
    count: int  # number of points
    scale: float  # for clouds the power of two of `tree_scale`, for meshes 1; coordinates are divided by it to build trees

    points = Stored("<f8", 3)  # coordinates by slot, as in the input
    numbers = Stored("<i8")  # by slot
    _starts, _boxes = Stored("<i8"), Stored("<f8", 6)  # by cell

    @classmethod
    def of(cls, buckets: Sequence[Bucket], folder: Path, scale: float, tasks: Tasks, progress: Callable[[float], None]) -> Cells:
        """Puts the points of buckets into cells; removes the files of the buckets."""
        cells = cls(folder, sum(bucket.count for bucket in buckets), scale)
        starts = accumulate((bucket.count for bucket in buckets), initial=0)
        tasks.run(cells._index, tasks.map(cells._fill, list(zip(buckets, starts, strict=False)), progress), buckets)
        return cells

    @property
    def cell(self) -> int:
        """The number of points of a cell; the last cell of a bucket may have fewer."""
        return max(CELL, -(-self.count // MOST_CELLS))

    def _fill(self, bucket: Bucket, first: int) -> tuple[Longs, Floats]:
        """Puts the points of a bucket into slots from `first` on; returns (c,) first slots and (c, 2, 3) boxes of its cells."""
        points, numbers = bucket.read()
        order = build_tree(points, ignore_progress, scale=self.scale).indices[: len(points)]
        points = points[order]
        self.points.write(first, points)
        self.numbers.write(first, numbers[order])
        starts = np.arange(0, len(points), self.cell)
        return starts + first, np.stack([np.minimum.reduceat(points, starts), np.maximum.reduceat(points, starts)], axis=1)

    def _index(self, filled: Sequence[tuple[Longs, Floats]], buckets: Sequence[Bucket]) -> None:
        self._starts.write(0, np.concatenate([*(starts for starts, _ in filled), [self.count]]))
        self._boxes.write(0, np.concatenate([boxes for _, boxes in filled]).reshape(-1, 6))
        for bucket in buckets:
            bucket.path.unlink(missing_ok=True)

    @property
    def starts(self) -> Longs:
        """(c + 1,) the first slots of the cells, and the number of points."""
        return self._read()[0]

    @property
    def tree(self) -> CellTree:
        """The boxes of the cells, divided by `scale`."""
        return self._read()[1]

    def _read(self) -> tuple[Longs, CellTree]:
        # With the time in its key, the cache does not return cells of an earlier run to the same output.
        return _read_index(self._starts, self._boxes, self.scale, self._boxes.path.stat().st_mtime_ns)

    def slots_of(self, first: int, last: int) -> tuple[int, int]:
        starts = self.starts
        return int(starts[first]), int(starts[last])

    def slots_of_tiles(self, tiles: Ranges) -> Ranges:
        return [self.slots_of(*tile) for tile in tiles]

    def ranges_of(self, cells: Longs) -> Ranges:
        """Returns the range of slots of each run of consecutive cells."""
        runs = np.split(cells, np.flatnonzero(np.diff(cells) != 1) + 1) if len(cells) else []
        return [self.slots_of(run[0], run[-1] + 1) for run in runs]

    def tiles(self, most: int) -> Ranges:
        """Divides the cells into tiles of at most `most` points, or of one cell."""
        starts = self.starts
        ranges, first = [], 0
        while first < len(starts) - 1:
            last = int(np.searchsorted(starts, starts[first] + most, "right")) - 1
            ranges.append((first, max(last, first + 1)))
            first = ranges[-1][1]
        return ranges


@lru_cache(maxsize=1)
def _read_index(starts: Column, boxes: Column, scale: float, time: int) -> tuple[Longs, CellTree]:
    first = starts.read(0, len(starts))
    return first, CellTree.over(boxes.read(0, len(boxes)).reshape(-1, 2, 3) / scale, np.diff(first))

"""The nearest neighbours of the points of a tile, in the tile and in the cells around it, and links to neighbours in any tile."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..filters.execution import ignore_progress, in_parallel
from ..filters.neighbours import Nearest, build_tree, cells_within, leaf_ranges, offer_cells, reaching_out, search_leaves
from ..filters.outliers import NO_LINK
from .cells import Cells, Ranges
from .columns import Column, Part
from .division import Floats, Longs
from .workers import Tasks

#: points of the cells around a tile that are in memory at once, as a share of the points of a tile
_AROUND = 0.125
#: and at least
_LEAST_AROUND = 1 << 15
#: points that ask at once, and the cells that these may ask for in all, both as shares of the points of a tile
_ASKING, _ASKED = 0.125, 8
#: points whose neighbours in the tile are put into order at once
_AT_ONCE = 4096

#: takes rows of the tree, and the (m, k) squared distances of their nearest points in the tile
Inside = Callable[[slice, Floats], None]
#: takes the tile, rows of its tree that ask around, and their nearest points in the whole cloud
Around = Callable[["TilePoints", NDArray[np.intp], Nearest], None]


@dataclass(frozen=True, eq=False)
class TilePoints:
    """The points of a tile, in the order of its tree."""

    cells: Cells  # the cloud
    first: int  # the first cell of the tile
    last: int  # the cell after its last
    places: Floats  # (n, 3) coordinates in the unit of trees, by ascending number
    numbers: Longs  # (n,) in the input, ascending
    slots: Longs  # (n,) where they are stored, by ascending number
    index: NDArray[np.int32]  # (n,) for each row of the tree which of these it is
    nearest: NDArray[np.int32]  # (n, k) rows that are nearest to each row in the tile; 0 if it has too few points

    def __len__(self) -> int:
        return len(self.index)

    @property
    def begin(self) -> int:
        """The first slot."""
        return int(self.cells.starts[self.first])

    def by_slot(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values by row of the tree in the order of the slots."""
        ordered = np.empty_like(values)
        ordered[self.slots[self.index] - self.begin] = values
        return ordered


@dataclass(frozen=True)
class PointTiles:
    """The tasks of a step on a cloud in cells; each may be done twice."""

    cells: Cells  # the cloud
    values: Mapping[str, Any]  # the parameters of the step
    k: int  # neighbours of a point
    most: int  # points of a tile

    result: ClassVar[tuple[str, int]]  # of a point, the type and how many numbers

    def do(self, tasks: Tasks, tiles: Ranges, size: int, progress: Callable[[float], None]) -> None:
        """All tasks, after which `part` is there of every tile; `size` rows of a file may be in memory."""
        raise NotImplementedError

    def part(self, first: int) -> Part:
        """The results of the tile that begins with the cell `first`."""
        return Part(self.cells.folder / f"result-{first}", *self.result)

    def aside(self, first: int) -> Path:
        """The file of what a tile leaves to a later task."""
        return self.cells.folder / f"aside-{first}.npz"

    def links(self) -> Column:
        """The slots of the neighbours."""
        return Column(self.cells.folder / "links", "<i8", self.k)

    def search(self, first: int, last: int, inside: Inside, around: Around) -> TilePoints:
        """Find the k nearest points of every point in the cells from `first` to before `last`.

        `inside` is called with what is found in the tile, in parallel for different rows; not if the tile has too few points.
        `around` is called afterwards with the points that have, or may have, neighbours in other tiles, some at a time.
        """
        cells, k, most = self.cells, self.k, self.most
        begin, end = cells.slots_of(first, last)
        numbers = cells.numbers.read(begin, end)
        by_number = np.argsort(numbers)
        places = cells.points.read(begin, end)[by_number]
        count = len(numbers)
        tree = build_tree(places, ignore_progress, scale=cells.scale)
        places /= cells.scale
        nearest = np.zeros((count, k), np.int32)
        tile = TilePoints(cells, first, last, places, numbers[by_number], begin + by_number, tree.indices[:count], nearest)
        bounds = np.full(count, np.inf)

        def search(start: int, stop: int) -> None:
            rows, squared = search_leaves(tree, start, stop, nearest)
            bounds[rows] = squared.max(axis=1)
            inside(rows, squared)

        if count <= k:  # then the points of the tile are looked at like all others
            first = last = 0
        else:
            in_parallel(search, leaf_ranges(tree, k), ignore_progress)
        asking = np.flatnonzero(reaching_out(places[tile.index], bounds, cells.tree, first, last))
        at = 0
        while at < len(asking):
            rows = asking[at : at + max(int(_ASKING * most), _AT_ONCE)]
            asked = cells_within(places[tile.index[rows]], bounds[rows], cells.tree, first, last, k, most=_ASKED * most)
            rows = rows[: len(asked[0]) - 1]
            theirs = _own_nearest(tile, rows)
            _ask_around(tile, rows, asked, theirs, most)
            around(tile, rows, theirs)
            at += len(rows)
        return tile


def _own_nearest(tile: TilePoints, asking: NDArray[np.intp]) -> Nearest:
    """The neighbours in the tile of the points that ask, by squared distance, then by number; none if it has too few points."""
    shape = len(asking), tile.nearest.shape[1]
    nearest = Nearest(np.full(shape, np.inf), np.full(shape, np.iinfo(np.int64).max), np.full(shape, -1))
    for first in range(0, len(asking) if len(tile) > shape[1] else 0, _AT_ONCE):
        rows = slice(first, first + _AT_ONCE)
        theirs = tile.index[tile.nearest[asking[rows]]]
        apart = tile.places[theirs] - tile.places[tile.index[asking[rows]]][:, None]
        x, y, z = apart[..., 0], apart[..., 1], apart[..., 2]
        squared = x * x + y * y + z * z
        order = np.lexsort((theirs, squared), axis=1)
        theirs = np.take_along_axis(theirs, order, axis=1)
        nearest.squared[rows] = np.take_along_axis(squared, order, axis=1)
        nearest.numbers[rows], nearest.slots[rows] = tile.numbers[theirs], tile.slots[theirs]
    return nearest


def _ask_around(
    tile: TilePoints, asking: NDArray[np.intp], asked: tuple[Longs, NDArray[np.int32]], nearest: Nearest, most: int
) -> None:
    """Put the nearer points of the cells that were asked for among the nearest."""
    cells = tile.cells
    places, names = tile.places[tile.index[asking]], tile.numbers[tile.index[asking]]
    largest = max(int(_AROUND * most), _LEAST_AROUND)
    size = max(1, len(places) // 64)

    def offer(rows: Longs, offered: tuple[Floats, Longs, Longs], start: int) -> None:
        part, lists = slice(start, start + size), (asked[0][start : start + size + 1], asked[1])
        offer_cells(places[part], names[part], nearest.of(part), lists, cells.tree, rows, offered)

    wanted = np.unique(asked[1]).astype(np.int64)
    sizes = np.cumsum(cells.starts[wanted + 1] - cells.starts[wanted])
    at = 0
    while at < len(wanted):
        stop = max(int(np.searchsorted(sizes, (sizes[at - 1] if at else 0) + largest, "right")), at + 1)
        there, numbers, slots, rows = cells.read(wanted[at:stop])
        in_parallel(offer, [(rows, (there, numbers, slots), start) for start in range(0, len(places), size)], ignore_progress)
        at = stop


@dataclass(frozen=True, eq=False)
class Links:
    """The links of the points of a tile: to rows, of the points themselves and of those outside of the tile, or `NO_LINK`."""

    begin: int  # the first slot
    end: int  # the slot after the last
    outside: Longs  # (o,) slots of the points outside
    rows: NDArray[np.int32]  # (n, k)

    @classmethod
    def read(cls, column: Column, cells: Cells, first: int, last: int) -> Links:
        """Those of the points in the cells from `first` to before `last`, whose slots are in a column."""
        begin, end = cells.slots_of(first, last)
        slots = column.read(begin, end).reshape(end - begin, -1)
        inside = (slots >= begin) & (slots < end)
        outside = np.unique(slots[~inside & (slots != NO_LINK)])
        rows = np.where(inside, slots - begin, len(slots) + np.searchsorted(outside, slots))
        rows[slots == NO_LINK] = NO_LINK
        return cls(begin, end, outside, rows.astype(np.int32))

    def slots(self) -> Longs:
        """(n, k) the slots of the points that links lead to, or `NO_LINK`."""
        every = np.concatenate([np.arange(self.begin, self.end), self.outside, [NO_LINK]])
        return np.asarray(every[self.rows])  # the last one is that of `NO_LINK`

    def of_own(self, column: Column) -> NDArray[Any]:
        """The values of the points."""
        return column.read(self.begin, self.end)

    def of_all(self, column: Column) -> NDArray[Any]:
        """The values of the points, and of those outside."""
        return np.concatenate([self.of_own(column), column.gather(self.outside)])

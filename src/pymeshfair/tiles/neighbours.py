"""The nearest neighbours of the points of a tile, in the tile and in the cells around it; the tasks of a step."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..filters.execution import ignore_progress, in_parallel
from ..filters.mesh import Floats, Ints, Longs
from ..filters.neighbours import Nearest, build_tree, cells_within, leaf_ranges, offer_cells, reaching_out, search_leaves
from ..filters.outliers import standard_distances
from .cells import Cells, Column, Ranges, Results
from .workers import Tasks

#: points of the cells around a tile that are in memory at once, as a share of the points of a tile, and at least
_AROUND, _LEAST_AROUND = 0.125, 1 << 15
#: points that ask at once, and the cells that these may ask for in all, both as shares of the points of a tile
_ASKING, _ASKED = 0.125, 8
#: points whose neighbours in the tile are put into order at once
_AT_ONCE = 4096


@dataclass(frozen=True, eq=False)
class TilePoints:
    """The points of a tile with the k nearest of each, in the order of a tree."""

    cells: Cells  # the cloud
    first: int  # the first cell of the tile
    last: int  # the cell after its last
    places: Floats  # (n, 3) coordinates in the unit of trees
    numbers: Longs  # (n,) in the input
    slots: Longs  # (n,) where they are stored
    nearest: Ints  # (n, k) rows that are nearest to each in the tile; 0 if it has too few points
    distances: Floats  # (n,) standard distances of the k nearest: of those in the tile, until `ask_around` has been through
    reaches: Floats  # (n,) squared distance of the farthest of them

    @classmethod
    def of(cls, cells: Cells, first: int, last: int, k: int) -> TilePoints:
        """The points in the cells from `first` to before `last`, compared with each other."""
        begin, end = cells.slots_of(first, last)
        numbers = cells.numbers.read(begin, end)
        count, order = len(numbers), np.argsort(numbers)
        places = cells.points.read(begin, end)[order]
        tree = build_tree(places, ignore_progress, scale=cells.scale)
        by_tree = tree.indices[:count]
        nearest, distances, reaches = np.zeros((count, k), np.int32), np.empty(count), np.full(count, np.inf)

        def search(start: int, stop: int) -> None:
            rows, squared = search_leaves(tree, start, stop, nearest)
            distances[rows], reaches[rows] = standard_distances(squared), squared.max(axis=1)

        if count > k:
            in_parallel(search, leaf_ranges(tree, k), ignore_progress)
        order = order[by_tree]
        places = places[by_tree] / cells.scale
        return cls(cells, first, last, places, numbers[order], begin + order, nearest, distances, reaches)

    @property
    def begin(self) -> int:
        """The first slot."""
        return int(self.cells.starts[self.first])

    def by_slot(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values of the points in the order of the slots."""
        ordered = np.empty_like(values)
        ordered[self.slots - self.begin] = values
        return ordered

    def ask_around(self, most: int) -> Iterator[tuple[NDArray[np.intp], Nearest]]:
        """Of the points that may have neighbours in other tiles, some at a time, the rows and the nearest in the whole cloud.

        A tile has at most `most` points.
        """
        k = self.nearest.shape[1]
        # Without enough points of its own the tile is looked at like all others.
        tile = (self.first, self.last) if len(self.slots) > k else (0, 0)
        asking = np.flatnonzero(reaching_out(self.places, self.reaches, self.cells.tree, *tile))
        at = 0
        while at < len(asking):
            rows = asking[at : at + max(int(_ASKING * most), _AT_ONCE)]
            asked = cells_within(self.places[rows], self.reaches[rows], self.cells.tree, *tile, k, most=_ASKED * most)
            rows = rows[: len(asked[0]) - 1]
            nearest = self._nearest_of(rows)
            self._look_into(asked, rows, nearest, most)
            self.distances[rows], self.reaches[rows] = standard_distances(nearest.squared), nearest.squared[:, -1]
            yield rows, nearest
            at += len(rows)

    def _nearest_of(self, rows: NDArray[np.intp]) -> Nearest:
        """The nearest in the tile, by squared distance, then by number; none if it has too few points."""
        shape = len(rows), self.nearest.shape[1]
        nearest = Nearest(np.full(shape, np.inf), np.full(shape, np.iinfo(np.int64).max), np.full(shape, -1))
        for first in range(0, len(rows) if len(self.slots) > shape[1] else 0, _AT_ONCE):
            some = rows[first : first + _AT_ONCE]
            theirs = self.nearest[some]
            apart = self.places[theirs] - self.places[some][:, None]
            x, y, z = apart[..., 0], apart[..., 1], apart[..., 2]
            squared = x * x + y * y + z * z
            order = np.lexsort((self.numbers[theirs], squared), axis=1)
            theirs = np.take_along_axis(theirs, order, axis=1)
            part = nearest.of(slice(first, first + _AT_ONCE))
            part.squared[:] = np.take_along_axis(squared, order, axis=1)
            part.numbers[:], part.slots[:] = self.numbers[theirs], self.slots[theirs]
        return nearest

    def _look_into(self, asked: tuple[Longs, Ints], rows: NDArray[np.intp], nearest: Nearest, most: int) -> None:
        """Put the nearer points of the cells that were asked for among the nearest."""
        cells = self.cells
        places, numbers = self.places[rows], self.numbers[rows]
        largest, size = max(int(_AROUND * most), _LEAST_AROUND), max(1, len(places) // 64)

        def offer(spans: Longs, offered: tuple[Floats, Longs, Longs], start: int) -> None:
            part, lists = slice(start, start + size), (asked[0][start : start + size + 1], asked[1])
            offer_cells(places[part], numbers[part], nearest.of(part), lists, cells.tree, spans, offered)

        wanted = np.unique(asked[1]).astype(np.int64)
        sizes = cells.starts[wanted + 1] - cells.starts[wanted]
        ends = np.cumsum(sizes)
        at = 0
        while at < len(wanted):
            read = ends[at] - sizes[at]
            stop = max(int(np.searchsorted(ends, read + largest, "right")), at + 1)
            slots = cells.ranges_of(wanted[at:stop])
            offered = (
                np.concatenate([cells.points.read(*r) for r in slots]) / cells.scale,
                np.concatenate([cells.numbers.read(*r) for r in slots]),
                np.concatenate([np.arange(*r) for r in slots]),
            )
            spans = np.zeros((len(cells.starts) - 1, 2), np.int64)  # where the points of each cell begin and end among these
            spans[wanted[at:stop], 0], spans[wanted[at:stop], 1] = (ends - sizes)[at:stop] - read, ends[at:stop] - read
            in_parallel(offer, [(spans, offered, start) for start in range(0, len(places), size)], ignore_progress)
            at = stop


@dataclass(frozen=True)
class PointTiles:
    """The tasks of a step on a cloud in cells; each may be done twice."""

    cells: Cells  # the cloud
    values: Mapping[str, Any]  # the parameters of the step
    k: int  # neighbours of a point
    most: int  # points of a tile

    result: ClassVar[tuple[str, int]]  # of a point, the type and how many numbers

    def do(self, tasks: Tasks, tiles: Ranges, size: int, progress: Callable[[float], None]) -> None:
        """All tasks, after which `results` has those of every tile; `size` rows of a file may be in memory."""
        raise NotImplementedError

    @property
    def results(self) -> Results:
        """The results, those of each tile in the rows of its slots."""
        return Results(Column(self.cells.folder / "results", *self.result))

    @property
    def links(self) -> Column:
        """The slots of the neighbours."""
        return Column(self.cells.folder / "links", "<i8", self.k)

    def amend(self, first: int, last: int, numbers: Longs, values: Any) -> None:
        """Give some points of a tile, which has its results, others."""
        begin, end = self.cells.slots_of(first, last)
        whole = self.results.values.read(begin, end)
        whole[np.searchsorted(self.results.numbers.read(begin, end), numbers)] = values
        self.results.values.write(begin, whole)

    def aside(self, first: int) -> Path:
        """The file of what the tile that begins with a cell leaves to a later task."""
        return self.cells.folder / f"aside-{first}.npz"

    def all_aside(self, tiles: Ranges, *names: str) -> Iterator[NDArray[Any]]:
        """The arrays of these names that the tiles have left, those of all tiles one after another."""
        archives = []
        for first, _ in tiles:
            with np.load(self.aside(first)) as one:
                archives.append([one[name] for name in names])
        return (np.concatenate(values) for values in zip(*archives, strict=True))

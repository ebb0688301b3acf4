"""LoOP by tiles: neighbours in the tile and in the cells around it, then the comparison with theirs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..filters.execution import ignore_progress, in_parallel
from ..filters.neighbours import (
    LEAF,
    Nearest,
    build_tree,
    cells_within,
    leaf_ranges,
    offer_cells,
    reaching_out,
    search_leaves,
)
from ..filters.outliers import compare, compare_rows, standard_distances
from .by_number import Part
from .cells import Cells
from .columns import Column
from .division import Floats, Longs

#: points of the cells around a tile that are in memory at once, as a share of the points of a tile
_AROUND = 0.125
#: and at least
_LEAST_AROUND = 1 << 15
#: points that ask at once, and the cells that these may ask for in all, both as shares of the points of a tile
_ASKING, _ASKED = 0.125, 8
#: points whose neighbours in the tile are put into order at once
_AT_ONCE = 4096


@dataclass(frozen=True)
class OutlierTiles:
    """The tasks of LoOP on a cloud in cells; each may be done twice.

    Attributes:
        cells: the cloud.
        k: neighbours.
        tile: points of a tile.
    """

    cells: Cells
    k: int
    tile: int

    @property
    def distances(self) -> Column:
        """The standard distance by slot, in the unit of trees."""
        return Column(self.cells.folder / "distances", "<f8")

    def part(self, first: int) -> Part:
        """The factors of the tile that begins with the cell `first`."""
        return Part(self.cells.folder / f"factors-{first}", "<f8")

    def _asking(self, first: int) -> Path:
        return self.cells.folder / f"asking-{first}.npz"

    def find(self, first: int, last: int) -> None:
        """The standard distances of the points in the cells from `first` to before `last`; the factors of those far inside."""
        cells, k = self.cells, self.k
        begin, end = int(cells.starts[first]), int(cells.starts[last])
        numbers = cells.numbers.read(begin, end)
        by_number = np.argsort(numbers)
        numbers = numbers[by_number]
        places = cells.points.read(begin, end)[by_number]
        count = len(numbers)
        tree = build_tree(places, ignore_progress, scale=cells.scale)
        places /= cells.scale
        index = tree.indices[:count]
        distances, bounds = np.empty(count), np.full(count, np.inf)
        positions = np.zeros((count, k), np.int32)

        def search(start: int, stop: int) -> None:
            found, squared = search_leaves(tree, start, stop, k)
            rows = slice(start * LEAF, start * LEAF + len(found))
            positions[rows], distances[rows], bounds[rows] = found, standard_distances(squared), squared.max(axis=1)

        if count > k:
            in_parallel(search, leaf_ranges(tree, k), ignore_progress)
        asking = np.flatnonzero(reaching_out(places[index], bounds, cells.tree, first, last))
        own = (0, 0) if count <= k else (first, last)  # with so few points, those of the tile are looked at like all others
        asked_slots: Longs = np.empty((len(asking), k), np.int64)
        at = 0
        while at < len(asking):
            rows = asking[at : at + max(int(_ASKING * self.tile), _AT_ONCE)]
            asked = cells_within(places[index[rows]], bounds[rows], cells.tree, *own, k, most=_ASKED * self.tile)
            rows = rows[: len(asked[0]) - 1]
            nearest = self._own_nearest(rows, places, numbers, index, positions, begin + by_number, few=count <= k)
            self._ask_around(places[index[rows]], numbers[index[rows]], asked, nearest)
            distances[rows], asked_slots[at : at + len(rows)] = standard_distances(nearest.squared), nearest.slots
            at += len(rows)

        factors = np.full(count, np.nan)
        inside = np.ones(count, np.bool_)
        inside[asking] = False
        if inside.any():
            compare(distances, positions, 0, count, factors)
            factors[asking] = np.nan
        by_index = np.empty(count)
        by_index[index] = distances
        by_slot = np.empty(count)
        by_slot[by_number] = by_index
        self.distances.write(begin, by_slot)
        by_index[index] = factors
        self.part(first).write(numbers, by_index)
        np.savez(self._asking(first), rows=index[asking], own=distances[asking], slots=asked_slots)

    def _own_nearest(
        self,
        asking: NDArray[np.intp],
        places: Floats,
        numbers: Longs,
        index: NDArray[np.int32],
        positions: NDArray[np.int32],
        slots: Longs,
        *,
        few: bool,
    ) -> Nearest:
        """What those who ask have found in their tile, by squared distance, then by number."""
        shape = len(asking), self.k
        if few:
            return Nearest(np.full(shape, np.inf), np.full(shape, np.iinfo(np.int64).max), np.full(shape, -1))
        nearest = Nearest(np.empty(shape), np.empty(shape, np.int64), np.empty(shape, np.int64))
        for first in range(0, len(asking), _AT_ONCE):
            rows = slice(first, first + _AT_ONCE)
            theirs = index[positions[asking[rows]]]
            apart = places[theirs] - places[index[asking[rows]]][:, None]
            x, y, z = apart[..., 0], apart[..., 1], apart[..., 2]
            squared = x * x + y * y + z * z
            order = np.lexsort((theirs, squared), axis=1)
            theirs = np.take_along_axis(theirs, order, axis=1)
            nearest.squared[rows] = np.take_along_axis(squared, order, axis=1)
            nearest.numbers[rows], nearest.slots[rows] = numbers[theirs], slots[theirs]
        return nearest

    def _ask_around(self, places: Floats, names: Longs, asked: tuple[Longs, NDArray[np.int32]], nearest: Nearest) -> None:
        """Put the nearer points of the cells that were asked for among the nearest; `names` are the numbers of those who ask."""
        cells = self.cells
        most = max(int(_AROUND * self.tile), _LEAST_AROUND)
        wanted = np.unique(asked[1]).astype(np.int64)
        sizes = np.cumsum(cells.starts[wanted + 1] - cells.starts[wanted])
        at = 0
        while at < len(wanted):
            stop = max(int(np.searchsorted(sizes, (sizes[at - 1] if at else 0) + most, "right")), at + 1)
            there, numbers, slots, rows = cells.read(wanted[at:stop])
            self._offer(places, names, nearest, asked, rows, (there, numbers, slots))
            at = stop

    def _offer(
        self,
        places: Floats,
        names: Longs,
        nearest: Nearest,
        asked: tuple[Longs, NDArray[np.int32]],
        rows: Longs,
        offered: tuple[Floats, Longs, Longs],
    ) -> None:
        def offer(start: int, stop: int) -> None:
            part, lists = slice(start, stop), (asked[0][start : stop + 1], asked[1])
            offer_cells(places[part], names[part], nearest.of(part), lists, self.cells.tree, rows, offered)

        size = max(1, len(places) // 64)
        in_parallel(offer, [(at, min(at + size, len(places))) for at in range(0, len(places), size)], ignore_progress)

    def finish(self, first: int) -> None:
        """The factors of those points of a tile that had asked around; every tile must have been through `find`."""
        with np.load(self._asking(first)) as found:
            rows, own, slots = found["rows"], found["own"], found["slots"]
        if len(rows):
            self.part(first).replace(rows, compare_rows(own, self.distances.gather(slots)))

"""Stray points by tiles: neighbours, links, points that join the surface, and parts that reach through several tiles.

Each pass reads what the one before has written of the points around a tile, so that every tile must have been through it.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..filters import outliers
from ..filters.execution import part_of
from ..filters.libraries import sparse
from ..filters.neighbours import Nearest
from .cells import Ranges
from .columns import Column, Stored, joined
from .division import Floats, Longs
from .neighbours import Links, PointTiles, TilePoints
from .workers import Tasks


class StrayTiles(PointTiles):
    """The tasks of stray points; the results are which points are stray."""

    result = "u1", 1

    spacings, _thicknesses, _reaches = Stored("<f8"), Stored("<f8"), Stored("<f8")  # by slot, in the unit of trees
    _lasts = Stored("<i8")
    _parts = Stored("<i8")  # the lowest slot of the part of a point in its tile

    @property
    def _rule(self) -> outliers.StrayRule:
        """The test for stray points."""
        return outliers.StrayRule(self.k, self.values["sparseness"], self.values["smallest_part"])

    def _chosen(self, joined: int) -> Column:
        return Column(self.cells.folder / f"chosen-{joined}", "u1")

    def do(self, tasks: Tasks, tiles: Ranges, size: int, progress: Callable[[float], None]) -> None:
        tasks.run(self.create)
        tasks.map(self.find, tiles, part_of(progress, 0.0, 0.7))
        median = tasks.run(self.median, size)
        tasks.map(self.link, [(median, *tile) for tile in tiles], part_of(progress, 0.7, 0.8))
        for number in range(1, outliers.JOINED + 1):
            tasks.map(self.join, [(number, *tile) for tile in tiles])
        tasks.map(self.connect, tiles, part_of(progress, 0.85, 0.95))
        stray = tasks.run(self.across, tiles)
        tasks.map(self.finish, [(stray, *tile) for tile in tiles], part_of(progress, 0.95, 1.0))

    def create(self) -> None:
        """Make the files."""
        for column in (self.spacings, self._thicknesses, self._reaches, self._lasts, self.links(), self._parts):
            column.create(self.cells.count)
        for number in range(outliers.JOINED + 1):
            self._chosen(number).create(self.cells.count)

    def find(self, first: int, last: int) -> None:
        """The neighbours of the points in the cells from `first` to before `last`, and what these say of a surface."""
        count = int(self.cells.starts[last] - self.cells.starts[first])
        spacing, reach = np.empty(count), np.empty(count)
        asked: list[tuple[NDArray[np.intp], Nearest, Floats]] = []

        def inside(rows: slice, squared: Floats) -> None:
            spacing[rows], reach[rows] = outliers.standard_distances(squared), squared.max(axis=1)

        def around(tile: TilePoints, rows: NDArray[np.intp], nearest: Nearest) -> None:
            spacing[rows], reach[rows] = outliers.standard_distances(nearest.squared), nearest.squared[:, -1]
            asked.append((rows, nearest, self._thicknesses_of(tile.places[tile.index[rows]], nearest)))

        tile = self.search(first, last, inside, around)
        numbers = tile.numbers[tile.index]
        thickness = outliers.thicknesses(tile.places[tile.index], numbers, tile.nearest)
        slots, lasts = tile.slots[tile.index][tile.nearest], numbers[tile.nearest[:, -1]]
        for rows, nearest, thick in asked:
            slots[rows], lasts[rows], thickness[rows] = nearest.slots, nearest.numbers[:, -1], thick
        self.links().write(tile.begin, tile.by_slot(slots))
        self._lasts.write(tile.begin, tile.by_slot(lasts))
        for column, values in ((self.spacings, spacing), (self._reaches, reach), (self._thicknesses, thickness)):
            column.write(tile.begin, tile.by_slot(values))

    def _thicknesses_of(self, places: Floats, nearest: Nearest) -> Floats:
        """Those of points whose neighbours are in any tile."""
        count, k = nearest.slots.shape
        around = self.cells.points.gather(nearest.slots).reshape(-1, 3) / self.cells.scale
        rows = np.arange(count * (k + 1), dtype=np.int32)  # they are in order
        return outliers.thicknesses(np.concatenate([places, around]), rows.astype(np.int64), rows[count:].reshape(count, k))

    def median(self, size: int) -> float:
        """The lower median of the spacings, `size` of which are read at a time; each pass finds 16 of its 64 bits."""
        rank, prefix = (self.cells.count - 1) // 2, 0
        for shift in (48, 32, 16, 0):
            counts = np.zeros(1 << 16, np.int64)
            for spacings in self.spacings.slices(size):
                bits = spacings.view(np.uint64)  # numbers of at least 0 have the order of their bits
                here = (bits >> np.uint64(shift + 16) if shift < 48 else bits >> np.uint64(63)) == prefix
                counts += np.bincount(((bits[here] >> np.uint64(shift)) & np.uint64(0xFFFF)).astype(np.int64), minlength=1 << 16)
            digit = int(np.searchsorted(np.cumsum(counts), rank, "right"))
            rank -= int(counts[:digit].sum())
            prefix = prefix << 16 | digit
        return float(np.array([prefix], np.uint64).view(np.float64)[0])

    def link(self, median: float, first: int, last: int) -> None:
        """Which neighbours are linked, and which points are on a surface by themselves; `median` is that of the spacings."""
        links = Links.read(self.links(), self.cells, first, last)
        places = links.of_all(self.cells.points) / self.cells.scale
        numbers, reaches, lasts = (links.of_all(values) for values in (self.cells.numbers, self._reaches, self._lasts))
        outliers.cut_links(places, numbers, links.rows, reaches, lasts)
        self.links().write(links.begin, links.slots())
        counts = outliers.linked_to(links.rows, np.ones(len(places), np.bool_))
        chosen = self._rule.on_surface(links.of_own(self.spacings), median, links.of_own(self._thicknesses), counts)
        self._chosen(0).write(links.begin, chosen)

    def join(self, number: int, first: int, last: int) -> None:
        """Which points have joined them, for the first time, the second, and so on."""
        links = Links.read(self.links(), self.cells, first, last)
        chosen = links.of_all(self._chosen(number - 1)) > 0
        more = chosen[: len(links.rows)] | self._rule.is_joined(outliers.linked_to(links.rows, chosen))
        self._chosen(number).write(links.begin, more)

    def connect(self, first: int, last: int) -> None:
        """The parts of the points; those that are linked to points of other tiles are left to `across`."""
        links = Links.read(self.links(), self.cells, first, last)
        chosen = links.of_all(self._chosen(outliers.JOINED)) > 0
        count = len(links.rows)
        parts = outliers.linked_parts(links.rows, chosen)
        self._parts.write(links.begin, parts + links.begin)
        sizes, sums = outliers.part_sums(parts, links.of_own(self._thicknesses), count)
        stray = ~chosen[:count] | self._rule.too_small(sizes, sums)[parts]
        rows, at = np.nonzero(links.rows >= count)
        others = links.rows[rows, at].astype(np.int64)
        both = chosen[rows] & chosen[others]
        own, others = parts[rows[both]], links.outside[others[both] - count]
        open_ = np.unique(own)
        stray[np.isin(parts, open_) & chosen[:count]] = False
        np.savez(
            self.aside(first),
            parts=open_ + links.begin,
            sizes=sizes[open_],
            sums=sums[open_],
            own=own + links.begin,
            others=others,
        )
        self.part(first).write(links.of_own(self.cells.numbers), stray)

    def across(self, tiles: list[tuple[int, int]]) -> Longs:
        """The parts that are stray though they reach through several tiles, ascending."""
        names = ("parts", "sizes", "sums", "own", "others")
        parts, sizes, sums, own, others = joined((self.aside(first) for first, _ in tiles), names)
        ends = np.searchsorted(parts, own), np.searchsorted(parts, self._parts.gather(others))
        graph = sparse.coo_matrix((np.ones(len(own), np.int8), ends), shape=(len(parts), len(parts)))
        count, whole = sparse.csgraph.connected_components(graph, directed=False)
        # Sums of whole numbers below 2^53, which are exact.
        totals = (np.bincount(whole, values, minlength=count).astype(np.int64) for values in (sizes, sums))
        stray: Longs = parts[self._rule.too_small(*totals)[whole]]
        return stray

    def finish(self, stray: Longs, first: int, last: int) -> None:
        """Mark the points of the parts that `across` has found to be stray."""
        begin, end = self.cells.slots_of(first, last)
        order = np.argsort(self.cells.numbers.read(begin, end))
        rows = np.flatnonzero(np.isin(self._parts.read(begin, end)[order], stray))
        self.part(first).replace(rows, np.ones(len(rows), np.uint8))

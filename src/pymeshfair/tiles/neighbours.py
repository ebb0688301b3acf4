"""Steps on clouds by neighbours in any tile: the nearest of each point, and stray points and normals by links to them.

Neighbours are sought in the tile and in the cells around it. Each pass reads what the one before has written of the points around
a tile, so that every tile must have been through it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..filters import outliers
from ..filters.denoising import normals_of, smoothed_directions
from ..filters.execution import ignore_progress, in_parallel, part_of
from ..filters.libraries import sparse
from ..filters.mesh import Floats, Ints, Longs
from ..filters.neighbours import Nearest, build_tree, cells_within, leaf_ranges, offer_cells, reaching_out, search_leaves
from .cells import Cells, Column, Part, Ranges, Results, Stored
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
            distances[rows], reaches[rows] = outliers.standard_distances(squared), squared.max(axis=1)

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
            self.distances[rows], self.reaches[rows] = outliers.standard_distances(nearest.squared), nearest.squared[:, -1]
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


@dataclass(frozen=True, eq=False)
class Links(Part):
    """The links of the points of a tile."""

    to: Ints  # (n, k) the place of each neighbour among these and those outside, or `NO_LINK`

    @classmethod
    def of(cls, step: PointTiles, first: int, last: int) -> Links:
        """Those of the points in the cells from `first` to before `last`."""
        begin, end = step.cells.slots_of(first, last)
        slots = step.links.read(begin, end).reshape(end - begin, -1)
        part = Part(begin, end, np.unique(slots[((slots < begin) | (slots >= end)) & (slots != outliers.NO_LINK)]))
        return cls(begin, end, part.outside, np.where(slots == outliers.NO_LINK, slots, part.rows(slots)).astype(np.int32))


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
        tasks.map(self.find, tiles, part_of(progress, 0.0, 0.7))
        median = tasks.run(self.median, size)
        tasks.map(self.link, [(median, *tile) for tile in tiles], part_of(progress, 0.7, 0.8))
        for number in range(1, outliers.JOINED + 1):
            tasks.map(self.join, [(number, *tile) for tile in tiles])
        tasks.map(self.connect, tiles, part_of(progress, 0.85, 0.95))
        stray = tasks.run(self.across, tiles)
        tasks.map(self.finish, [(stray, *tile) for tile in tiles], part_of(progress, 0.95, 1.0))

    def find(self, first: int, last: int) -> None:
        """The neighbours of the points in the cells from `first` to before `last`, and what these say of a surface."""
        tile = TilePoints.of(self.cells, first, last, self.k)
        thickness = outliers.thicknesses(tile.places, tile.numbers, tile.nearest)
        slots, lasts = tile.slots[tile.nearest], tile.numbers[tile.nearest[:, -1]]
        for rows, nearest in tile.ask_around(self.most):
            slots[rows], lasts[rows] = nearest.slots, nearest.numbers[:, -1]
            thickness[rows] = self._thicknesses_of(tile.places[rows], nearest)
        for column, values in (
            (self.links, slots),
            (self._lasts, lasts),
            (self.spacings, tile.distances),
            (self._reaches, tile.reaches),
            (self._thicknesses, thickness),
        ):
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
        links = Links.of(self, first, last)
        places = links.of_all(self.cells.points) / self.cells.scale
        numbers, reaches, lasts = (links.of_all(values) for values in (self.cells.numbers, self._reaches, self._lasts))
        outliers.cut_links(places, numbers, links.to, reaches, lasts)
        self.links.write(links.begin, np.append(links.slots, outliers.NO_LINK)[links.to])  # the last one is that of `NO_LINK`
        counts = outliers.linked_to(links.to, np.ones(len(places), np.bool_))
        chosen = self._rule.on_surface(links.of_own(self.spacings), median, links.of_own(self._thicknesses), counts)
        self._chosen(0).write(links.begin, chosen)

    def join(self, number: int, first: int, last: int) -> None:
        """Which points have joined them, for the first time, the second, and so on."""
        links = Links.of(self, first, last)
        chosen = links.of_all(self._chosen(number - 1)) > 0
        more = chosen[: len(links.to)] | self._rule.is_joined(outliers.linked_to(links.to, chosen))
        self._chosen(number).write(links.begin, more)

    def connect(self, first: int, last: int) -> None:
        """The parts of the points; those that are linked to points of other tiles are left to `across`."""
        links = Links.of(self, first, last)
        chosen = links.of_all(self._chosen(outliers.JOINED)) > 0
        count = len(links.to)
        parts = outliers.linked_parts(links.to, chosen)
        self._parts.write(links.begin, parts + links.begin)
        sizes, sums = outliers.part_sums(parts, links.of_own(self._thicknesses), count)
        rows, at = np.nonzero(links.to >= count)
        others = links.to[rows, at].astype(np.int64)
        both = chosen[rows] & chosen[others]
        own, others = parts[rows[both]], links.outside[others[both] - count]
        open_ = np.unique(own)
        names, own = open_ + links.begin, own + links.begin
        np.savez(self.aside(first), parts=names, sizes=sizes[open_], sums=sums[open_], own=own, others=others)
        small = self._rule.too_small(sizes, sums)
        small[open_] = False
        self.results.write(links.begin, links.of_own(self.cells.numbers), ~chosen[:count] | small[parts])

    def across(self, tiles: Ranges) -> Longs:
        """The parts that are stray though they reach through several tiles, ascending."""
        parts, sizes, sums, own, others = self.all_aside(tiles, "parts", "sizes", "sums", "own", "others")
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
        found = np.isin(self._parts.read(begin, end), stray)
        self.amend(first, last, self.cells.numbers.read(begin, end)[found], 1)


class NormalTiles(PointTiles):
    """The tasks of Compute normals for point sets; the results are the normals, and links are in the order of the numbers.

    Planes through neighbours, smoothed, and turned alike or towards a view point. Directions have the same bits however the cloud
    is cut. Where no view point says the side, it spreads from point to point in a tile and then from tile to tile, each time
    first where normals agree most.
    """

    result = "<f8", 3

    _signs = Stored("i1")  # the side on which each normal is, as seen from the first of its part
    _parts = Stored("<i8")  # the first slot of the linked points of the tile that a point is among

    @property
    def iterations(self) -> int:
        """The number of smoothing iterations of normals."""
        return int(self.values["smoothiter"])

    def directions(self, iteration: int) -> Column:
        """The normals after so many times of smoothing, by slot."""
        return Column(self.cells.folder / f"directions-{iteration}", "<f8", 3)

    def do(self, tasks: Tasks, tiles: Ranges, size: int, progress: Callable[[float], None]) -> None:
        tasks.map(self.find, tiles, part_of(progress, 0.0, 0.4))
        tasks.map(self.fit, tiles, part_of(progress, 0.4, 0.6))
        for number in range(1, self.iterations + 1):
            tasks.map(self.smooth, [(number, *tile) for tile in tiles])
            tasks.run(self.forget, number - 1)
        over = np.empty(0, np.int64)
        if not self.values["flipflag"]:
            tasks.map(self.orient, tiles, part_of(progress, 0.7, 0.85))
            tasks.map(self.meet, tiles, part_of(progress, 0.85, 0.95))
            over = tasks.run(self.across, tiles)
        tasks.map(self.finish, [(over, *tile) for tile in tiles], part_of(progress, 0.95, 1.0))

    def find(self, first: int, last: int) -> None:
        """The neighbours of the points in the cells from `first` to before `last`."""
        tile = TilePoints.of(self.cells, first, last, self.k)
        slots = _by_number(tile.numbers[tile.nearest], tile.slots[tile.nearest])
        for rows, nearest in tile.ask_around(self.most):
            slots[rows] = _by_number(nearest.numbers, nearest.slots)
        self.links.write(tile.begin, tile.by_slot(slots))

    def fit(self, first: int, last: int) -> None:
        """The planes through them."""
        links = Links.of(self, first, last)
        self.directions(0).write(links.begin, normals_of(links.of_all(self.cells.points) / self.cells.scale, links.to))

    def smooth(self, iteration: int, first: int, last: int) -> None:
        """The mean of each normal and those of its neighbours, on its side."""
        links = Links.of(self, first, last)
        before = links.of_all(self.directions(iteration - 1))
        self.directions(iteration).write(links.begin, smoothed_directions(before, links.to))

    def forget(self, iteration: int) -> None:
        """Remove normals that have been smoothed."""
        self.directions(iteration).path.unlink(missing_ok=True)

    def orient(self, first: int, last: int) -> None:
        """Turn the normals of a tile alike, along the links across which they agree most."""
        links = Links.of(self, first, last)
        own = links.of_own(self.directions(self.iterations))
        count = len(own)
        rows, at = np.nonzero((links.to < count) & (links.to != np.arange(count)[:, None]))
        others = links.to[rows, at]
        agree = np.einsum("ij,ij->i", own[rows], own[others])
        parts, signs = _turned_alike(count, rows, others, agree)
        self._signs.write(links.begin, signs)
        self._parts.write(links.begin, parts + links.begin)

    def meet(self, first: int, last: int) -> None:
        """The agreement of the parts of a tile with those of others, and the upward component of each."""
        links = Links.of(self, first, last)
        signed = links.of_all(self.directions(self.iterations)) * links.of_all(self._signs)[:, None]
        parts = links.of_all(self._parts)
        rows, at = np.nonzero(links.to >= len(links.to))
        others = links.to[rows, at]
        pairs, at_pair = np.unique(np.stack([parts[rows], parts[others]], axis=1), axis=0, return_inverse=True)
        votes = np.bincount(at_pair.ravel(), np.einsum("ij,ij->i", signed[rows], signed[others]), minlength=len(pairs))
        names, at_name = np.unique(parts[: len(links.to)], return_inverse=True)
        ups = np.bincount(at_name, signed[: len(links.to), 2], minlength=len(names))
        np.savez(self.aside(first), parts=names, ups=ups, pairs=pairs, votes=votes)

    def across(self, tiles: Ranges) -> Longs:
        """The parts that are to be turned over, ascending, so that all agree; what belongs together looks up on the whole."""
        parts, ups, pairs, votes = self.all_aside(tiles, "parts", "ups", "pairs", "votes")
        ends = np.searchsorted(parts, pairs)
        both, at = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)  # seen from either side
        votes = np.bincount(at.ravel(), votes, minlength=len(both))
        whole, signs = _turned_alike(len(parts), both[:, 0], both[:, 1], votes / (np.abs(votes).max(initial=0.0) or 1.0))
        up = np.bincount(whole, signs * ups, minlength=len(parts))
        signs = np.where(up[whole] < 0.0, -signs, signs)
        over: Longs = parts[signs < 0]
        return over

    def finish(self, over: Longs, first: int, last: int) -> None:
        """The normals, by number, the parts in `over` turned over; with a view point, all turned to it."""
        begin, end = self.cells.slots_of(first, last)
        normals = self.directions(self.iterations).read(begin, end)
        if self.values["flipflag"]:
            ways = np.asarray(self.values["viewpos"]) - self.cells.points.read(begin, end)
            turned = np.einsum("ij,ij->i", normals, ways) < 0.0
        else:
            turned = (self._signs.read(begin, end) < 0) != np.isin(self._parts.read(begin, end), over)
        normals[turned] *= -1.0
        self.results.write(begin, self.cells.numbers.read(begin, end), normals)


def _by_number(numbers: Longs, slots: Longs) -> Longs:
    """(n, k) slots of neighbours in the order of their numbers."""
    return np.take_along_axis(slots, np.argsort(numbers, axis=1), axis=1)


def _turned_alike(
    count: int, rows: NDArray[Any], others: NDArray[Any], agree: Floats
) -> tuple[NDArray[np.intp], NDArray[np.int8]]:
    """Which side each of some things is on so that linked ones agree, along the links where they agree or disagree most.

    (l,) `rows` and `others` are the ends of each link, never the same; `agree` is from -1 to 1, the same of a link that is there
    both ways, and below 0 one end has to be turned over.

    Returns:
        (count,) the first of all things that a thing is linked with, and (count,) 1 or -1, which is 1 for the first.
    """
    low, high = np.minimum(rows, others).astype(np.int64), np.maximum(rows, others)
    links, once = np.unique(low * count + high, return_index=True)
    ends, weights = (low[once], high[once]), 2.0 - np.abs(agree[once])  # above 0, since a 0 is no link
    tree = sparse.csgraph.minimum_spanning_tree(sparse.csr_matrix((weights, ends), shape=(count, count))).tocoo()
    over = (agree[once] < 0.0)[np.searchsorted(links, tree.row.astype(np.int64) * count + tree.col)] * count
    # Every thing is there twice, once on each side: each tree then falls into two parts.
    start = np.concatenate([tree.row, tree.row + count])
    end = np.concatenate([tree.col + over, tree.col + (count - over)])
    graph = sparse.coo_matrix((np.ones(len(start), np.int8), (start, end)), shape=(2 * count, 2 * count))
    sides = sparse.csgraph.connected_components(graph, directed=False)[1]
    _, first, part = np.unique(np.minimum(sides[:count], sides[count:]), return_index=True, return_inverse=True)
    return first[part], np.where(sides[:count] == sides[first[part]], 1, -1).astype(np.int8)

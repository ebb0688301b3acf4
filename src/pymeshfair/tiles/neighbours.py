"""The k nearest neighbours of each point of a cloud in tiles, and two steps that use them: selecting stray points, and normals.

Neighbours are searched in the tile, a range of cells, and in the cells around it. A pass over a tile reads results of the
previous pass for points around the tile, so all tiles must finish a pass before the next begins.
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

#: the largest number of points of surrounding cells in memory: `_AROUND` times the points of a tile, at least `_LEAST_AROUND`
_AROUND, _LEAST_AROUND = 0.125, 1 << 15
#: multiples of the largest tile's size: how many points search surrounding cells at once, and the most cells they list in total
_SEARCHING, _LISTED = 0.125, 8
_AT_ONCE = 4096  # number of points whose neighbours in the tile are sorted at once


@dataclass(frozen=True, eq=False)
class TilePoints:
    """The points of a tile, each with its k nearest neighbours, in the order of a k-d tree."""

    cells: Cells
    first: int  # the first cell of the tile
    last: int  # the cell after the last one
    points: Floats  # (n, 3) coordinates, divided by the scale of the cells
    numbers: Longs  # (n,) the numbers of the points, see `Cells`
    slots: Longs  # (n,) the rows of the points in the files
    nearest: Ints  # (n, k) rows of the nearest points in the tile; 0 if the tile has too few points
    distances: Floats  # (n,) root mean square distances of the k nearest in the tile; after `search_around`, in the cloud
    reaches: Floats  # (n,) squared distances of the farthest of these k neighbours

    @classmethod
    def of(cls, cells: Cells, first: int, last: int, k: int) -> TilePoints:
        """Reads the cells from `first` to before `last`, and finds the k nearest neighbours of each point within the tile."""
        begin, end = cells.slots_of(first, last)
        numbers = cells.numbers.read(begin, end)
        count, order = len(numbers), np.argsort(numbers)
        points = cells.points.read(begin, end)[order]
        tree = build_tree(points, ignore_progress, scale=cells.scale)
        by_tree = tree.indices[:count]
        nearest, distances, reaches = np.zeros((count, k), np.int32), np.empty(count), np.full(count, np.inf)

        def search(start: int, stop: int) -> None:
            rows, squared = search_leaves(tree, start, stop, nearest)
            distances[rows], reaches[rows] = outliers.standard_distances(squared), squared.max(axis=1)

        if count > k:
            in_parallel(search, leaf_ranges(tree, k), ignore_progress)
        order = order[by_tree]
        points = points[by_tree] / cells.scale
        return cls(cells, first, last, points, numbers[order], begin + order, nearest, distances, reaches)

    @property
    def begin(self) -> int:
        return int(self.cells.starts[self.first])

    def by_slot(self, values: NDArray[Any]) -> NDArray[Any]:
        ordered = np.empty_like(values)
        ordered[self.slots - self.begin] = values
        return ordered

    def search_around(self, most: int) -> Iterator[tuple[NDArray[np.intp], Nearest]]:
        """Yields rows of points that may have neighbours in other tiles, and their neighbours; a tile has up to `most` points."""
        k = self.nearest.shape[1]
        # If the tile has too few points for k neighbours, its own cells are searched like the cells around it.
        tile = (self.first, self.last) if len(self.slots) > k else (0, 0)
        searching = np.flatnonzero(reaching_out(self.points, self.reaches, self.cells.tree, *tile))
        done = 0
        while done < len(searching):
            rows = searching[done : done + max(int(_SEARCHING * most), _AT_ONCE)]
            lists = cells_within(self.points[rows], self.reaches[rows], self.cells.tree, *tile, k, most=_LISTED * most)
            rows = rows[: len(lists[0]) - 1]
            nearest = self._nearest_of(rows)
            self._update_nearest(lists, rows, nearest, most)
            self.distances[rows], self.reaches[rows] = outliers.standard_distances(nearest.squared), nearest.squared[:, -1]
            yield rows, nearest
            done += len(rows)

    def _nearest_of(self, rows: NDArray[np.intp]) -> Nearest:
        """Returns the neighbours in the tile, sorted by distance, then by number; slots are -1 if the tile has too few points."""
        shape = len(rows), self.nearest.shape[1]
        nearest = Nearest(np.full(shape, np.inf), np.full(shape, np.iinfo(np.int64).max), np.full(shape, -1))
        for first in range(0, len(rows) if len(self.slots) > shape[1] else 0, _AT_ONCE):
            block = rows[first : first + _AT_ONCE]
            neighbours = self.nearest[block]
            offsets = self.points[neighbours] - self.points[block][:, None]
            x, y, z = offsets[..., 0], offsets[..., 1], offsets[..., 2]
            squared = x * x + y * y + z * z
            order = np.lexsort((self.numbers[neighbours], squared), axis=1)
            neighbours = np.take_along_axis(neighbours, order, axis=1)
            part = nearest.of(slice(first, first + _AT_ONCE))
            part.squared[:] = np.take_along_axis(squared, order, axis=1)
            part.numbers[:], part.slots[:] = self.numbers[neighbours], self.slots[neighbours]
        return nearest

    def _update_nearest(self, lists: tuple[Longs, Ints], rows: NDArray[np.intp], nearest: Nearest, most: int) -> None:
        """Puts nearer points into `nearest`, the neighbours of the points in `rows`; `lists` are the cells of `cells_within`."""
        cells = self.cells
        points, numbers = self.points[rows], self.numbers[rows]
        largest, size = max(int(_AROUND * most), _LEAST_AROUND), max(1, len(points) // 64)

        def offer(spans: Longs, offered: tuple[Floats, Longs, Longs], start: int) -> None:
            part, lists_here = slice(start, start + size), (lists[0][start : start + size + 1], lists[1])
            offer_cells(points[part], numbers[part], nearest.of(part), lists_here, cells.tree, spans, offered)

        wanted = np.unique(lists[1]).astype(np.int64)
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
            spans = np.zeros((len(cells.starts) - 1, 2), np.int64)  # begin and end of each cell in `offered`
            spans[wanted[at:stop], 0], spans[wanted[at:stop], 1] = (ends - sizes)[at:stop] - read, ends[at:stop] - read
            in_parallel(offer, [(spans, offered, start) for start in range(0, len(points), size)], ignore_progress)
            at = stop


@dataclass(frozen=True)
class PointTiles:
    """The tasks of a step on a cloud in cells. A task that is done twice gives the same files."""

    cells: Cells
    values: Mapping[str, Any]  # the parameters of the step
    k: int  # number of neighbours of a point
    most: int  # the largest number of points of a tile

    result: ClassVar[tuple[str, int]]  # type and count of the numbers in the result of a point

    def do(self, tasks: Tasks, tiles: Ranges, size: int, progress: Callable[[float], None]) -> None:
        """Does all tasks, which fill `results`; passes over a whole file read `size` rows at a time."""
        raise NotImplementedError

    @property
    def results(self) -> Results:
        """Returns the results. Those of a tile lie in the rows of its slots, sorted by the numbers of its points."""
        return Results(Column(self.cells.folder / "results", *self.result))

    @property
    def links(self) -> Column:
        return Column(self.cells.folder / "links", "<i8", self.k)

    def amend(self, first: int, last: int, numbers: Longs, values: Any) -> None:
        """Replaces the results of some points of a tile, given by their numbers."""
        begin, end = self.cells.slots_of(first, last)
        results = self.results.values.read(begin, end)
        results[np.searchsorted(self.results.numbers.read(begin, end), numbers)] = values
        self.results.values.write(begin, results)

    def saved(self, first: int) -> Path:
        """Returns the path of the arrays that the tile with this first cell keeps for a later task."""
        return self.cells.folder / f"aside-{first}.npz"

    def load_saved(self, tiles: Ranges, *names: str) -> Iterator[NDArray[Any]]:
        """Yields for each name the saved arrays of all tiles, concatenated."""
        archives = []
        for first, _ in tiles:
            with np.load(self.saved(first)) as archive:
                archives.append([archive[name] for name in names])
        return (np.concatenate(values) for values in zip(*archives, strict=True))


@dataclass(frozen=True, eq=False)
class Links(Part):
    """The points of a tile and their links to neighbours."""

    to: Ints  # (n, k) the index in `slots` of each neighbour, or `NO_LINK`

    @classmethod
    def of(cls, step: PointTiles, first: int, last: int) -> Links:
        begin, end = step.cells.slots_of(first, last)
        slots = step.links.read(begin, end).reshape(end - begin, -1)
        part = Part(begin, end, np.unique(slots[((slots < begin) | (slots >= end)) & (slots != outliers.NO_LINK)]))
        return cls(begin, end, part.outside, np.where(slots == outliers.NO_LINK, slots, part.rows(slots)).astype(np.int32))


class StrayTiles(PointTiles):
    """The tasks of Select Stray Points; the results mark stray points. A part is a connected component of linked points."""

    result = "u1", 1

    spacings, _thicknesses, _reaches = Stored("<f8"), Stored("<f8"), Stored("<f8")  # by slot; lengths are divided by the scale
    _lasts = Stored("<i8")  # the number of the farthest neighbour
    _parts = Stored("<i8")  # the part within the tile, named by its lowest slot

    @property
    def _rule(self) -> outliers.StrayRule:
        return outliers.StrayRule(self.k, self.values["sparseness"], self.values["smallest_part"])

    def _chosen(self, joined: int) -> Column:
        return Column(self.cells.folder / f"chosen-{joined}", "u1")

    def do(self, tasks: Tasks, tiles: Ranges, size: int, progress: Callable[[float], None]) -> None:
        tasks.map(self.find, tiles, part_of(progress, 0.0, 0.7))
        median = tasks.run(self.median, size)
        tasks.map(self.link, [(median, *tile) for tile in tiles], part_of(progress, 0.7, 0.8))
        for number in range(1, outliers.JOIN_STEPS + 1):
            tasks.map(self.join, [(number, *tile) for tile in tiles])
        tasks.map(self.connect, tiles, part_of(progress, 0.85, 0.95))
        stray = tasks.run(self.across, tiles)
        tasks.map(self.finish, [(stray, *tile) for tile in tiles], part_of(progress, 0.95, 1.0))

    def find(self, first: int, last: int) -> None:
        tile = TilePoints.of(self.cells, first, last, self.k)
        thickness = outliers.thicknesses(tile.points, tile.numbers, tile.nearest)
        slots, lasts = tile.slots[tile.nearest], tile.numbers[tile.nearest[:, -1]]
        for rows, nearest in tile.search_around(self.most):
            slots[rows], lasts[rows] = nearest.slots, nearest.numbers[:, -1]
            around = self.cells.points.gather(nearest.slots).reshape(-1, 3) / self.cells.scale
            numbers = np.arange(len(rows) + len(around), dtype=np.int32)  # of the points, then of their neighbours
            points, neighbours = np.concatenate([tile.points[rows], around]), numbers[len(rows) :].reshape(nearest.slots.shape)
            thickness[rows] = outliers.thicknesses(points, numbers.astype(np.int64), neighbours)
        for column, values in (
            (self.links, slots),
            (self._lasts, lasts),
            (self.spacings, tile.distances),
            (self._reaches, tile.reaches),
            (self._thicknesses, thickness),
        ):
            column.write(tile.begin, tile.by_slot(values))

    def median(self, size: int) -> float:
        """Returns the lower median of the spacings above 0, read `size` at a time; each of four passes finds 16 bits of it."""
        rank, prefix = 0, 0
        for shift in (48, 32, 16, 0):
            counts = np.zeros(1 << 16, np.int64)
            for spacings in self.spacings.slices(size):
                bits = spacings[spacings > 0.0].view(np.uint64)  # non-negative floats have the same order as their bits
                fits = (bits >> np.uint64(shift + 16) if shift < 48 else bits >> np.uint64(63)) == prefix
                counts += np.bincount(((bits[fits] >> np.uint64(shift)) & np.uint64(0xFFFF)).astype(np.int64), minlength=1 << 16)
            rank = rank if shift < 48 else (int(counts.sum()) - 1) // 2
            digit = int(np.searchsorted(np.cumsum(counts), rank, "right"))
            rank -= int(counts[:digit].sum())
            prefix = prefix << 16 | digit
        return float(np.array([prefix], np.uint64).view(np.float64)[0])

    def link(self, median: float, first: int, last: int) -> None:
        """Cuts links that are not mutual, and chooses the points on a surface by `_rule`; `median` is the median spacing."""
        links = Links.of(self, first, last)
        points = links.read_all(self.cells.points) / self.cells.scale
        numbers, reaches, lasts = (links.read_all(values) for values in (self.cells.numbers, self._reaches, self._lasts))
        outliers.cut_links(points, numbers, links.to, reaches, lasts)
        self.links.write(links.begin, np.append(links.slots, outliers.NO_LINK)[links.to])  # index -1 selects `NO_LINK`
        counts = outliers.linked_to(links.to, np.ones(len(points), np.bool_))
        chosen = self._rule.on_surface(links.read_inside(self.spacings), median, links.read_inside(self._thicknesses), counts)
        self._chosen(0).write(links.begin, chosen)

    def join(self, number: int, first: int, last: int) -> None:
        """Chooses, in pass `number` (from 1), also the points with enough links to chosen points."""
        links = Links.of(self, first, last)
        chosen = links.read_all(self._chosen(number - 1)) > 0
        joined = chosen[: len(links.to)] | self._rule.is_joined(outliers.linked_to(links.to, chosen))
        self._chosen(number).write(links.begin, joined)

    def connect(self, first: int, last: int) -> None:
        """Finds the parts within a tile; marks as stray the points not chosen, and small parts that reach no other tile."""
        links = Links.of(self, first, last)
        chosen = links.read_all(self._chosen(outliers.JOIN_STEPS)) > 0
        count = len(links.to)
        parts = outliers.linked_parts(links.to, chosen)
        self._parts.write(links.begin, parts + links.begin)
        sizes, sums = outliers.part_sums(parts, links.read_inside(self._thicknesses), count)
        rows, at = np.nonzero(links.to >= count)
        others = links.to[rows, at].astype(np.int64)
        are_chosen = chosen[rows] & chosen[others]
        inner, others = parts[rows[are_chosen]], links.outside[others[are_chosen] - count]
        crossing = np.unique(inner)
        names, inner = crossing + links.begin, inner + links.begin
        np.savez(self.saved(first), parts=names, sizes=sizes[crossing], sums=sums[crossing], inner=inner, others=others)
        small = self._rule.too_small(sizes, sums)
        small[crossing] = False
        self.results.write(links.begin, links.read_inside(self.cells.numbers), ~chosen[:count] | small[parts])

    def across(self, tiles: Ranges) -> Longs:
        """Joins the parts that reach into other tiles; returns those that are stray, ascending."""
        parts, sizes, sums, inner, others = self.load_saved(tiles, "parts", "sizes", "sums", "inner", "others")
        ends = np.searchsorted(parts, inner), np.searchsorted(parts, self._parts.gather(others))
        graph = sparse.coo_matrix((np.ones(len(inner), np.int8), ends), shape=(len(parts), len(parts)))
        count, component = sparse.csgraph.connected_components(graph, directed=False)
        # The sums are exact: whole numbers below 2^53.
        totals = (np.bincount(component, values, minlength=count).astype(np.int64) for values in (sizes, sums))
        return np.asarray(parts[self._rule.too_small(*totals)[component]])

    def finish(self, stray: Longs, first: int, last: int) -> None:
        begin, end = self.cells.slots_of(first, last)
        is_stray = np.isin(self._parts.read(begin, end), stray)
        self.amend(first, last, self.cells.numbers.read(begin, end)[is_stray], 1)


class NormalTiles(PointTiles):
    """The tasks of the filter Compute normals for point sets.

    Normals are oriented towards a view point, or consistently along minimum spanning trees, first within each tile and then
    across tiles. Apart from signs, normals have the same bits for any division into tiles, since links are sorted by number.
    """

    result = "<f8", 3

    _signs = Stored("i1")  # the orientation of each normal relative to the first normal of its part
    _parts = Stored("<i8")  # the connected component of linked points within the tile, named by its first slot

    @property
    def iterations(self) -> int:
        return int(self.values["smoothiter"])

    def directions(self, iteration: int) -> Column:
        """Returns the column of the normals after this number of smoothing iterations."""
        return Column(self.cells.folder / f"directions-{iteration}", "<f8", 3)

    def do(self, tasks: Tasks, tiles: Ranges, size: int, progress: Callable[[float], None]) -> None:
        tasks.map(self.find, tiles, part_of(progress, 0.0, 0.4))
        tasks.map(self.fit, tiles, part_of(progress, 0.4, 0.6))
        for number in range(1, self.iterations + 1):
            tasks.map(self.smooth, [(number, *tile) for tile in tiles])
            tasks.run(self.directions(number - 1).path.unlink, True)  # also if a killed run has removed it
        flipped = np.empty(0, np.int64)
        if not self.values["flipflag"]:
            tasks.map(self.orient, tiles, part_of(progress, 0.7, 0.85))
            tasks.map(self.meet, tiles, part_of(progress, 0.85, 0.95))
            flipped = tasks.run(self.across, tiles)
        tasks.map(self.finish, [(flipped, *tile) for tile in tiles], part_of(progress, 0.95, 1.0))

    def find(self, first: int, last: int) -> None:
        tile = TilePoints.of(self.cells, first, last, self.k)
        slots = _by_number(tile.numbers[tile.nearest], tile.slots[tile.nearest])
        for rows, nearest in tile.search_around(self.most):
            slots[rows] = _by_number(nearest.numbers, nearest.slots)
        self.links.write(tile.begin, tile.by_slot(slots))

    def fit(self, first: int, last: int) -> None:
        links = Links.of(self, first, last)
        self.directions(0).write(links.begin, normals_of(links.read_all(self.cells.points) / self.cells.scale, links.to))

    def smooth(self, iteration: int, first: int, last: int) -> None:
        """Writes the unit mean of each normal and its neighbours' normals, which are first flipped to the same side."""
        links = Links.of(self, first, last)
        before = links.read_all(self.directions(iteration - 1))
        self.directions(iteration).write(links.begin, smoothed_directions(before, links.to))

    def orient(self, first: int, last: int) -> None:
        links = Links.of(self, first, last)
        normals = links.read_inside(self.directions(self.iterations))
        count = len(normals)
        rows, at = np.nonzero((links.to < count) & (links.to != np.arange(count)[:, None]))
        others = links.to[rows, at]
        parts, signs = _oriented(count, rows, others, np.einsum("ij,ij->i", normals[rows], normals[others]))
        self._signs.write(links.begin, signs)
        self._parts.write(links.begin, parts + links.begin)

    def meet(self, first: int, last: int) -> None:
        """Sums dot products of linked normals for each pair of parts in this and another tile, and z components for each part."""
        links = Links.of(self, first, last)
        signed = links.read_all(self.directions(self.iterations)) * links.read_all(self._signs)[:, None]
        parts = links.read_all(self._parts)
        rows, at = np.nonzero(links.to >= len(links.to))
        others = links.to[rows, at]
        pairs, at_pair = np.unique(np.stack([parts[rows], parts[others]], axis=1), axis=0, return_inverse=True)
        votes = np.bincount(at_pair.ravel(), np.einsum("ij,ij->i", signed[rows], signed[others]), minlength=len(pairs))
        names, at_name = np.unique(parts[: len(links.to)], return_inverse=True)
        ups = np.bincount(at_name, signed[: len(links.to), 2], minlength=len(names))
        np.savez(self.saved(first), parts=names, ups=ups, pairs=pairs, votes=votes)

    def across(self, tiles: Ranges) -> Longs:
        """Returns the parts to flip, ascending: connected parts then agree, and the sum of their normals points up."""
        parts, ups, pairs, votes = self.load_saved(tiles, "parts", "ups", "pairs", "votes")
        ends = np.searchsorted(parts, pairs)
        both, at = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)  # a pair may occur in both orders
        votes = np.bincount(at.ravel(), votes, minlength=len(both))
        component, signs = _oriented(len(parts), both[:, 0], both[:, 1], votes / (np.abs(votes).max(initial=0.0) or 1.0))
        up = np.bincount(component, signs * ups, minlength=len(parts))
        signs = np.where(up[component] < 0.0, -signs, signs)
        return np.asarray(parts[signs < 0])

    def finish(self, flipped: Longs, first: int, last: int) -> None:
        """Writes the results: flips the parts in `flipped`; with a view point, turns all normals towards it."""
        begin, end = self.cells.slots_of(first, last)
        normals = self.directions(self.iterations).read(begin, end)
        if self.values["flipflag"]:
            view_vectors = np.asarray(self.values["viewpos"]) - self.cells.points.read(begin, end)
            is_flipped = np.einsum("ij,ij->i", normals, view_vectors) < 0.0
        else:
            is_flipped = (self._signs.read(begin, end) < 0) != np.isin(self._parts.read(begin, end), flipped)
        normals[is_flipped] *= -1.0
        self.results.write(begin, self.cells.numbers.read(begin, end), normals)


def _by_number(numbers: Longs, slots: Longs) -> Longs:
    return np.take_along_axis(slots, np.argsort(numbers, axis=1), axis=1)


def _oriented(
    count: int, rows: NDArray[Any], others: NDArray[Any], agreement: Floats
) -> tuple[NDArray[np.intp], NDArray[np.int8]]:
    """Orients `count` nodes of a graph consistently, along the spanning forest of the links with the largest absolute agreement.

    (l,) `rows` and `others` are the two ends of each link, `agreement` its (l,) numbers from -1 to 1: below 0 one end must be
    flipped. A link may occur in both directions, with the same agreement. Returns (count,) the first node of the connected
    component of each node, and (count,) its sign 1 or -1 relative to that node.
    """
    low, high = np.minimum(rows, others).astype(np.int64), np.maximum(rows, others)
    links, once = np.unique(low * count + high, return_index=True)
    ends, weights = (low[once], high[once]), 2.0 - np.abs(agreement[once])  # above 0, since a weight of 0 would be no link
    tree = sparse.csgraph.minimum_spanning_tree(sparse.csr_matrix((weights, ends), shape=(count, count))).tocoo()
    shift = (agreement[once] < 0.0)[np.searchsorted(links, tree.row.astype(np.int64) * count + tree.col)] * count
    # Every node occurs twice, once for each sign, so that each tree becomes two components.
    start = np.concatenate([tree.row, tree.row + count])
    end = np.concatenate([tree.col + shift, tree.col + (count - shift)])
    graph = sparse.coo_matrix((np.ones(len(start), np.int8), (start, end)), shape=(2 * count, 2 * count))
    sides = sparse.csgraph.connected_components(graph, directed=False)[1]
    _, first, part = np.unique(np.minimum(sides[:count], sides[count:]), return_index=True, return_inverse=True)
    return first[part], np.where(sides[:count] == sides[first[part]], 1, -1).astype(np.int8)

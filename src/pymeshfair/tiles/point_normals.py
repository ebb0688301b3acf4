"""Normals of a cloud by tiles: planes through neighbours, smoothed, and turned alike or towards a view point.

Directions have the same bits however the cloud is cut. Where no view point says the side, it spreads from point to point in a
tile and then from tile to tile, each time first where normals agree most.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..filters.denoising import normals_of, smoothed_directions
from ..filters.execution import part_of
from ..filters.libraries import sparse
from ..filters.neighbours import Nearest
from .cells import Ranges
from .columns import Column, Stored, joined
from .division import Floats, Longs
from .neighbours import Links, PointTiles, TilePoints
from .workers import Tasks


class NormalTiles(PointTiles):
    """The tasks of Compute normals for point sets; the results are the normals. Links go to neighbours by their numbers."""

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
        tasks.run(self.create)
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

    def create(self) -> None:
        """Make the files."""
        columns = (self.directions(i) for i in range(self.iterations + 1))
        for column in (self.links(), self._signs, self._parts, *columns):
            column.create(self.cells.count)

    def find(self, first: int, last: int) -> None:
        """The neighbours of the points in the cells from `first` to before `last`."""
        asked: list[tuple[NDArray[np.intp], Longs]] = []

        def around(tile: TilePoints, rows: NDArray[np.intp], nearest: Nearest) -> None:
            order = np.argsort(nearest.numbers, axis=1)
            asked.append((rows, np.take_along_axis(nearest.slots, order, axis=1)))

        tile = self.search(first, last, lambda rows, squared: None, around)
        # rows by number are in the order of the numbers
        slots = tile.slots[np.sort(tile.index[tile.nearest], axis=1)]
        for rows, theirs in asked:
            slots[rows] = theirs
        self.links().write(tile.begin, tile.by_slot(slots))

    def fit(self, first: int, last: int) -> None:
        """The planes through them."""
        links = Links.read(self.links(), self.cells, first, last)
        self.directions(0).write(links.begin, normals_of(links.of_all(self.cells.points) / self.cells.scale, links.rows))

    def smooth(self, iteration: int, first: int, last: int) -> None:
        """The mean of each normal and those of its neighbours, on its side."""
        links = Links.read(self.links(), self.cells, first, last)
        before = links.of_all(self.directions(iteration - 1))
        self.directions(iteration).write(links.begin, smoothed_directions(before, links.rows))

    def forget(self, iteration: int) -> None:
        """Remove normals that have been smoothed."""
        self.directions(iteration).path.unlink(missing_ok=True)

    def orient(self, first: int, last: int) -> None:
        """Turn the normals of a tile alike, along the links across which they agree most."""
        links = Links.read(self.links(), self.cells, first, last)
        own = links.of_own(self.directions(self.iterations))
        count = len(own)
        rows, at = np.nonzero((links.rows < count) & (links.rows != np.arange(count)[:, None]))
        others = links.rows[rows, at]
        agree = np.einsum("ij,ij->i", own[rows], own[others])
        parts, signs = _turned_alike(count, rows, others, agree)
        self._signs.write(links.begin, signs)
        self._parts.write(links.begin, parts + links.begin)

    def meet(self, first: int, last: int) -> None:
        """The agreement of the parts of a tile with those of others, and the upward component of each."""
        links = Links.read(self.links(), self.cells, first, last)
        signed = links.of_all(self.directions(self.iterations)) * links.of_all(self._signs)[:, None]
        parts = links.of_all(self._parts)
        rows, at = np.nonzero(links.rows >= len(links.rows))
        others = links.rows[rows, at]
        pairs, at_pair = np.unique(np.stack([parts[rows], parts[others]], axis=1), axis=0, return_inverse=True)
        votes = np.bincount(at_pair.ravel(), np.einsum("ij,ij->i", signed[rows], signed[others]), minlength=len(pairs))
        names, at_name = np.unique(parts[: len(links.rows)], return_inverse=True)
        ups = np.bincount(at_name, signed[: len(links.rows), 2], minlength=len(names))
        np.savez(self.aside(first), parts=names, ups=ups, pairs=pairs, votes=votes)

    def across(self, tiles: list[tuple[int, int]]) -> Longs:
        """The parts that are to be turned over, ascending, so that all agree; what belongs together looks up on the whole."""
        parts, ups, pairs, votes = joined((self.aside(first) for first, _ in tiles), ("parts", "ups", "pairs", "votes"))
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
        self.part(first).write(self.cells.numbers.read(begin, end), normals)


def _turned_alike(
    count: int, rows: NDArray[Any], others: NDArray[Any], agree: Floats
) -> tuple[NDArray[np.intp], NDArray[np.int8]]:
    """Which side each of some things is on so that linked ones agree, along the links where they agree or disagree most.

    Args:
        count: how many things.
        rows: (l,) one end of each link.
        others: (l,) the other, not the same.
        agree: (l,) from -1 to 1, the same of a link that is there both ways; below 0 one end has to be turned over.

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

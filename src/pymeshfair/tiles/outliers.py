"""LoOP by tiles: neighbours in the tile and in the cells around it, then the comparison with theirs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..filters.neighbours import Nearest
from ..filters.outliers import compare, compare_rows, standard_distances
from .cells import Cells
from .columns import Column, Part
from .division import Floats
from .neighbours import TilePoints, search_tile


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
        count = int(self.cells.starts[last] - self.cells.starts[first])
        distances = np.empty(count)
        asking = [np.empty(0, np.intp)]
        asked_slots = [np.empty((0, self.k), np.int64)]

        def inside(rows: slice, squared: Floats) -> None:
            distances[rows] = standard_distances(squared)

        def around(tile: TilePoints, rows: NDArray[np.intp], nearest: Nearest) -> None:
            distances[rows] = standard_distances(nearest.squared)
            asking.append(rows)
            asked_slots.append(nearest.slots)

        tile = search_tile(self.cells, self.k, self.tile, first, last, inside, around)
        asks = np.concatenate(asking)
        factors = np.full(count, np.nan)
        if len(asks) < count:
            compare(distances, tile.nearest, 0, count, factors)
            factors[asks] = np.nan
        self.distances.write(tile.begin, tile.by_slot(distances))
        self.part(first).write(tile.numbers, tile.by_number(factors))
        np.savez(self._asking(first), rows=tile.index[asks], own=distances[asks], slots=np.concatenate(asked_slots))

    def finish(self, first: int) -> None:
        """The factors of those points of a tile that had asked around; every tile must have been through `find`."""
        with np.load(self._asking(first)) as found:
            rows, own, slots = found["rows"], found["own"], found["slots"]
        if len(rows):
            self.part(first).replace(rows, compare_rows(own, self.distances.gather(slots)))

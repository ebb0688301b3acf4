"""Links from the points of a tile to their neighbours in any tile, and the values of all these points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..filters.outliers import NO_LINK
from .cells import Cells
from .columns import Column
from .division import Longs


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

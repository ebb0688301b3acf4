"""Arrays in files that are read and written by rows, without mapping them into memory: what is not read takes none."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Column:
    """An array of a type and a number of columns in a file of its own; processes may write to different rows at once.

    Attributes:
        path: the file.
        dtype: of a number, as numpy writes it: ``"<f8"``.
        width: numbers in a row.
    """

    path: Path
    dtype: str
    width: int = 1

    @property
    def row(self) -> int:
        """Bytes of a row."""
        return np.dtype(self.dtype).itemsize * self.width

    def __len__(self) -> int:
        """How many rows the file has."""
        return self.path.stat().st_size // self.row

    def create(self, rows: int) -> Column:
        """Make the file with so many rows, all 0."""
        with self.path.open("wb") as file:
            file.truncate(rows * self.row)
        return self

    def read(self, first: int, last: int) -> NDArray[Any]:
        """The rows from `first` to before `last`: (n,) if a row is one number, else (n, width)."""
        found = np.fromfile(self.path, self.dtype, (last - first) * self.width, offset=first * self.row)
        return found if self.width == 1 else found.reshape(-1, self.width)

    def write(self, first: int, values: NDArray[Any]) -> None:
        """Write rows from `first` on.

        Raises:
            OSError: the disk is full.
        """
        with self.path.open("r+b") as file:
            file.seek(first * self.row)
            file.write(np.ascontiguousarray(values, self.dtype).data)

    def append(self, values: NDArray[Any]) -> None:
        """Write rows after the last one; by one process at a time."""
        with self.path.open("ab") as file:
            file.write(np.ascontiguousarray(values, self.dtype).data)

    def gather(self, rows: NDArray[np.int64]) -> NDArray[Any]:
        """The given rows, of a shape of their own; few of many, near each other in groups."""
        if not rows.size:
            return np.empty(rows.shape if self.width == 1 else (*rows.shape, self.width), self.dtype)
        whole = np.memmap(self.path, self.dtype, "r")
        return np.array(whole[rows] if self.width == 1 else whole.reshape(-1, self.width)[rows])

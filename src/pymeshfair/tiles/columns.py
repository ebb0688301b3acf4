"""Arrays in files, read and written by ranges of rows, so that only these rows take memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Column:
    """An array of a type and a number of columns in a file of its own; processes may write to different rows at once."""

    path: Path
    dtype: str  # the type of a number in numpy's notation, such as ``"<f8"``
    width: int = 1  # numbers in a row

    @property
    def row(self) -> int:
        """Bytes of a row."""
        return np.dtype(self.dtype).itemsize * self.width

    def __len__(self) -> int:
        """The number of rows of the file."""
        return self.path.stat().st_size // self.row

    def create(self, rows: int) -> Column:
        """Make the file with so many rows, all 0."""
        with self.path.open("wb") as file:
            file.truncate(rows * self.row)
        return self

    def read(self, first: int, last: int) -> NDArray[Any]:
        """The rows from `first` to before `last`: (n,) if a row is one number, else (n, width)."""
        numbers = np.fromfile(self.path, self.dtype, (last - first) * self.width, offset=first * self.row)
        return numbers if self.width == 1 else numbers.reshape(-1, self.width)

    def slices(self, size: int) -> Iterator[NDArray[Any]]:
        """All rows, `size` at a time."""
        for first in range(0, len(self), size):
            yield self.read(first, first + size)

    def write(self, first: int, values: NDArray[Any]) -> None:
        """Write rows from `first` on."""
        with self.path.open("r+b") as file:
            file.seek(first * self.row)
            file.write(np.ascontiguousarray(values, self.dtype).data)

    def append(self, values: NDArray[Any]) -> None:
        """Write rows after the last one; by one process at a time."""
        with self.path.open("ab") as file:
            file.write(np.ascontiguousarray(values, self.dtype).data)

    def gather(self, rows: NDArray[np.int64]) -> NDArray[Any]:
        """The rows of an index array of any shape, by a memory map: for few rows that lie in groups."""
        if not rows.size:
            return np.empty(rows.shape if self.width == 1 else (*rows.shape, self.width), self.dtype)
        whole = np.memmap(self.path, self.dtype, "r")
        return np.array(whole[rows] if self.width == 1 else whole.reshape(-1, self.width)[rows])


class Stored:
    """A column of a cloud in cells, in the file of its name in their folder."""

    def __init__(self, dtype: str, width: int = 1) -> None:
        self._kind = dtype, width

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name.strip("_")

    def __get__(self, stored: Any, owner: type) -> Column:
        return Column(getattr(stored, "cells", stored).folder / self._name, *self._kind)


@dataclass(frozen=True)
class Part:
    """The values of the points of one tile, by ascending number."""

    path: Path  # the file of the values; the file of the numbers is beside it
    dtype: str  # the type of a value
    width: int = 1  # numbers in a value

    @property
    def values(self) -> Column:
        """The values."""
        return Column(self.path, self.dtype, self.width)

    @property
    def numbers(self) -> Column:
        """The numbers of the points with these values."""
        return Column(self.path.with_name(f"{self.path.name}.numbers"), "<i8")

    def write(self, numbers: NDArray[np.int64], values: NDArray[Any]) -> None:
        """Write the values of points, which are put into the order of their numbers."""
        order = np.argsort(numbers)
        self.values.create(len(values)).write(0, values[order])
        self.numbers.create(len(numbers)).write(0, numbers[order])

    def replace(self, rows: NDArray[Any], values: NDArray[Any]) -> None:
        """Write other values into some rows."""
        whole = self.values.read(0, len(self.values))
        whole[rows] = values
        self.values.write(0, whole)


def joined(paths: Iterable[Path], names: Sequence[str]) -> Iterator[NDArray[Any]]:
    """The arrays of these names in archives of `numpy.savez`, those of all archives one after another."""
    archives = []
    for path in paths:
        with np.load(path) as one:
            archives.append([one[name] for name in names])
    return (np.concatenate(values) for values in zip(*archives, strict=True))


def in_order(parts: Sequence[Part], count: int, size: int) -> Iterator[NDArray[Any]]:
    """The values of the points 0 to `count`, each of which is in one part, `size` at a time."""
    values, numbers = [p.values for p in parts], [p.numbers for p in parts]
    at, ends = [0] * len(parts), [len(n) for n in numbers]
    held = [np.empty(0, np.int64)] * len(parts)  # numbers that were read but not used yet
    ahead = max(1, size // max(1, len(parts)))
    for first in range(0, count, size):
        last = min(first + size, count)
        block = np.empty((last - first, *((parts[0].width,) if parts[0].width > 1 else ())), parts[0].dtype)
        filled = 0
        for i in range(len(parts)):
            while True:
                if not len(held[i]) and at[i] < ends[i]:
                    held[i] = numbers[i].read(at[i], min(at[i] + ahead, ends[i]))
                here = int(np.searchsorted(held[i], last))
                if here:
                    block[held[i][:here] - first] = values[i].read(at[i], at[i] + here)
                    at[i], held[i], filled = at[i] + here, held[i][here:], filled + here
                if len(held[i]) or at[i] == ends[i]:
                    break
        assert filled == last - first, f"points {first} to {last}: {filled} values"
        yield block

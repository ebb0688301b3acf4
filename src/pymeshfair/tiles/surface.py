"""A mesh in cells: the files of `Cells`, and the faces at the vertices of each cell, each face by the slots of its corners."""

import contextlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FilterInputError
from .cells import Cells
from .columns import Column, Stored
from .division import Bucket, Floats, Longs

#: a face: the slots of its corners, and its number
FACE = np.dtype([("corners", "<i4", 3), ("number", "<i8")])


@dataclass(frozen=True)
class Surface:
    """The files of a mesh."""

    cells: Cells  # of its vertices
    #: (b + 1,) the slot at which each bucket begins; the faces at its vertices are in a file of their own
    buckets: tuple[int, ...]

    slots = Stored("<i4")  # of each vertex, by its number
    moved = Stored("<f8", 3)  # new coordinates by slot
    before = Stored("<f8", 3)  # those before a step that may fold faces
    state = Stored("<f8", 3)  # normalised coordinates by slot, between the rounds of a filter
    next_state = Stored("<f8", 3)  # those after a round
    across = Stored("<f8", 3)  # the places of vertices of the outline without their displacement along the surface
    outline = Stored("u1")  # which those are

    def _raw(self, bucket: int) -> Path:
        return self.cells.folder / f"corners-{bucket}"

    def _faces(self, bucket: int) -> Path:
        return self.cells.folder / f"faces-{bucket}"

    def _starts(self, bucket: int) -> Column:
        """The begin and end of the faces of each cell of a bucket in its file."""
        return Column(self.cells.folder / f"faces-{bucket}.starts", "<i8")

    def fill(self, bucket: Bucket, first: int) -> tuple[Longs, Floats]:
        """As `Cells.fill`; writes down the slot of each vertex, too."""
        found = self.cells.fill(bucket, first)
        np.memmap(self.slots.path, "<i4", "r+")[self.cells.numbers.read(first, first + bucket.count)] = np.arange(
            first, first + bucket.count, dtype=np.int32
        )
        return found

    def sort_in(self, slices: Callable[[], Iterable[NDArray[Any]]]) -> int:
        """Give each face, of slices of (m, 3) numbers of vertices, to the buckets of its corners; how many faces there are."""
        slots = np.memmap(self.slots.path, "<i4", "r")
        starts, count = np.array(self.buckets), 0
        self.remove_unordered()  # of a process that was killed here
        for corners in slices():
            if len(corners) and (corners.min() < 0 or corners.max() >= len(slots)):
                bad = int(((corners < 0) | (corners >= len(slots))).any(axis=1).argmax())
                raise FilterInputError(
                    f"face {count + bad} is {corners[bad].tolist()}, but the vertices are 0 to {len(slots) - 1}: remove it"
                )
            faces = np.empty(len(corners), FACE)
            faces["corners"], faces["number"] = slots[corners], np.arange(count, count + len(corners))
            there = np.searchsorted(starts, faces["corners"], "right") - 1
            for bucket in np.unique(there).tolist():
                with self._raw(bucket).open("ab") as file:
                    file.write(faces[(there == bucket).any(axis=1)].tobytes())
            count += len(corners)
        return count

    def order_faces(self, bucket: int) -> None:
        """Put the faces of a bucket into the order of its cells; a face stands once with every cell that it touches."""
        raw = self._raw(bucket)
        faces = np.fromfile(raw, FACE) if raw.exists() else np.empty(0, FACE)
        first, last = self.cell_range(bucket)
        cell = np.searchsorted(self.cells.starts, faces["corners"], "right") - 1
        cell[(cell < first) | (cell >= last)] = -1
        cell = np.sort(cell, axis=1)
        cell[:, 1:][cell[:, 1:] == cell[:, :-1]] = -1  # each cell of a face once
        row, column = np.nonzero(cell >= 0)
        order = np.argsort(cell[row, column], kind="stable")
        self._faces(bucket).write_bytes(faces[row[order]].tobytes())
        counts = np.bincount(cell[row, column] - first, minlength=last - first)
        self._starts(bucket).create(last - first + 1).write(0, np.append(0, np.cumsum(counts)))

    def remove_unordered(self) -> None:
        """Remove the faces as they were before `order_faces`."""
        for bucket in range(len(self.buckets) - 1):
            self._raw(bucket).unlink(missing_ok=True)

    def cell_range(self, bucket: int) -> tuple[int, int]:
        """The cells of a bucket, from one to before another."""
        starts = self.cells.starts
        return int(np.searchsorted(starts, self.buckets[bucket])), int(np.searchsorted(starts, self.buckets[bucket + 1]))

    def faces_at(self, cells: NDArray[np.int64]) -> NDArray[Any]:
        """The faces at the vertices of some cells, given in ascending order; those at several cells stand there several times."""
        found = [np.empty(0, FACE)]
        bucket_of = np.searchsorted(np.array(self.buckets), self.cells.starts[cells], "right") - 1
        for bucket in np.unique(bucket_of).tolist():
            first = self.cell_range(bucket)[0]
            starts = self._starts(bucket).read(0, len(self._starts(bucket)))
            own = cells[bucket_of == bucket] - first
            for run in np.split(own, np.flatnonzero(np.diff(own) > 1) + 1):
                begin, end = int(starts[run[0]]), int(starts[run[-1] + 1])
                found.append(np.fromfile(self._faces(bucket), FACE, end - begin, offset=begin * FACE.itemsize))
        return np.concatenate(found)

    def turn(self, new: Column, old: Column) -> None:
        """Put new values in the place of the old ones."""
        with contextlib.suppress(FileNotFoundError):  # it was done before the process was killed
            new.path.replace(old.path)

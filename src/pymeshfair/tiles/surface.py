"""A mesh in cells: its vertices and faces in files, and tiles of it with so many rings of faces around them.

The files are those of `Cells`, and the faces at the vertices of each cell, each face by the slots of its corners. A tile keeps
the order of the whole.
"""

import contextlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FilterInputError
from ..filters.mesh import Bools, Floats, Ints, Longs
from .cells import Cells, Column, Part, Stored

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
    state = Stored("<f8", 3)  # what a filter keeps between its passes
    next_state = Stored("<f8", 3)  # that after a pass

    def _raw(self, bucket: int) -> Path:
        return self.cells.folder / f"corners-{bucket}"

    def _faces(self, bucket: int) -> Path:
        return self.cells.folder / f"faces-{bucket}"

    def _starts(self, bucket: int) -> Column:
        """The begin and end of the faces of each cell of a bucket in its file."""
        return Column(self.cells.folder / f"faces-{bucket}.starts", "<i8")

    def sort_in(self, slices: Callable[[], Iterable[NDArray[Any]]], size: int) -> int:
        """Give each face, of slices of (m, 3) numbers of vertices, to the buckets of its corners; how many faces there are.

        Of the vertices `size` may be in memory.
        """
        cells = self.cells
        self.slots.write(cells.count - 1, np.zeros(1))
        slots = np.memmap(self.slots.path, "<i4", "r+")
        for first in range(0, cells.count, size):
            last = min(first + size, cells.count)
            slots[cells.numbers.read(first, last)] = np.arange(first, last)
        starts, count = np.array(self.buckets), 0
        self.remove_unordered()  # of a process that was killed here
        for corners in slices():
            wrong = ((corners < 0) | (corners >= cells.count)).any(axis=1)
            if wrong.any():
                bad = int(wrong.argmax())
                raise FilterInputError(
                    f"face {count + bad} is {corners[bad].tolist()}, but the vertices are 0 to {cells.count - 1}: remove it"
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
        starts = self.cells.starts
        first, last = np.searchsorted(starts, self.buckets[bucket : bucket + 2])
        cell = np.searchsorted(starts, faces["corners"], "right") - 1
        cell[(cell < first) | (cell >= last)] = -1
        cell = np.sort(cell, axis=1)
        cell[:, 1:][cell[:, 1:] == cell[:, :-1]] = -1  # each cell of a face once
        row, column = np.nonzero(cell >= 0)
        order = np.argsort(cell[row, column], kind="stable")
        self._faces(bucket).write_bytes(faces[row[order]].tobytes())
        counts = np.bincount(cell[row, column] - first, minlength=last - first)
        self._starts(bucket).write(0, np.append(0, np.cumsum(counts)))

    def remove_unordered(self) -> None:
        """Remove the faces as they were before `order_faces`."""
        for bucket in range(len(self.buckets) - 1):
            self._raw(bucket).unlink(missing_ok=True)

    def faces_at(self, cells: Longs) -> NDArray[Any]:
        """The faces at the vertices of some cells, given in ascending order; those at several cells stand there several times."""
        faces = [np.empty(0, FACE)]
        bucket_of = np.searchsorted(np.array(self.buckets), self.cells.starts[cells], "right") - 1
        for bucket in np.unique(bucket_of).tolist():
            starts = self._starts(bucket).read(0, len(self._starts(bucket)))
            own = cells[bucket_of == bucket] - np.searchsorted(self.cells.starts, self.buckets[bucket])
            for run in np.split(own, np.flatnonzero(np.diff(own) > 1) + 1):
                begin, end = int(starts[run[0]]), int(starts[run[-1] + 1])
                faces.append(np.fromfile(self._faces(bucket), FACE, end - begin, offset=begin * FACE.itemsize))
        return np.concatenate(faces)

    def turn(self, new: Column, old: Column) -> None:
        """Put new values in the place of the old ones."""
        with contextlib.suppress(FileNotFoundError):  # it was done before the process was killed
            new.path.replace(old.path)


@dataclass(frozen=True, eq=False)
class TileMesh:
    """A part of a mesh; vertices and faces in the order of the whole."""

    vertices: Floats  # (n, 3) coordinates
    faces: Ints  # (m, 3) triangles
    numbers: Longs  # (n,) of the vertices in the whole
    own: Bools  # (n,) which vertices are the tile's; those that a face uses have all their faces here
    slots: Longs  # (n,) where the vertices are stored

    def write(self, column: Column, values: NDArray[Any]) -> None:
        """Write of (n, ...) values those of the tile's own vertices, which have consecutive slots."""
        column.write(int(self.slots[self.own].min()), values[self.own][np.argsort(self.slots[self.own])])

    @property
    def own_faces(self) -> Bools:
        """(m,) which faces count with the tile: those whose first vertex is its own."""
        return np.asarray(self.own[self.faces.min(axis=1)])


def tile_with_rings(surface: Surface, first: int, last: int, rings: int, *, places: Column | None = None) -> TileMesh:
    """The cells from `first` to before `last`, with the faces that are at most so many rings away, at least one.

    Every vertex that is less than `rings` faces away from one of the tile has all its faces. The coordinates are those in
    `places`, by slot; None for those of the cells.
    """
    cells = surface.cells
    begin, end = cells.slots_of(first, last)
    outside, frontier, loaded = np.empty(0, np.int64), np.arange(first, last), np.zeros(len(cells.starts), np.bool_)
    faces, found = np.empty(0, FACE), []
    for _ in range(max(rings, 1)):
        new = frontier[~loaded[frontier]]
        loaded[new] = True
        faces = np.concatenate([faces, surface.faces_at(new)])
        corners = np.ascontiguousarray(faces["corners"])
        reached = (corners >= begin) & (corners < end)
        reached[~reached] = np.isin(corners[~reached], outside)
        touching = np.asarray(reached.any(axis=1))
        found.append(faces[touching])
        fresh = np.unique(corners[touching[:, None] & ~reached]).astype(np.int64)
        outside = np.union1d(outside, fresh)
        frontier = np.unique(np.searchsorted(cells.starts, fresh, "right") - 1)
        faces = faces[~touching]
    faces = np.concatenate(found)
    faces = faces[np.unique(faces["number"], return_index=True)[1]]
    part = Part(begin, end, outside)
    numbers = part.of_all(cells.numbers)
    order = np.argsort(numbers)
    place = np.empty(len(order), np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    vertices = part.of_all(cells.points if places is None else places)[order]
    return TileMesh(vertices, place[part.rows(faces["corners"])], numbers[order], order < end - begin, part.slots[order])

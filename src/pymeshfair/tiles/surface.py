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
from ..filters.compilation import compiled
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
        index = self.cells.fill(bucket, first)
        np.memmap(self.slots.path, "<i4", "r+")[self.cells.numbers.read(first, first + bucket.count)] = np.arange(
            first, first + bucket.count, dtype=np.int32
        )
        return index

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
        faces = [np.empty(0, FACE)]
        bucket_of = np.searchsorted(np.array(self.buckets), self.cells.starts[cells], "right") - 1
        for bucket in np.unique(bucket_of).tolist():
            first = self.cell_range(bucket)[0]
            starts = self._starts(bucket).read(0, len(self._starts(bucket)))
            own = cells[bucket_of == bucket] - first
            for run in np.split(own, np.flatnonzero(np.diff(own) > 1) + 1):
                begin, end = int(starts[run[0]]), int(starts[run[-1] + 1])
                faces.append(np.fromfile(self._faces(bucket), FACE, end - begin, offset=begin * FACE.itemsize))
        return np.concatenate(faces)

    def turn(self, new: Column, old: Column) -> None:
        """Put new values in the place of the old ones."""
        with contextlib.suppress(FileNotFoundError):  # it was done before the process was killed
            new.path.replace(old.path)


#: rings to a vertex that has not been reached
_FAR = np.iinfo(np.int16).max


@dataclass(frozen=True, eq=False)
class TileMesh:
    """A part of a mesh; vertices and faces in the order of the whole."""

    vertices: Floats  # (n, 3) coordinates
    faces: NDArray[np.int32]  # (m, 3) triangles
    numbers: Longs  # (n,) of the vertices in the whole
    own: NDArray[np.bool_]  # (n,) which vertices are the tile's; those that a face uses have all their faces here
    slots: Longs  # (n,) where the vertices are stored

    def own_by_slot(self, values: NDArray[Any]) -> NDArray[Any]:
        """Of (n, ...) values those of the tile's own vertices, which have consecutive slots, in the order of these."""
        slots = self.slots[self.own]
        ordered = np.empty((len(slots), *values.shape[1:]), values.dtype)
        ordered[slots - slots.min()] = values[self.own]
        return ordered


class _Growing:
    """The cells that have been met, their vertices numbered in the order of the meetings, and the faces."""

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        cells = len(surface.cells.starts) - 1
        self.base = np.full(cells, -1, np.int64)
        self.loaded = np.zeros(cells, np.bool_)
        self.met: list[NDArray[np.int64]] = []
        self.rings = np.empty(0, np.int16)
        self.cell_of = np.empty(0, np.int32)
        self.faces = np.empty(0, FACE)  # their corners by the numbers of here
        self.inside = [np.empty(0, FACE)]  # those all of whose corners have been reached

    def meet(self, cells: NDArray[np.int64]) -> None:
        """Number the vertices of cells that were not met before."""
        new = cells[self.base[cells] < 0]
        if not len(new):
            return
        starts = self.surface.cells.starts
        sizes = starts[new + 1] - starts[new]
        self.base[new] = len(self.rings) + np.append(0, np.cumsum(sizes)[:-1])
        self.met.append(new)
        self.rings = np.append(self.rings, np.full(int(sizes.sum()), _FAR, np.int16))
        self.cell_of = np.append(self.cell_of, np.repeat(new.astype(np.int32), sizes))

    def load(self, cells: NDArray[np.int64]) -> None:
        """Read the faces at cells that were not loaded."""
        new = cells[~self.loaded[cells]]
        if not len(new):
            return
        self.loaded[new] = True
        faces = self.surface.faces_at(new)
        starts = self.surface.cells.starts
        at = np.searchsorted(starts, faces["corners"], "right") - 1
        self.meet(np.unique(np.concatenate([new, at.ravel()])))
        faces["corners"] = self.base[at] + faces["corners"] - starts[at]
        self.faces = np.concatenate([self.faces, faces])

    def reach(self, ring: int) -> NDArray[np.int64]:
        """Extend what has been reached by the faces at its outermost ring; the cells in which vertices were reached."""
        touched = np.zeros(len(self.base), np.bool_)
        open_ = np.empty(len(self.faces), np.bool_)
        _reach(self.faces["corners"], self.rings, self.cell_of, ring, touched, open_)
        self.inside.append(self.faces[~open_])
        self.faces = self.faces[open_]
        return np.flatnonzero(touched)


def tile_with_rings(surface: Surface, first: int, last: int, rings: int, *, places: Column | None = None) -> TileMesh:
    """The cells from `first` to before `last`, with the faces that are at most so many rings away.

    Every vertex that is less than `rings` faces away from one of the tile has all its faces. The coordinates are those in
    `places`, by slot; None for those of the cells.
    """
    growing = _Growing(surface)
    own = np.arange(first, last)
    growing.meet(own)
    growing.rings[:] = 0
    frontier = own
    for ring in range(1, max(rings, 1) + 1):
        growing.load(frontier)
        frontier = growing.reach(ring)
    faces = np.concatenate([*growing.inside, growing.faces])
    near = growing.rings[faces["corners"]].min(axis=1) < max(rings, 1)
    faces = faces[near]
    faces = faces[np.unique(faces["number"], return_index=True)[1]]

    met = np.concatenate(growing.met)
    cells = surface.cells
    ranges = cells.ranges_of(met)
    here = growing.rings <= max(rings, 1)
    numbers = np.concatenate([cells.numbers.read(*r) for r in ranges])[here]
    order = np.argsort(numbers)
    place = np.empty(len(here), np.int32)
    place[np.flatnonzero(here)[order]] = np.arange(len(order), dtype=np.int32)
    return TileMesh(
        np.concatenate([(cells.points if places is None else places).read(*r) for r in ranges])[here][order],
        place[faces["corners"]],
        numbers[order],
        growing.rings[here][order] == 0,
        np.concatenate([np.arange(*r) for r in ranges])[here][order],
    )


@compiled
def _reach(
    corners: NDArray[np.int32],
    rings: NDArray[np.int16],
    cell_of: NDArray[np.int32],
    ring: int,
    touched: NDArray[np.bool_],
    open_: NDArray[np.bool_],
) -> None:
    for f in range(corners.shape[0]):
        a, b, c = corners[f, 0], corners[f, 1], corners[f, 2]
        nearest = min(rings[a], rings[b], rings[c])
        if nearest == ring - 1:
            for i in (a, b, c):
                if rings[i] > ring:
                    rings[i] = ring
                    touched[cell_of[i]] = True
        open_[f] = max(rings[a], rings[b], rings[c]) > ring

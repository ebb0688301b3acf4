"""A tile of a mesh with so many rings of faces around it, in the order of the whole."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..filters.compilation import compiled
from .columns import Column
from .division import Floats, Longs
from .surface import FACE, Surface

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
    """The cells that are known so far, their vertices numbered in the order in which cells became known, and the faces."""

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        cells = len(surface.cells.starts) - 1
        self.base = np.full(cells, -1, np.int64)
        self.loaded = np.zeros(cells, np.bool_)
        self.known: list[NDArray[np.int64]] = []
        self.rings = np.empty(0, np.int16)
        self.cell_of = np.empty(0, np.int32)
        self.faces = np.empty(0, FACE)  # their corners by the numbers of here
        self.inside = [np.empty(0, FACE)]  # those all of whose corners have been reached

    def meet(self, cells: NDArray[np.int64]) -> None:
        """Number the vertices of cells that were not known."""
        new = cells[self.base[cells] < 0]
        if not len(new):
            return
        starts = self.surface.cells.starts
        sizes = starts[new + 1] - starts[new]
        self.base[new] = len(self.rings) + np.append(0, np.cumsum(sizes)[:-1])
        self.known.append(new)
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

    known = np.concatenate(growing.known)
    cells = surface.cells
    ranges = cells.ranges_of(known)
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

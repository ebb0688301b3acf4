"""The entrance of every filter of vertices: the mesh as techniques compute on it."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..compilation import compiled, prange
from ..execution import threads_for
from .arrays import Bools, Floats, Ints, check_movable
from .box import bounding_box, check_healthy, unit_scale


@dataclass(frozen=True, eq=False)
class Whole:
    """The mesh that a part was cut from, as far as the part has to know it to give the same bits.

    Attributes:
        low: (3,) the lowest coordinates of the vertices that its cells use.
        high: (3,) their highest.
    """

    low: Floats
    high: Floats

    @property
    def diagonal(self) -> float:
        """Of the box."""
        scale = unit_scale(self.low, self.high)
        return float(np.linalg.norm(self.high * scale - self.low * scale)) / scale


@dataclass(frozen=True, eq=False)
class NormalisedMesh:
    """The vertices that a face or an edge uses, about the origin, of ordinary size, in an order of choice.

    Point k is ``(vertices[order[k]] - middle) * scale``. Vertices that nothing uses have no point: wherever they lie, they change
    no bit of the result. Squares and fourth powers of lengths of the points are ordinary numbers, and a mesh far from the origin
    loses no digits to sums.

    Attributes:
        vertices: (n, 3) the vertices as they came in.
        middle: (3,) the middle of the box of the used vertices.
        scale: a power of two that brings the longest side of that box to between 1/4 and 1.
        order: (k,) the vertex of each point; None if the points are all vertices in the given order.
        cells_in_vertices: (m, 3) triangles or (e, 2) edges, in numbers of vertices; none names a vertex without a point.
        movable_vertices: (n,) which vertices may move; None for all.
        is_part: whether it was cut from a larger mesh; then the vertices around its cut are of no use, and not checked.
    """

    vertices: Floats
    middle: Floats
    scale: float
    order: Ints | None
    cells_in_vertices: Ints
    movable_vertices: Bools | None
    is_part: bool = False

    @cached_property
    def points(self) -> Floats:
        """(k, 3) the points."""
        points = np.empty((len(self), 3))
        with threads_for(len(points)):
            _normalise(self.vertices, self.middle, self.scale, self._listed, points)
        return points

    @cached_property
    def cells(self) -> Ints:
        """(m, 3) triangles or (e, 2) edges, in numbers of points."""
        if self.order is None:
            return self.cells_in_vertices
        number = np.empty(len(self.vertices), dtype=np.int32)
        number[self.order] = np.arange(len(self.order), dtype=np.int32)
        cells: Ints = number[self.cells_in_vertices]
        return cells

    @cached_property
    def movable(self) -> Bools | None:
        """(k,) which points may move; None for all."""
        if self.movable_vertices is None or self.order is None:
            return self.movable_vertices
        movable: Bools = self.movable_vertices[self.order]
        return movable

    @property
    def used(self) -> Ints:
        """(k,) the vertex of each point."""
        return np.arange(len(self.vertices), dtype=np.int32) if self.order is None else self.order

    def __len__(self) -> int:
        """The number k of points."""
        return len(self.vertices) if self.order is None else len(self.order)

    def in_order(self, places: Ints | None) -> "NormalisedMesh":
        """The same mesh, its point k the point ``places[k]`` of this one; None changes nothing.

        Args:
            places: (k,) a permutation.
        """
        if places is None:
            return self
        return replace(self, order=places if self.order is None else self.order[places])

    def restored(self, points: Floats) -> Floats:
        """(n, 3) the vertices, moved as their points have moved to the (k, 3) given ones.

        Coordinates whose point has not moved keep every bit. The others are rounded once: far from the origin that is all that is
        lost.

        Raises:
            FilterInputError: a point has moved by more than `box.FURTHEST` diagonals, or to nowhere.
        """
        if len(self) and not self.is_part:
            low, high = bounding_box(self.points)
            check_healthy(self.points, points, float(np.linalg.norm(high - low)), self.order)
        everything_moves = len(self) == len(self.vertices)
        result = np.empty_like(self.vertices) if everything_moves else self.vertices.copy()
        with threads_for(len(points)):
            _restore(self.vertices, self.points, points, self.scale, self._listed, result)
        return result

    @property
    def _listed(self) -> Ints:
        return np.empty(0, dtype=np.int32) if self.order is None else self.order


def normalised_mesh(
    vertices: Floats, cells: Ints, movable: ArrayLike | None = None, whole: Whole | None = None
) -> NormalisedMesh:
    """A checked mesh, normalised, its points in the order of the vertices.

    Args:
        vertices: (n, 3) coordinates.
        cells: (m, 3) triangles or (e, 2) edges. One that names a vertex twice uses none. Without any cell the vertices are a
            point cloud, and all have a point.
        movable: (n,) bool, which vertices may move; None for all.
        whole: the mesh that this is a part of; None if it is all.

    Raises:
        FilterInputError: `movable` is not a truth value for every vertex.
    """
    mask = None if movable is None else check_movable(movable, len(vertices))
    order = None
    if len(cells):
        used = np.zeros(len(vertices), dtype=np.bool_)
        if _mark_used(cells, used) < len(vertices):
            order = np.flatnonzero(used).astype(np.int32)
            cells = cells[used[cells].all(axis=1)]
    if len(vertices) == 0 or (order is not None and len(order) == 0):
        return NormalisedMesh(vertices, np.zeros(3), 1.0, order, cells, mask)
    if whole is None:
        low, high = bounding_box(vertices if order is None else vertices[order])
    else:
        low, high = whole.low, whole.high
    return NormalisedMesh(vertices, low * 0.5 + high * 0.5, unit_scale(low, high), order, cells, mask, whole is not None)


@compiled
def _mark_used(cells: Ints, used: Bools) -> int:
    """Mark the vertices of cells that name no vertex twice; how many there are."""
    count = 0
    width = cells.shape[1]
    for f in range(cells.shape[0]):
        if count == used.shape[0]:
            break
        proper = True
        for k in range(width):
            proper &= cells[f, k] != cells[f, (k + 1) % width]
        for k in range(width):
            if proper and not used[cells[f, k]]:
                used[cells[f, k]] = True
                count += 1
    return count


@compiled(parallel=True)
def _normalise(vertices: Floats, middle: Floats, scale: float, order: Ints, points: Floats) -> None:
    for k in prange(points.shape[0]):
        i = order[k] if order.shape[0] else np.int32(k)
        for c in range(3):
            points[k, c] = (vertices[i, c] - middle[c]) * scale


@compiled(parallel=True)
def _restore(vertices: Floats, before: Floats, after: Floats, scale: float, order: Ints, result: Floats) -> None:
    for k in prange(before.shape[0]):
        i = order[k] if order.shape[0] else np.int32(k)
        for c in range(3):
            moved = after[k, c] - before[k, c]
            # Adding 0 would turn a coordinate of -0.0 into 0.0.
            result[i, c] = vertices[i, c] + moved / scale if moved != 0.0 else vertices[i, c]

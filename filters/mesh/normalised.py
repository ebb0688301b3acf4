"""Normalised meshes: about the origin, of ordinary size, without unused vertices; every filter of vertices begins with one."""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..compilation import compiled, prange
from ..execution import threads_for
from .arrays import Bools, Floats, Ints, Longs, check_movable
from .ordering import order_by_place, order_of_faces

#: Points in a block.
_BLOCK = 4096
# Triangles are sorted by their lowest point over this, rounded down.
_RUN = 64
#: The most diagonals of the mesh by which a filter may move a vertex: further it is a spike, the result of equations that were
#: too ill-conditioned.
FURTHEST = 2.0


@dataclass(frozen=True, eq=False)
class Whole:
    """Properties of the whole mesh that a part of it needs to give the same bits.

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
    """The vertices that a face or an edge uses, about the origin, of ordinary size, in any order.

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
        diagonal: of the box of the points, 0 if there are none.
        has_sorted_cells: whether the cells stand in the order of their lowest points, by and large, or as they came in.
        is_part: whether it was cut from a larger mesh; then the vertices around its cut are of no use, and not checked.
    """

    vertices: Floats
    middle: Floats
    scale: float
    order: Ints | None
    cells_in_vertices: Ints
    movable_vertices: Bools | None
    diagonal: float
    has_sorted_cells: bool = False
    is_part: bool = False

    @cached_property
    def points(self) -> Floats:
        """(k, 3) the points, kept."""
        return self.new_points()

    def new_points(self) -> Floats:
        """(k, 3) the points in a new array."""
        points = np.empty((len(self), 3))
        with threads_for(len(points)):
            _normalise(self.vertices, self.middle, self.scale, self._listed, points)
        return points

    @cached_property
    def cells(self) -> Ints:
        """(m, 3) triangles or (e, 2) edges, in numbers of points; kept."""
        return self.numbered_cells()

    def numbered_cells(self) -> Ints:
        """`cells`, not kept."""
        if self.order is None:
            return self.cells_in_vertices
        number = np.empty(len(self.vertices), dtype=np.int32)
        number[self.order] = np.arange(len(self.order), dtype=np.int32)
        cells = np.empty_like(self.cells_in_vertices)
        with threads_for(len(self)):
            _renumber(number, self.cells_in_vertices, cells)
        return cells[order_of_faces(cells, len(self), _RUN)] if self.has_sorted_cells else cells

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

    def by_place(self) -> "NormalisedMesh":
        """The same mesh of triangles, neighbouring points and triangles near each other in memory."""
        points = self.vertices if self.order is None else self.vertices[self.order]  # not `points`, whose memory would be new
        places = order_by_place(points, self.cells, self.middle, self.scale)
        return replace(self.in_order(places), has_sorted_cells=True)

    def in_order(self, places: Ints | None) -> "NormalisedMesh":
        """The same mesh, its point k the point ``places[k]`` of this one, for a (k,) permutation; None changes nothing."""
        if places is None:
            return self
        return replace(self, order=places if self.order is None else self.order[places])

    def restored(self, points: Floats) -> Floats:
        """(n, 3) the vertices, moved as far as their points lie from the (k, 3) new ones.

        Coordinates whose point has not moved keep every bit. The others are rounded once: far from the origin that is all that is
        lost.

        Raises:
            FilterInputError: a point has moved by more than `FURTHEST` diagonals, or is not finite.
        """
        everything_moves = len(self) == len(self.vertices)
        result = np.empty_like(self.vertices) if everything_moves else self.vertices.copy()
        with threads_for(len(points)):
            blocks = -(-len(points) // _BLOCK)
            furthest, squares = np.zeros(blocks, dtype=np.int64), np.zeros(blocks)
            _restore(self.vertices, self.middle, self.scale, self._listed, points, result, furthest, squares)
        if len(points) and not self.is_part:
            block = int(squares.argmax())  # the first NaN, if there is one
            refuse_spike(int(furthest[block]), math.sqrt(squares[block]), self.diagonal, self.order)
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
        _mark_used(cells, used)
        if not used.all():
            order = np.flatnonzero(used).astype(np.int32)
            cells = cells[used[cells].all(axis=1)]
    if len(vertices) == 0 or (order is not None and len(order) == 0):
        return NormalisedMesh(vertices, np.zeros(3), 1.0, order, cells, mask, 0.0)
    if whole is None:
        low, high = bounding_box(vertices if order is None else vertices[order])
    else:
        low, high = whole.low, whole.high
    middle, scale = low * 0.5 + high * 0.5, unit_scale(low, high)
    diagonal = float(np.linalg.norm((high - middle) * scale - (low - middle) * scale))
    return NormalisedMesh(vertices, middle, scale, order, cells, mask, diagonal, is_part=whole is not None)


@compiled
def _mark_used(cells: Ints, used: Bools) -> None:
    """Mark the vertices of triangles or edges that name no vertex twice."""
    last = cells.shape[1] - 1
    for f in range(cells.shape[0]):
        # Unsigned: for signed indices the compiler adds the test whether they count from the end.
        a, b, c = np.uint64(cells[f, 0]), np.uint64(cells[f, 1]), np.uint64(cells[f, last])
        if a != b and a != c and (b != c or last == 1):
            used[a] = used[b] = used[c] = True


@compiled(parallel=True)
def _normalise(vertices: Floats, middle: Floats, scale: float, order: Ints, points: Floats) -> None:
    for k in prange(points.shape[0]):
        i = order[k] if order.shape[0] else np.int32(k)
        for c in range(3):
            points[k, c] = (vertices[i, c] - middle[c]) * scale


@compiled(parallel=True)
def _renumber(number: Ints, cells: Ints, renumbered: Ints) -> None:
    for f in prange(cells.shape[0]):
        for k in range(cells.shape[1]):
            renumbered[f, k] = number[cells[f, k]]


@compiled(parallel=True)
def _restore(
    vertices: Floats,
    middle: Floats,
    scale: float,
    order: Ints,
    after: Floats,
    result: Floats,
    furthest: Longs,
    squares: Floats,
) -> None:
    """Writes the vertices; for every block the point that moves furthest, or the first that is not finite, and its square."""
    for block in prange(squares.shape[0]):
        for k in range(block * _BLOCK, min((block + 1) * _BLOCK, after.shape[0])):
            i = order[k] if order.shape[0] else np.int32(k)
            squared = 0.0
            for c in range(3):
                moved = after[k, c] - (vertices[i, c] - middle[c]) * scale
                squared += moved * moved
                # Adding 0 would turn a coordinate of -0.0 into 0.0.
                result[i, c] = vertices[i, c] + moved / scale if moved != 0.0 else vertices[i, c]
            if not squared <= squares[block] and squares[block] == squares[block]:
                furthest[block], squares[block] = k, squared


def scaled_to_unit(vertices: Floats) -> tuple[Floats, float]:
    """The vertices times a power of two that brings the longest side of their box to between 1/4 and 1, and that power.

    A power of two changes no digit of a coordinate. A mesh without extent keeps its size.
    """
    scale = unit_scale(*bounding_box(vertices)) if len(vertices) else 1.0
    return (vertices, 1.0) if scale == 1.0 else (vertices * scale, scale)


def unit_scale(low: Floats, high: Floats) -> float:
    """The power of two of `scaled_to_unit`, for a box between two corners."""
    # Halved first: the extent of coordinates near the largest number would overflow.
    half = float((high * 0.5 - low * 0.5).max())
    if half == 0.0:
        return 1.0
    return math.ldexp(1.0, min(max(-math.frexp(half)[1] - 1, -1000), 1000))


def bounding_box(vertices: Floats) -> tuple[Floats, Floats]:
    """(3,) the lowest and (3,) the highest coordinates of (n, 3) vertices, n at least 1."""
    low, high = vertices[0].copy(), vertices[0].copy()
    _widen(vertices, low, high)
    return low, high


def check_healthy(before: Floats, after: Floats, diagonal: float, numbers: Ints | None = None, advice: str = "") -> None:
    """Refuse a result in which a vertex lies further than `FURTHEST` diagonals from where it was: a spike.

    The vertices are of ordinary size, and belong to what has a box of this diagonal; 0 is for any distance. Messages name them by
    the (n,) numbers, or 0, 1, 2 ..., and give the advice.

    Raises:
        FilterInputError: one moves too far, or is not finite; the message names it.
    """
    squares = np.square(after - before).sum(axis=1)
    k = int(squares.argmax()) if len(squares) else 0  # the first NaN, if there is one
    refuse_spike(k, math.sqrt(squares[k]) if len(squares) else 0.0, diagonal, numbers, advice)


def refuse_spike(k: int, length: float, diagonal: float, numbers: Ints | None = None, advice: str = "") -> None:
    """Raises the error of `check_healthy` if vertex k, which moves furthest, moves too far by `length`."""
    if diagonal == 0.0 or length <= FURTHEST * diagonal:
        return
    raise FilterInputError(
        f"vertex {k if numbers is None else int(numbers[k])} would be moved by {length / diagonal:.3g} diagonals of the mesh "
        f"({FURTHEST:g} are the most), as the triangles around it are too irregular; "
        f"{advice or 'improve them first, or smooth less'}"
    )


def spikes(before: Floats, after: Floats, diagonal: float) -> Bools:
    """(n,) which vertices `check_healthy` refuses."""
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(~(np.linalg.norm(after - before, axis=1) <= FURTHEST * diagonal))


@compiled
def _widen(vertices: Floats, low: Floats, high: Floats) -> None:
    # Three scalars each: numpy reduces along rows of three an order of magnitude more slowly.
    x0, y0, z0 = low
    x1, y1, z1 = high
    for i in range(vertices.shape[0]):
        x, y, z = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        x0, y0, z0 = min(x0, x), min(y0, y), min(z0, z)
        x1, y1, z1 = max(x1, x), max(y1, y), max(z1, z)
    low[0], low[1], low[2] = x0, y0, z0
    high[0], high[1], high[2] = x1, y1, z1

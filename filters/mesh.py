"""Meshes as arrays: types, checks of input, normalised meshes, and vertex orders that put neighbours near each other in memory.

A filter begins with a normalised mesh: centred, without unused vertices, of ordinary size (longest side of its box 1/2 to 1).
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .checks import FilterInputError
from .compilation import compiled, prange
from .execution import threads_for

__all__ = [
    "Bools",
    "Floats",
    "Ints",
    "Longs",
    "NormalisedMesh",
    "Whole",
    "bounding_box",
    "check_edges",
    "check_healthy",
    "check_mesh",
    "check_movable",
    "check_points",
    "check_vertex_mask",
    "mask_of",
    "normalised_mesh",
    "order_by_place",
    "order_of_faces",
    "scaled_to_unit",
    "spikes",
    "unit_scale",
    "worth_reordering",
]

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Longs: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]
#: The type of indices and bit fields in kernels: for signed indices the compiler adds a test for negative values.
Index: Any = np.uint64

#: The number of points in a block of `_restore`; one thread does a whole block.
_BLOCK = 4096
_RUN = 64  # see `order_of_faces`
#: The largest displacement of a vertex by a filter, in diagonals of the mesh. A vertex that moves farther is a spike, the result
#: of ill-conditioned equations.
FURTHEST = 2.0
_IRREGULAR = "the mesh is too irregular there, or a step too long: improve the mesh first, or smooth less"
# Points are near in memory if their numbers differ by at most this; all points near one point take 0.4 MB of a cache.
NEAR = 8192
_SAMPLE = 20_000  # number of triangles that are sampled
# A reordering takes as much time as it saves in this many sweeps over all one-rings, as measured.
_SWEEPS_A_REORDERING_COSTS = 8
# The thickness of a slab of `order_by_place` in median edges, and the most slabs in a direction.
_THICK, _MOST_SLABS = 2.0, 4096
# The slabs ignore this share of the points at either end, so that a few far points do not make slabs thick.
_STRAY = 0.01
#: With fewer vertices the processor's caches hold most operands of a sweep, whatever the order of the vertices.
FITS_IN_CACHE = 200_000


def check_mesh(vertices: ArrayLike, faces: ArrayLike) -> tuple[Floats, Ints]:
    """Returns the mesh as (n, 3) float64 and (m, 3) int32, both C-contiguous; such arrays are not copied.

    Raises `FilterInputError` for a wrong shape or type, too many vertices, a coordinate that is not finite, and an index that
    names no vertex. In the last two cases the message gives the first wrong row and the number of wrong rows.
    """
    points = check_points(vertices)
    return points, _checked_cells("face", "(m, 3)", 3, faces, len(points), "; triangulate polygons first")


def check_edges(edges: ArrayLike, n_vertices: int) -> Ints:
    """Returns the edges of polylines as (e, 2) int32, checked like the faces of `check_mesh`."""
    return _checked_cells("edge", "(e, 2)", 2, edges, n_vertices)


def _checked_cells(cell: str, shape: str, corners: int, values: ArrayLike, n_vertices: int, advice: str = "") -> Ints:
    cells = np.asarray(values)
    if cells.size == 0:
        return np.empty((0, corners), dtype=np.int32)
    if cells.ndim != 2 or cells.shape[1] != corners or not np.issubdtype(cells.dtype, np.integer):
        raise FilterInputError(
            f"{cell}s must be an {shape} array of whole numbers, got shape {cells.shape} of {cells.dtype}{advice}"
        )
    if cells.min() < 0 or cells.max() >= n_vertices:
        bad = ((cells < 0) | (cells >= n_vertices)).any(axis=1)
        first = int(bad.argmax())
        raise FilterInputError(
            f"{cell} {first} is {cells[first].tolist()}, but the vertices are 0 to {n_vertices - 1} ({int(bad.sum())} such "
            f"{cell}s of {len(cells)}): remove these {cell}s or add the vertices"
        )
    return np.ascontiguousarray(cells, dtype=np.int32)


def check_points(
    vertices: ArrayLike, one: str = "vertex", several: str = "vertices", remedy: str = "remove these vertices first"
) -> Floats:
    """Returns the rows as (n, 3) float64, checked like the vertices of `check_mesh`; errors use `one`, `several` and `remedy`."""
    raw = np.asarray(vertices)
    if raw.size == 0:
        return np.empty((0, 3))
    if raw.ndim != 2 or raw.shape[1] != 3 or raw.dtype.kind not in "fiu":
        raise FilterInputError(f"{several} must be an (n, 3) array of real numbers, got shape {raw.shape} of {raw.dtype}")
    points = np.ascontiguousarray(raw, dtype=np.float64)
    if len(points) > np.iinfo(np.int32).max:
        raise FilterInputError(f"{len(points)} {several} are more than the 2,147,483,647 that an index of 32 bits reaches")
    if not np.isfinite(points).all():
        bad = ~np.isfinite(points).all(axis=1)
        first = int(bad.argmax())
        raise FilterInputError(
            f"{one} {first} is {points[first].tolist()}: {int(bad.sum())} of {len(points)} {several} have a coordinate that is "
            f"not finite; {remedy}"
        )
    return points


def mask_of(indices: NDArray[np.integer], count: int) -> Bools:
    """(count,) which numbers from 0 to count - 1 are among the indices, an array of any shape."""
    mask = np.zeros(count, dtype=np.bool_)
    mask[indices] = True
    return mask


def check_movable(movable: ArrayLike | None, n_vertices: int) -> Bools:
    """(n,) which vertices may move: all of them for None; `FilterInputError` unless there is one truth value for each vertex."""
    return np.ones(n_vertices, dtype=np.bool_) if movable is None else check_vertex_mask("movable", movable, n_vertices)


def check_vertex_mask(name: str, values: ArrayLike, n_vertices: int) -> Bools:
    """(n,) the values; `FilterInputError`, with the parameter's name, unless there is one truth value for each vertex."""
    mask = np.asarray(values)
    if mask.dtype != np.bool_ or mask.shape != (n_vertices,):
        raise FilterInputError(
            f"{name} must be a boolean array of {n_vertices} values, one per vertex, got shape {mask.shape} of {mask.dtype}"
        )
    return mask


@dataclass(frozen=True, eq=False)
class Whole:
    """The properties of a whole mesh; with them a filter on a part of the mesh gives the same bits as on the whole."""

    sampled: ClassVar[int] = _SAMPLE  # number of cells in a sample, see `place_if_far`
    low: Floats  # (3,) the lowest coordinates of the vertices that its cells use
    high: Floats  # (3,) the highest coordinates of these vertices

    @property
    def diagonal(self) -> float:
        return float(np.linalg.norm(self.high * self.scale - self.low * self.scale)) / self.scale

    @property
    def scale(self) -> float:
        return unit_scale(self.low, self.high)

    def place_if_far(self, corners: Floats) -> Floats | None:
        """Returns the corners' median if a vertex is so far away that over a quarter of the edges lose over half of their digits.

        `corners` (m, k, 3) are those of a sample of cells. With u = 2^-53, an edge of length e at a vertex v has e / (u |v|)
        rounding units, and e / (u |p|) at p, the centred v. If e |v| < u |p|^2, the second is below the root of the first.
        """
        corners, middle = corners * self.scale, self.low * 0.5 + self.high * 0.5
        before, after = (np.abs(at).max(axis=(1, 2)) for at in (corners, corners - middle * self.scale))
        edges = np.abs(corners - np.roll(corners, 1, axis=1)).max(axis=2)
        lost = edges * before[:, None] < np.finfo(float).eps / 2 * after[:, None] ** 2
        is_far = 4 * np.count_nonzero(lost & (edges > 0.0)) > np.count_nonzero(edges)
        return np.median(corners.reshape(-1, 3), axis=0) / self.scale if is_far else None

    @staticmethod
    def far_vertex(number: int, place: Floats) -> FilterInputError:
        return FilterInputError(
            f"vertex {number} at {place.tolist()} is so far from the others that the edges between them lose more than half of "
            "their digits: remove it first, and others like it"
        )

    def farthest(self, vertices: Floats, place: Floats) -> tuple[float, int]:
        """Returns the largest absolute coordinate of the vectors from a place to the vertices, times `scale`, and that vertex."""
        away = np.abs(vertices * self.scale - place * self.scale).max(axis=1)
        return float(away.max()), int(away.argmax())


@dataclass(frozen=True, eq=False)
class NormalisedMesh:
    """The vertices that a face or an edge uses (in a point cloud: all), centred at the origin, of ordinary size, in any order.

    Point k is ``(vertices[order[k]] - middle) * scale``. Unused vertices have no point: wherever they lie, they change no bit of
    the result. Squares and fourth powers of the points' distances do not overflow, and sums over a mesh far from the origin lose
    no digits.
    """

    vertices: Floats  # (n, 3) as they came in
    middle: Floats  # (3,) the middle of the box of the used vertices
    scale: float  # a power of two that brings the longest side of that box to between 1/2 and 1
    order: Ints | None  # (k,) the vertex of each point; None if the points are all vertices in the given order
    cells_in_vertices: Ints  # (m, 3) triangles or (e, 2) edges, as indices of vertices, all of which have a point
    movable_vertices: Bools | None  # (n,) which vertices may move; None for all
    diagonal: float  # of the points' bounding box, 0 without points
    has_sorted_cells: bool = False  # whether cells are roughly sorted by their lowest point number; else in the input's order
    is_part: bool = False  # whether a larger mesh around it gave `middle`, `scale`, `diagonal`; `restored` then checks nothing

    @cached_property
    def points(self) -> Floats:
        """(k, 3) the points."""
        return self.new_points()

    def new_points(self) -> Floats:
        """(k, 3) the points in a new array."""
        points = np.empty((len(self), 3))
        with threads_for(len(self)):
            _normalise(self.vertices, self.middle, self.scale, self._listed, points)
        return points

    @cached_property
    def cells(self) -> Ints:
        """(m, 3) triangles or (e, 2) edges, as indices of points."""
        return self.numbered_cells()

    def numbered_cells(self) -> Ints:
        """Returns `cells` without caching them."""
        if self.order is None:
            return self.cells_in_vertices
        number = np.empty(len(self.vertices), dtype=np.int32)
        number[self.order] = np.arange(len(self.order), dtype=np.int32)
        cells: Ints = number.take(self.cells_in_vertices)
        return cells.take(order_of_faces(cells, len(self), _RUN), axis=0) if self.has_sorted_cells else cells

    @cached_property
    def movable(self) -> Bools | None:
        """(k,) which points may move; None for all."""
        if self.movable_vertices is None or self.order is None:
            return self.movable_vertices
        return np.asarray(self.movable_vertices[self.order])

    @property
    def used(self) -> Ints:
        """(k,) the vertex of each point."""
        return np.arange(len(self.vertices), dtype=np.int32) if self.order is None else self.order

    def __len__(self) -> int:
        return len(self.vertices) if self.order is None else len(self.order)

    def by_place(self) -> "NormalisedMesh":
        """Returns the same mesh of triangles in the orders of `order_by_place` and `order_of_faces`."""
        return replace(self.in_order(order_by_place(self.points, self.cells)), has_sorted_cells=True)

    def in_order(self, places: Ints | None) -> "NormalisedMesh":
        """Returns the same mesh with the point ``places[k]`` as point k, for a (k,) permutation; None changes nothing."""
        if places is None:
            return self
        return replace(self, order=places if self.order is None else self.order[places])

    def restored(self, points: Floats) -> Floats:
        """Returns (n, 3) the vertices, each moved like its point; the (k, 3) `points` are the new places of the points.

        Coordinates that do not move keep every bit. Coordinates that move are rounded only once, even far from the origin. Raises
        `FilterInputError` if a point has moved by more than `FURTHEST` diagonals or is not finite.
        """
        result = np.empty_like(self.vertices) if len(self) == len(self.vertices) else self.vertices.copy()
        with threads_for(len(points)):
            blocks = -(-len(points) // _BLOCK)
            furthest, squares = np.zeros(blocks, dtype=np.int64), np.zeros(blocks)
            _restore(self.vertices, self.middle, self.scale, self._listed, points, result, furthest, squares)
        if len(points) and not self.is_part:
            block = int(squares.argmax())  # the first NaN, if there is one
            refuse_spike(int(furthest[block]), math.sqrt(squares[block]), self.diagonal, self.order)
        return result

    def check_far(self) -> None:
        """Refuses a mesh that has a far vertex, see `Whole.place_if_far`. In a cloud, edges join successive points."""
        cells, count = self.cells_in_vertices, len(self.cells_in_vertices) or len(self) - 1
        chosen = np.arange(0, count, max(1, count // _SAMPLE))
        vertices = self.vertices if self.order is None else self.vertices[self.order]
        whole = Whole(*bounding_box(vertices)) if count > 0 else Whole(np.zeros(3), np.zeros(3))
        place = whole.place_if_far(self.vertices[cells[chosen] if len(cells) else chosen[:, None] + [0, 1]])
        if place is not None:
            i = int(self.used[whole.farthest(vertices, place)[1]])
            raise Whole.far_vertex(i, self.vertices[i])

    @property
    def _listed(self) -> Ints:
        return np.empty(0, dtype=np.int32) if self.order is None else self.order


def normalised_mesh(
    vertices: Floats, cells: Ints, movable: ArrayLike | None = None, whole: Whole | None = None
) -> NormalisedMesh:
    """Normalises a checked mesh of (n, 3) vertices and (m, 3) triangles or (e, 2) edges; points have the order of the vertices.

    A cell that names a vertex twice uses no vertex. Without cells the vertices are a point cloud, and all have a point. `movable`
    (n,) says which vertices may move, None for all; `whole` has the properties of the mesh of which this mesh is a part.
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
    box = whole or Whole(*bounding_box(vertices if order is None else vertices[order]))
    middle, scale = box.low * 0.5 + box.high * 0.5, box.scale
    diagonal = float(np.linalg.norm((box.high - middle) * scale - (box.low - middle) * scale))
    return NormalisedMesh(vertices, middle, scale, order, cells, mask, diagonal, is_part=whole is not None)


@compiled
def _mark_used(cells: Ints, used: Bools) -> None:
    """Marks the vertices of triangles or edges that name no vertex twice."""
    last = cells.shape[1] - 1
    for f in range(cells.shape[0]):
        a, b, c = Index(cells[f, 0]), Index(cells[f, 1]), Index(cells[f, last])
        if a != b and a != c and (b != c or last == 1):
            used[a] = used[b] = used[c] = True


@compiled(parallel=True)
def _normalise(vertices: Floats, middle: Floats, scale: float, order: Ints, points: Floats) -> None:
    for k in prange(points.shape[0]):
        i = order[k] if order.shape[0] else np.int32(k)
        for c in range(3):
            points[k, c] = (vertices[i, c] - middle[c]) * scale


@compiled(parallel=True)
def _restore(
    vertices: Floats, middle: Floats, scale: float, order: Ints, after: Floats, result: Floats, furthest: Longs, squares: Floats
) -> None:
    """Writes the vertices, and for each block the point that moved furthest (or the first NaN) and its squared displacement."""
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
    """Scales the vertices so that the longest side of their box is between 1/2 and 1; returns them and the factor.

    The factor is a power of two, which changes no digit of a coordinate. A mesh without extent keeps its size.
    """
    scale = unit_scale(*bounding_box(vertices)) if len(vertices) else 1.0
    return (vertices, 1.0) if scale == 1.0 else (vertices * scale, scale)


def unit_scale(low: Floats, high: Floats) -> float:
    """The factor of `scaled_to_unit`, for a bounding box with these corners."""
    # Halved first, because the extent of coordinates near the largest number would overflow.
    half = float((high * 0.5 - low * 0.5).max())
    if half == 0.0:
        return 1.0
    return math.ldexp(1.0, min(max(-math.frexp(half)[1] - 1, -1000), 1000))


def bounding_box(vertices: Floats) -> tuple[Floats, Floats]:
    """(3,) the lowest and (3,) the highest coordinates of (n, 3) vertices, n at least 1."""
    low, high = vertices[0].copy(), vertices[0].copy()
    _widen(vertices, low, high)
    return low, high


@compiled
def _widen(vertices: Floats, low: Floats, high: Floats) -> None:
    # Scalars, because NumPy reduces rows of three an order of magnitude more slowly.
    (x0, y0, z0), (x1, y1, z1) = low, high
    for i in range(vertices.shape[0]):
        x, y, z = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        x0, y0, z0 = min(x0, x), min(y0, y), min(z0, z)
        x1, y1, z1 = max(x1, x), max(y1, y), max(z1, z)
    low[0], low[1], low[2] = x0, y0, z0
    high[0], high[1], high[2] = x1, y1, z1


def check_healthy(before: Floats, after: Floats, diagonal: float, numbers: Ints | None = None, cause: str = _IRREGULAR) -> None:
    """Raises `FilterInputError` if a vertex has moved by more than `FURTHEST` diagonals, which makes a spike, or is not finite.

    With a `diagonal` of 0 nothing is checked. The message names the vertex by its number, if given, and ends with the `cause`.
    """
    squares = np.square(after - before).sum(axis=1)
    k = int(squares.argmax()) if len(squares) else 0  # the first NaN, if there is one
    refuse_spike(k, math.sqrt(squares[k]) if len(squares) else 0.0, diagonal, numbers, cause)


def refuse_spike(k: int, length: float, diagonal: float, numbers: Ints | None = None, cause: str = _IRREGULAR) -> None:
    """Raises the error of `check_healthy` if `length`, the displacement of vertex k, is too large."""
    if diagonal == 0.0 or length <= FURTHEST * diagonal:
        return
    raise FilterInputError(
        f"vertex {k if numbers is None else int(numbers[k])} would be moved by {length / diagonal:.3g} diagonals of the "
        f"bounding box ({FURTHEST:g} are the most), as {cause}"
    )


def spikes(before: Floats, after: Floats, diagonal: float) -> Bools:
    """(n,) which vertices `check_healthy` refuses, for a diagonal above 0."""
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(~(np.linalg.norm(after - before, axis=1) <= FURTHEST * diagonal))


def worth_reordering(faces: Ints, n_vertices: int, sweeps: float = math.inf, *, size: int = 1) -> bool:
    """Whether `sweeps` sweeps over the one-rings save more time after a reordering than the reordering takes.

    `size` is how much a kernel reads for a vertex and its faces, in units of three coordinates.
    """
    if n_vertices * size < FITS_IN_CACHE or len(faces) == 0 or sweeps < _SWEEPS_A_REORDERING_COSTS:
        return False
    sample = faces[:: max(1, len(faces) // _SAMPLE)].astype(np.int64)
    return bool((np.abs(sample[:, 0] - sample[:, 1]) * size > NEAR).mean() > 0.25)


def order_by_place(points: Floats, faces: Ints) -> Ints:
    """(n,) a permutation: sorts the points by slabs along the longest side of their box, then the next side, then the shortest.

    The points are of ordinary size, with at least one triangle. In a breadth-first order sweeps over a surface would be a
    quarter faster, but finding it takes longer than this sort.
    """
    sample = faces[:: max(1, len(faces) // _SAMPLE)]
    starts = points[sample[:, 0]]
    edge = float(np.median(np.linalg.norm(starts - points[sample[:, 1]], axis=1)))
    low, high = np.quantile(starts, (_STRAY, 1.0 - _STRAY), axis=0)
    slabs = []  # slab numbers of 16 bits, which NumPy sorts by counting
    for axis in np.argsort(high - low, kind="stable"):
        count = min(_MOST_SLABS, 1 + int((high[axis] - low[axis]) / (_THICK * edge))) if edge > 0.0 else 1
        if count > 1:
            per_length = count / (high[axis] - low[axis])
            slabs.append(np.clip((points[:, axis] - low[axis]) * per_length, 0.0, count - 1.0).astype(np.uint16))
    return np.asarray(np.lexsort(slabs) if slabs else np.arange(len(points)), dtype=np.int32)


def order_of_faces(faces: Ints, n_vertices: int, run: int = 1) -> Ints:
    """(m,) a permutation: sorts the triangles by the lowest number of their vertices, divided by `run` and rounded down."""
    lowest = np.minimum(np.minimum(faces[:, 0], faces[:, 1]), faces[:, 2]) // np.int32(run)
    halves = lowest.astype(np.uint16), (lowest >> 16).astype(np.uint16)  # 16-bit numbers, which NumPy sorts by counting
    return np.lexsort(halves if n_vertices > run << 16 else halves[:1]).astype(np.int32)

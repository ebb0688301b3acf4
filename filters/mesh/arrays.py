"""A mesh as arrays: their types, and the checks of input."""

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..checks import FilterInputError

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Longs: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]


def check_mesh(vertices: ArrayLike, faces: ArrayLike) -> tuple[Floats, Ints]:
    """The mesh as (n, 3) float64 and (m, 3) int32, both C-contiguous and not copied when they are so already.

    Raises:
        FilterInputError: a wrong shape or type, a coordinate that is not finite, an index that names no vertex; the message
            gives the first of them and their number.
    """
    points = check_points(vertices)
    return points, _checked_cells("face", "(m, 3)", 3, faces, len(points), "; triangulate polygons first")


def check_edges(edges: ArrayLike, n_vertices: int) -> Ints:
    """The edges of polylines as (e, 2) int32, C-contiguous and not copied when they are so already.

    Raises:
        FilterInputError: a wrong shape or type, an index that names no vertex; the message gives the first and their number.
    """
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


def check_points(vertices: ArrayLike) -> Floats:
    """The points as (n, 3) float64, C-contiguous, not copied when they are so already.

    Raises:
        FilterInputError: a wrong shape or type, or a coordinate that is not finite.
    """
    raw = np.asarray(vertices)
    if raw.size == 0:
        return np.empty((0, 3))
    if raw.ndim != 2 or raw.shape[1] != 3 or raw.dtype.kind not in "fiu":
        raise FilterInputError(f"vertices must be an (n, 3) array of real numbers, got shape {raw.shape} of {raw.dtype}")
    points = np.ascontiguousarray(raw, dtype=np.float64)
    if len(points) > np.iinfo(np.int32).max:
        raise FilterInputError(f"{len(points)} vertices are more than the 2,147,483,647 that an index of 32 bits reaches")
    if not np.isfinite(points).all():
        bad = ~np.isfinite(points).all(axis=1)
        first = int(bad.argmax())
        raise FilterInputError(
            f"vertex {first} is {points[first].tolist()}: {int(bad.sum())} of {len(points)} vertices have a coordinate that is "
            "not finite; remove these vertices first"
        )
    return points


def mask_of(indices: NDArray[np.integer] | Bools, count: int) -> Bools:
    """(count,) whether each number is among the indices, an array of any shape."""
    mask = np.zeros(count, dtype=np.bool_)
    mask[indices] = True
    return mask


def check_movable(movable: ArrayLike | None, n_vertices: int) -> Bools:
    """(n,) which vertices may move: all of them for None.

    Raises:
        FilterInputError: not a truth value for every vertex.
    """
    return np.ones(n_vertices, dtype=np.bool_) if movable is None else check_vertex_mask("movable", movable, n_vertices)


def check_vertex_mask(name: str, values: ArrayLike, n_vertices: int) -> Bools:
    """(n,) one truth value for each vertex; errors name the parameter `name`.

    Raises:
        FilterInputError: not a truth value for every vertex.
    """
    mask = np.asarray(values)
    if mask.dtype != np.bool_ or mask.shape != (n_vertices,):
        raise FilterInputError(
            f"{name} must be a boolean array of {n_vertices} values, one a vertex, got shape {mask.shape} of {mask.dtype}"
        )
    return mask

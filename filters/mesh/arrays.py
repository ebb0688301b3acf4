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
    triangles = np.asarray(faces)
    if triangles.size == 0:
        return points, np.empty((0, 3), dtype=np.int32)
    if triangles.ndim != 2 or triangles.shape[1] != 3 or not np.issubdtype(triangles.dtype, np.integer):
        raise FilterInputError(
            f"faces must be an (m, 3) array of whole numbers, got shape {triangles.shape} of {triangles.dtype}; "
            "triangulate polygons first"
        )
    if triangles.min() < 0 or triangles.max() >= len(points):
        bad = ((triangles < 0) | (triangles >= len(points))).any(axis=1)
        first = int(bad.argmax())
        raise FilterInputError(
            f"face {first} is {triangles[first].tolist()}, but the vertices are 0 to {len(points) - 1} "
            f"({int(bad.sum())} such faces of {len(triangles)}): remove these faces or add the vertices"
        )
    return points, np.ascontiguousarray(triangles, dtype=np.int32)


def check_edges(edges: ArrayLike, n_vertices: int) -> Ints:
    """The edges of polylines as (e, 2) int32, C-contiguous and not copied when they are so already.

    Raises:
        FilterInputError: a wrong shape or type, an index that names no vertex; the message gives the first and their number.
    """
    pairs = np.asarray(edges)
    if pairs.size == 0:
        return np.empty((0, 2), dtype=np.int32)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or not np.issubdtype(pairs.dtype, np.integer):
        raise FilterInputError(f"edges must be an (e, 2) array of whole numbers, got shape {pairs.shape} of {pairs.dtype}")
    if pairs.min() < 0 or pairs.max() >= n_vertices:
        bad = ((pairs < 0) | (pairs >= n_vertices)).any(axis=1)
        first = int(bad.argmax())
        raise FilterInputError(
            f"edge {first} is {pairs[first].tolist()}, but the vertices are 0 to {n_vertices - 1} ({int(bad.sum())} such edges "
            f"of {len(pairs)}): remove these edges or add the vertices"
        )
    return np.ascontiguousarray(pairs, dtype=np.int32)


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
    """(n,) one truth value for each vertex.

    Args:
        name: the parameter's name, for the error.
        values: one truth value a vertex.
        n_vertices: how many there are.

    Raises:
        FilterInputError: not a truth value for every vertex.
    """
    mask = np.asarray(values)
    if mask.dtype != np.bool_ or mask.shape != (n_vertices,):
        raise FilterInputError(
            f"{name} must be a boolean array of {n_vertices} values, one a vertex, got shape {mask.shape} of {mask.dtype}"
        )
    return mask

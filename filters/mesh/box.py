"""Meshes of any size, computed at a size where squares and fourth powers of lengths are ordinary numbers."""

import math

import numpy as np

from ..checks import FilterInputError
from ..compilation import compiled
from .arrays import Bools, Floats, Ints

#: diagonals of a mesh that a vertex may be moved by; nothing that smooths, fairs or denoises has a reason to go as far
FURTHEST = 2.0


def scaled_to_unit(vertices: Floats) -> tuple[Floats, float]:
    """The vertices times a power of two that brings the longest side of their box to between 1/4 and 1, and that power.

    A power of two changes no digit of a coordinate. A mesh without extent keeps its size.

    Args:
        vertices: (n, 3) finite coordinates.
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

    Args:
        before: (n, 3) where the vertices were, of ordinary size.
        after: (n, 3) where they are.
        diagonal: of the box of what they belong to, 0 for any distance.
        numbers: (n,) the numbers of the vertices in messages; None for 0, 1, 2 ...
        advice: what to do, after "; ".

    Raises:
        FilterInputError: one lies too far, or nowhere; the message names it.
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

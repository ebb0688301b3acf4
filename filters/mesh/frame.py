"""The frame in which steps are computed: the mesh at the origin, of ordinary size, its vertices in a good order."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from ..execution import threads_for
from .arrays import Floats, Ints
from .box import bounding_box, unit_scale


class Frame(NamedTuple):
    """Point k of the frame is ``(vertices[order[k]] - middle) * scale``.

    Attributes:
        middle: (3,) the middle of the box.
        scale: a power of two that makes the box's longest side a length of ordinary size.
        order: (n,) a permutation, or None for the given order.
    """

    middle: Floats
    scale: float
    order: Ints | None


def ordered_frame(vertices: Floats, order: Ints | None) -> Frame:
    """The frame of (n, 3) vertices, in that order."""
    if len(vertices) == 0:
        return Frame(np.zeros(3), 1.0, None)
    low, high = bounding_box(vertices)
    return Frame(low * 0.5 + high * 0.5, unit_scale(low, high), order)


def enter(vertices: Floats, frame: Frame) -> Floats:
    """(n, 3) the points of the frame."""
    points = np.empty_like(vertices)
    with threads_for(len(vertices)):
        _enter(vertices, frame.middle, frame.scale, _listed(frame), points)
    return points


def leave(vertices: Floats, before: Floats, after: Floats, frame: Frame) -> Floats:
    """(n, 3) the vertices, moved as their points in the frame have moved from `before` to `after`.

    Coordinates that have not moved keep every bit, and the others are rounded once: far from the origin that is all that is lost.
    """
    result = np.empty_like(vertices)
    with threads_for(len(vertices)):
        _leave(vertices, before, after, frame.scale, _listed(frame), result)
    return result


def _listed(frame: Frame) -> Ints:
    return np.empty(0, dtype=np.int32) if frame.order is None else frame.order


@njit(cache=True, parallel=True)
def _enter(vertices: Floats, middle: Floats, scale: float, order: Ints, points: Floats) -> None:
    for k in prange(points.shape[0]):
        i = order[k] if order.shape[0] else np.int32(k)
        for c in range(3):
            points[k, c] = (vertices[i, c] - middle[c]) * scale


@njit(cache=True, parallel=True)
def _leave(vertices: Floats, before: Floats, after: Floats, scale: float, order: Ints, result: Floats) -> None:
    for k in prange(before.shape[0]):
        i = order[k] if order.shape[0] else np.int32(k)
        for c in range(3):
            moved = after[k, c] - before[k, c]
            # Adding 0 would turn a coordinate of -0.0 into 0.0.
            result[i, c] = vertices[i, c] + moved / scale if moved != 0.0 else vertices[i, c]

"""Which triangle, or which dot, is in front at every pixel: a depth buffer, filled one triangle after the other.

It needs no library and no OpenGL, and gives the same pixels on every machine.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..declaration import Floats, Ints
from ..filters.compilation import compiled


class DepthBuffer(NamedTuple):
    """What is in front at each of h x w pixels, row 0 on top.

    Attributes:
        elements: (h, w) the number of the face or dot; -1 where nothing is.
        depths: (h, w) how near it is; -inf where nothing is.
    """

    elements: Ints
    depths: NDArray[np.float64]

    @classmethod
    def empty(cls, height: int, width: int) -> DepthBuffer:
        """One in which nothing is drawn yet."""
        return cls(np.full((height, width), -1, dtype=np.int32), np.full((height, width), -np.inf))


def draw_triangles(buffer: DepthBuffer, screen: Floats, faces: Ints) -> None:
    """Draw triangles into the buffer; of two at the same depth the one with the lower number stays.

    Args:
        buffer: is changed.
        screen: (n, 3) x in pixels from the left, y in pixels from the top, and nearness to the eye.
        faces: (m, 3) triangles, facing either way.
    """
    _draw_triangles(screen, faces, buffer.elements, buffer.depths)


def draw_dots(buffer: DepthBuffer, screen: Floats, radius: float, first: int = 0) -> None:
    """Draw a disc for every point.

    Args:
        buffer: is changed.
        screen: (n, 3) as for `draw_triangles`.
        radius: in pixels.
        first: the number of the first dot.
    """
    _draw_dots(screen, radius, first, buffer.elements, buffer.depths)


@compiled
def _draw_triangles(screen: Floats, faces: Ints, elements: Ints, depths: Floats) -> None:
    height, width = elements.shape
    for f in range(faces.shape[0]):
        ax, ay, az = screen[faces[f, 0]]
        bx, by, bz = screen[faces[f, 1]]
        cx, cy, cz = screen[faces[f, 2]]
        doubled = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if not (doubled != 0.0 and math.isfinite(doubled)):
            continue
        left = max(math.ceil(max(min(ax, bx, cx), 0.0) - 0.5), 0)
        right = min(math.floor(min(max(ax, bx, cx), float(width)) - 0.5), width - 1)
        top = max(math.ceil(max(min(ay, by, cy), 0.0) - 0.5), 0)
        bottom = min(math.floor(min(max(ay, by, cy), float(height)) - 0.5), height - 1)
        for row in range(top, bottom + 1):
            y = row + 0.5
            for column in range(left, right + 1):
                x = column + 0.5
                u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / doubled
                v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / doubled
                w = ((ax - x) * (by - y) - (ay - y) * (bx - x)) / doubled
                if u >= 0.0 and v >= 0.0 and w >= 0.0:
                    depth = u * az + v * bz + w * cz
                    if depth > depths[row, column]:
                        depths[row, column] = depth
                        elements[row, column] = f


@compiled
def _draw_dots(screen: Floats, radius: float, first: int, elements: Ints, depths: Floats) -> None:
    height, width = elements.shape
    for i in range(screen.shape[0]):
        x, y, z = screen[i]
        if not (x > -radius and x < width + radius and y > -radius and y < height + radius):
            continue
        for row in range(max(math.ceil(y - radius - 0.5), 0), min(math.floor(y + radius - 0.5), height - 1) + 1):
            for column in range(max(math.ceil(x - radius - 0.5), 0), min(math.floor(x + radius - 0.5), width - 1) + 1):
                dx, dy = column + 0.5 - x, row + 0.5 - y
                if dx * dx + dy * dy <= radius * radius and z > depths[row, column]:
                    depths[row, column] = z
                    elements[row, column] = first + i

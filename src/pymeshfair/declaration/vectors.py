"""The kinds of parameter that take several numbers: points, directions, colours and matrices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .layer import Floats
from .parameter import Parameter


@dataclass(frozen=True, kw_only=True)
class Point(Parameter):
    """Three coordinates: a position or a direction."""

    kind = "three finite numbers"
    rich_type = xml_type = "RichPosition"
    python_type = tuple[float, float, float]

    def check(self, value: Any) -> tuple[float, float, float]:
        x, y, z = _numbers(self, value, (3,))
        return float(x), float(y), float(z)


@dataclass(frozen=True, kw_only=True)
class Direction(Point):
    """Three coordinates that MeshLab shows as a direction."""

    rich_type = xml_type = "RichDirection"


@dataclass(frozen=True, kw_only=True)
class Color(Parameter):
    """Red, green, blue and opacity, each from 0 to 255."""

    kind = "four whole numbers from 0 to 255 (red, green, blue, opacity)"
    rich_type = xml_type = "RichColor"
    python_type = tuple[int, int, int, int]

    def check(self, value: Any) -> tuple[int, int, int, int]:
        channels = _numbers(self, value, (4,))
        if any(c != int(c) or not 0 <= c <= 255 for c in channels):
            raise self.refusal(value)
        red, green, blue, alpha = (int(c) for c in channels)
        return red, green, blue, alpha


@dataclass(frozen=True, kw_only=True)
class Matrix(Parameter):
    """A 4 x 4 matrix, row by row."""

    kind = "a 4 x 4 matrix of finite numbers"
    rich_type = "RichMatrix44"
    xml_type = "RichMatrix44f"
    python_type = tuple[tuple[float, ...], ...]

    def check(self, value: Any) -> tuple[tuple[float, ...], ...]:
        return tuple(tuple(float(x) for x in row) for row in _numbers(self, value, (4, 4)))


def _numbers(parameter: Parameter, value: Any, shape: tuple[int, ...]) -> Floats:
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):  # rows of different lengths
        raise parameter.refusal(value) from None
    if array.dtype.kind not in "iuf" or array.shape != shape or not np.isfinite(array).all():
        raise parameter.refusal(value)
    return array.astype(np.float64)

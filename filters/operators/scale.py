"""Meshes of any size, computed at a size where squares and fourth powers of lengths are ordinary numbers."""

import math

import numpy as np

from ..topology import Floats


def scaled_to_unit(vertices: Floats) -> tuple[Floats, float]:
    """The vertices times a power of two that brings the longest side of their box to between 1 and 2, and that power.

    A power of two changes no digit of a coordinate. A mesh without extent keeps its size.

    Args:
        vertices: (n, 3) finite coordinates.
    """
    scale = unit_scale(vertices)
    return (vertices, 1.0) if scale == 1.0 else (vertices * scale, scale)


def unit_scale(vertices: Floats) -> float:
    """The power of two of `scaled_to_unit`."""
    if len(vertices) == 0:
        return 1.0
    # Halved first: the extent of coordinates near the largest number would overflow.
    extent = float((vertices.max(axis=0) * 0.5 - vertices.min(axis=0) * 0.5).max())
    if extent == 0.0:
        return 1.0
    return math.ldexp(1.0, int(np.clip(-math.frexp(extent)[1], -1000, 1000)))


def centred_and_scaled(vertices: Floats) -> tuple[Floats, float]:
    """As `scaled_to_unit`, with the middle of the box at the origin, where coordinates are as exact as they can be.

    For points far from the origin, such as geo-referenced ones, compute a displacement here and add it to the original.
    """
    if len(vertices) == 0:
        return vertices, 1.0
    scale = unit_scale(vertices)
    middle = vertices.max(axis=0) * 0.5 + vertices.min(axis=0) * 0.5
    return (vertices - middle) * scale, scale

"""Measures of triangles and loops in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pymeshfair.filters.geometry import (
    angle_at,
    angles_between,
    area_vector,
    corner_angles,
    cross_product,
    cross_products,
    quality_and_normal,
    side_lengths,
    squared_length,
)
from tests.meshes import icosphere, noisy, rotation, single_triangle


def test_the_triangle_with_sides_3_4_5() -> None:
    """Angles of pi / 2 and the arc tangents of 4 / 3 and 3 / 4, a cross product of 12 e_z, a quality of 3 / (sqrt(3) 5 / 2)."""
    points, faces = single_triangle()
    expected = [math.pi / 2, math.atan2(4, 3), math.atan2(3, 4)]
    assert corner_angles(points, faces)[0] == pytest.approx(expected, abs=1e-15)
    assert [angle_at(points, k, (k + 1) % 3, (k + 2) % 3) for k in range(3)] == pytest.approx(expected, abs=1e-15)
    assert cross_product(points, 0, 1, 2) == (0.0, 0.0, 12.0)
    assert cross_products(points, faces).tolist() == [[0.0, 0.0, 12.0]]
    assert [squared_length(points, 0, 1), squared_length(points, 1, 2), squared_length(points, 2, 0)] == [9.0, 25.0, 16.0]
    quality, *normal = quality_and_normal(points, 0, 1, 2)
    assert quality == pytest.approx(3 / (math.sqrt(3) * 2.5), rel=1e-15)
    assert normal == [0.0, 0.0, 1.0]


def test_quality_is_1_for_equilateral_triangles_and_0_without_area() -> None:
    """And the normal of a triangle without area is 0."""
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, math.sqrt(3), 0.0], [4.0, 0.0, 0.0]])
    assert quality_and_normal(points, 0, 1, 2)[0] == pytest.approx(1.0, rel=1e-15)
    assert quality_and_normal(points, 0, 1, 3) == (0.0, 0.0, 0.0, 0.0)


def test_the_angles_of_every_triangle_sum_to_pi() -> None:
    """On a rough sphere, to rounding."""
    angles = corner_angles(*noisy(icosphere(2), 0.05))
    assert angles.sum(axis=1) == pytest.approx(math.pi, rel=1e-14)


def test_small_angles_keep_their_digits() -> None:
    """An angle of 1e-9, which the arc cosine of the cosine takes for 0, is found to 15 digits; opposite vectors are pi apart."""
    east = np.array([[1.0, 0.0, 0.0], [5.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    others = np.array([[math.cos(1e-9), math.sin(1e-9), 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    assert angles_between(east, others) == pytest.approx([1e-9, math.pi, 0.0], rel=1e-15)


def test_the_area_vector_of_a_square_in_any_place() -> None:
    """A square of side 2 seen counter-clockwise has the area vector 4 n wherever it lies, and sides of length 2."""
    square = 2.0 * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    turn = rotation()
    moved = square @ turn.T + [10.0, -20.0, 30.0]
    assert area_vector(square).tolist() == [0.0, 0.0, 4.0]
    assert area_vector(moved) == pytest.approx(4.0 * turn[:, 2], abs=1e-13)
    assert side_lengths(square).tolist() == [2.0] * 4

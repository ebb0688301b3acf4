"""Triangle shapes, reflection lines and sharp edges."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pymeshfair.errors import FilterInputError
from pymeshfair.filters.inspection import reflection_stripes, share_kept, sharp_edges, triangle_shapes
from tests.meshes import cube, icosphere, noisy, single_triangle, tetrahedron


def test_shapes_in_closed_form() -> None:
    """Equilateral triangles have 1; the right triangle 3, 4, 5 has R = 2.5 and 3 / (2.5 sqrt 3); no area has 0."""
    np.testing.assert_allclose(triangle_shapes(*tetrahedron()), 1.0, rtol=1e-14)
    np.testing.assert_allclose(triangle_shapes(*single_triangle()), 3 / (2.5 * math.sqrt(3)), rtol=1e-14)
    assert triangle_shapes(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2], [0, 0, 1]])).tolist() == [0.0, 0.0]


def test_lines_of_a_cylinder_are_straight() -> None:
    """On a cylinder round the lamps the brightness depends on the angle alone, with 2 stripes a lamp; 0.5 is without a normal."""
    angle = np.linspace(0, 2 * math.pi, 2000, endpoint=False)
    normals = np.column_stack([np.cos(angle), np.zeros(2000), np.sin(angle)])
    bright = reflection_stripes(normals, view=(0, 0, 1), direction=(0, 1, 0), stripes=8)
    changes = np.diff(np.sign(bright - 0.5))
    # Round a mirror the reflected ray turns twice as fast as the normal: 16 bright stripes, with 2 edges each.
    assert np.count_nonzero(changes) == pytest.approx(32, abs=1)
    np.testing.assert_allclose(
        bright, reflection_stripes(normals, view=(0, 0, 3.0), direction=(0, -5.0, 0), stripes=8), atol=1e-9
    )
    assert reflection_stripes(np.zeros((1, 3)), view=(0, 0, 1), direction=(0, 1, 0)).tolist() == [0.5]


def test_no_direction_or_no_lamp_is_refused() -> None:
    """A direction must have a length, and there must be a lamp: less than one would be rounded to none."""
    with pytest.raises(FilterInputError, match=r"view \[0.0, 0.0, 0.0\] is no direction"):
        reflection_stripes(np.eye(3), view=(0, 0, 0), direction=(0, 1, 0))
    with pytest.raises(FilterInputError, match=r"stripes is 0\.4: it must be finite and at least 1"):
        reflection_stripes(np.eye(3), view=(0, 0, 1), direction=(0, 1, 0), stripes=0.4)


def test_sharp_edges_of_a_cube() -> None:
    """A cube has twelve sharp edges of 90 degrees; the diagonals of its sides are none."""
    found = sharp_edges(*cube())
    assert len(found.pairs) == 12
    assert math.fsum(found.lengths) == 12.0


def test_share_of_sharp_edges_that_is_kept() -> None:
    """A cube shifted a little keeps all of them, one cut from above a third, a sphere none; without any it is unknown."""
    vertices, faces = cube()
    before = sharp_edges(vertices, faces)
    assert share_kept(before, sharp_edges(vertices + 0.01, faces), within=0.1) == 1.0
    open_top = faces[~(vertices[faces][:, :, 2] == 1.0).all(axis=1)]
    assert share_kept(before, sharp_edges(vertices, open_top), within=0.1) == pytest.approx(8 / 12)
    assert share_kept(before, sharp_edges(*icosphere(3)), within=0.1) == 0.0
    assert share_kept(sharp_edges(*icosphere(3)), before, within=0.1) is None
    rough = sharp_edges(*noisy(icosphere(2), 0.1))
    assert len(rough.pairs) > 0

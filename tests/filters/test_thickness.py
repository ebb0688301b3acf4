"""The thickness of walls: slabs and balls in closed form, sheets near their rim, nothing where no wall is opposite."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.inspection import Thickness, wall_thickness
from tests.meshes import icosphere


def box(x: float, y: float, z: float) -> tuple[np.ndarray, np.ndarray]:
    """A box with faces that look outwards."""
    corners = np.array([[i, j, k] for i in (0.0, x) for j in (0.0, y) for k in (0.0, z)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners, np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])], dtype=np.int32)


def test_a_slab_is_as_thick_as_it_is_everywhere() -> None:
    """Of a slab 10 x 4 x 1 both large sides are 1 thick up to their rims, which is nearly all of the area."""
    found = wall_thickness(*box(10.0, 4.0, 1.0), count=2000)
    flat = np.isin(found.places[:, 2], (0.0, 1.0))
    np.testing.assert_allclose(found.values[flat], 1.0, rtol=1e-6)
    assert found.below(0.01) == pytest.approx(1.0)
    assert found.areas.sum() == pytest.approx(2.0 * (40.0 + 10.0 + 4.0))


def test_a_ball_is_as_thick_as_its_diameter() -> None:
    """Up to the facets of 1,280 triangles."""
    found = wall_thickness(*icosphere(3), count=500)
    assert np.median(found.values) == pytest.approx(2.0, rel=0.02)
    assert found.values.min() > 1.8


def test_the_thickness_scales_and_the_place_does_not_matter() -> None:
    """In other units and far away it is the same."""
    vertices, faces = box(3.0, 2.0, 0.5)
    here, there = wall_thickness(vertices, faces, count=300), wall_thickness(25.4 * vertices + 1e5, faces, count=300)
    np.testing.assert_allclose(there.values, 25.4 * here.values, rtol=1e-6)


def test_a_vertex_without_a_face_makes_no_wall_vanish() -> None:
    """A thin slab has its thickness also where such a vertex lies ten thousand million times as far away."""
    vertices, faces = box(1.0, 1.0, 1e-4)
    found = wall_thickness(np.concatenate([vertices, [[1e6, 0.0, 0.0]]]), faces, count=500)
    assert found.below(0.5) == pytest.approx(1e-4, rel=1e-6)


def test_nothing_is_thicker_than_the_share_of_all() -> None:
    """The quantile of the whole area is the largest finite thickness, also where the sums of areas differ by rounding."""
    values, areas = np.array([0.3, 0.1, np.inf, 0.2]), np.array([0.1, 0.2, 0.7, 0.3])
    assert Thickness(values, np.zeros((4, 3)), areas).below(1.0) == 0.3


def test_a_cloud_has_no_walls() -> None:
    """Points without faces are refused in words."""
    with pytest.raises(FilterInputError, match="no triangles"):
        wall_thickness(box(3.0, 2.0, 0.5)[0], np.empty((0, 3), np.int32))

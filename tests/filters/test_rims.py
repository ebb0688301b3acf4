"""The rims of a mesh as data."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.filters.holes import find_rims
from tests.meshes import grid, icosphere, tube


def test_a_tube_has_two_rims_of_its_polygon() -> None:
    """Each has as many edges as the tube has sides, the perimeter 2 n r sin(pi / n), and its middle on the axis."""
    rims = find_rims(*tube(16, 6, 1.0, 3.0))
    assert [rim.edges for rim in rims] == [16, 16]
    assert [rim.length for rim in rims] == pytest.approx([2 * 16 * np.sin(np.pi / 16)] * 2)
    ends = sorted(rim.middle.tolist() for rim in rims)
    np.testing.assert_allclose(ends[0][:2] + ends[1][:2], 0.0, atol=1e-12)
    assert abs(ends[1][2] - ends[0][2]) == pytest.approx(3.0)


def test_holes_and_outer_borders_are_told_apart_and_the_largest_comes_first() -> None:
    """A sheet with a triangle missing has its outline as outer border and a hole of three edges; a ball has no rim."""
    vertices, faces = grid(8, 9)
    middle = vertices[faces].mean(axis=1) - vertices.mean(axis=0)
    kept = np.delete(faces, np.linalg.norm(middle, axis=1).argmin(), axis=0)
    large, small = find_rims(vertices, kept)
    assert (large.edges, large.outer) == (2 * (8 + 9), True)
    assert (small.edges, small.outer) == (3, False)
    assert find_rims(*icosphere(1)) == []


def test_rims_are_in_mesh_units_wherever_the_mesh_lies() -> None:
    """Ten times larger and far away, the same rims are ten times longer and lie there."""
    vertices, faces = tube(12, 3)
    first, second = find_rims(vertices, faces)[0], find_rims(10.0 * vertices + 1e4, faces)[0]
    assert second.length == pytest.approx(10.0 * first.length, rel=1e-9)
    np.testing.assert_allclose(second.middle, 10.0 * first.middle + 1e4, rtol=1e-9)

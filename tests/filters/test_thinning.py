"""Thinning of clouds by a grid."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from pymeshfair import MeshSet
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.outliers import surplus_points


def test_the_first_point_of_each_cell_stays() -> None:
    """As a dictionary of the cells counts them, on both sides of the origin."""
    points = np.random.default_rng(0).uniform(-3, 3, (2000, 3))
    first: dict[tuple[float, ...], int] = {}
    for number, point in enumerate(points):
        first.setdefault(tuple(np.floor(point / 0.7)), number)
    np.testing.assert_array_equal(np.flatnonzero(~surplus_points(points, 0.7)), sorted(first.values()))


def test_a_cell_begins_at_multiples_of_its_side() -> None:
    """Of whole numbers, each even one shares a cell of side 2 with the odd one above it, below 0 as well."""
    points = np.column_stack([np.arange(-4.0, 4.0), np.zeros((8, 2))])
    np.testing.assert_array_equal(surplus_points(points, 2.0), points[:, 0] % 2 == 1)


def test_cells_that_cannot_be_told_apart_are_refused() -> None:
    """So far from the origin a cell would be smaller than the step from number to number."""
    with pytest.raises(FilterInputError, match="too small for coordinates"):
        surplus_points([[1e9, 0, 0]], 1e-9)


def test_a_cloud_is_thinned_by_two_filters() -> None:
    """What is selected is surplus, and deleting it leaves a point in each cell."""
    points = np.random.default_rng(1).uniform(0, 10, (3000, 3))
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points))
    found = meshes.compute_selection_by_grid_per_vertex(side="2")
    assert found is not None
    meshes.meshing_remove_selected_vertices()
    left = meshes.current_mesh().vertex_matrix()
    assert len(left) == 3000 - found["selected_vertices"] == len(np.unique(np.floor(left / 2.0), axis=0)) == 125

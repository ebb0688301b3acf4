"""The distance from a cloud, in spacings of the cloud."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.outliers import cloud_spacings, gaps


def square(side: int = 12) -> np.ndarray:
    """A square lattice of spacing 1 in a plane."""
    x, y = np.meshgrid(np.arange(side, dtype=float), np.arange(side, dtype=float))
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(side * side)])


def test_the_spacing_of_a_lattice_has_its_closed_form() -> None:
    """The six nearest in a square lattice are four at 1 and two at sqrt 2: the spacing is (4 + 2 sqrt 2) / 6."""
    heights = np.array([0.0, 1.0, 50.0])
    queries = np.column_stack([np.full(3, 5.0), np.full(3, 5.0), heights])
    np.testing.assert_allclose(gaps(queries, square()), heights / ((4.0 + 2.0 * np.sqrt(2.0)) / 6.0), rtol=1e-13)


def test_sparse_parts_are_measured_by_their_own_spacing() -> None:
    """Beside a dense lattice one ten times as wide: two thirds of ten spacings count there."""
    sparse = 10.0 * square() + [500.0, 0.0, 0.0]
    cloud = np.concatenate([square(30), sparse])
    at = np.array([[15.0, 15.0, 1.0], [550.0, 50.0, 1.0]])
    dense, wide = gaps(at, cloud)
    assert wide == pytest.approx(dense / (10.0 * 2.0 / 3.0))


def test_gaps_are_those_of_a_table_of_distances() -> None:
    """In a cloud of ever wider spacing: over the larger of the median spacing and 2/3 of that at the twenty points around."""
    rng = np.random.default_rng(2)
    points = rng.random((500, 3)) * [40.0, 1.0, 1.0]
    points *= np.linspace(1.0, 5.0, 500)[:, None]
    queries = rng.random((60, 3)) * [200.0, 6.0, 6.0]
    table = np.linalg.norm(points[:, None] - points, axis=2)
    nearest = np.argsort(table, axis=1)[:, 1:]
    spacings = np.take_along_axis(table, nearest[:, :6], axis=1).mean(axis=1)
    around = np.maximum(np.median(spacings), 2 / 3 * np.median(spacings[nearest[:, :20]], axis=1))
    np.testing.assert_allclose(cloud_spacings(points), around, rtol=1e-12)
    away = np.linalg.norm(queries[:, None] - points, axis=2)
    expected = away.min(axis=1) / around[away.argmin(axis=1)]
    np.testing.assert_allclose(gaps(queries, points), expected, rtol=1e-12)
    np.testing.assert_allclose(gaps(queries, points, 2.0 * around), expected / 2.0, rtol=1e-12)


def test_unit_and_place_do_not_matter() -> None:
    """Scaled and moved far away, the vertices are as far."""
    queries = np.random.default_rng(0).uniform(-8.0, 20.0, size=(200, 3))
    np.testing.assert_allclose(gaps(1e-3 * queries + 4e3, 1e-3 * square() + 4e3), gaps(queries, square()), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("size", [1e-170, 1e-100, 1e100, 1e160])
def test_a_unit_whose_squares_are_no_numbers_does_not_matter(size: float) -> None:
    """Squared distances that vanish or overflow change no gap."""
    queries = np.random.default_rng(0).uniform(-8.0, 20.0, size=(200, 3))
    np.testing.assert_allclose(gaps(size * queries, size * square()), gaps(queries, square()), rtol=1e-12)


def test_too_few_points_are_refused() -> None:
    """Six neighbours need seven points."""
    with pytest.raises(FilterInputError):
        gaps(square(), square(2))
    assert len(gaps(np.zeros((0, 3)), square())) == 0

"""What lies far from a cloud is selected, in spacings of the cloud."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.outliers import far_from_points


def square(side: int = 12) -> np.ndarray:
    """A square lattice of spacing 1 in a plane."""
    x, y = np.meshgrid(np.arange(side, dtype=float), np.arange(side, dtype=float))
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(side * side)])


def test_the_spacing_of_a_lattice_has_its_closed_form() -> None:
    """The six nearest in a square lattice are four at 1 and two at sqrt 2: the reach is k (4 + 2 sqrt 2) / 6."""
    reach = 2.0 * (4.0 + 2.0 * np.sqrt(2.0)) / 6.0
    heights = np.array([0.0, 0.999 * reach, 1.001 * reach, 50.0])
    queries = np.column_stack([np.full(4, 5.0), np.full(4, 5.0), heights])
    assert far_from_points(queries, square(), spacings=2.0).tolist() == [False, False, True, True]


def test_unit_and_place_do_not_matter() -> None:
    """Scaled and moved far away, the same vertices are far."""
    queries = np.random.default_rng(0).uniform(-8.0, 20.0, size=(200, 3))
    first = far_from_points(queries, square())
    assert first.any()
    assert not first.all()
    second = far_from_points(1e-3 * queries + 4e3, 1e-3 * square() + 4e3)
    np.testing.assert_array_equal(first, second)


def test_too_few_points_are_refused() -> None:
    """Six neighbours need seven points."""
    with pytest.raises(FilterInputError):
        far_from_points(square(), square(2))
    with pytest.raises(FilterInputError, match="spacings"):
        far_from_points(square(), square(), spacings=-1.0)
    assert len(far_from_points(np.zeros((0, 3)), square())) == 0

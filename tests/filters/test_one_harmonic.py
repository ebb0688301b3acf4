"""One mode to look at: its number, its size and where it lives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.spectral.eigenpairs import one_harmonic
from tests.meshes import AWKWARD, Mesh, icosphere


def with_dust(specks: int = 20) -> Mesh:
    """A unit sphere beside so many of a hundredth of its radius."""
    large, small = icosphere(3), icosphere(0, 0.01)
    centres = np.column_stack([2.0 + 0.1 * np.arange(specks), np.zeros((specks, 2))])
    vertices = np.vstack([large[0], *(small[0] + centre for centre in centres)])
    numbers = [np.int32(len(large[0]) + len(small[0]) * k) for k in range(specks)]
    return vertices, np.vstack([large[1], *(small[1] + number for number in numbers)])


def test_components_take_up_no_numbers() -> None:
    """Mode 0 is 1 everywhere; modes 1 to 3 are those of l = 1 of the sphere, although there are 21 components."""
    mesh = with_dust()
    constant = one_harmonic(*mesh, 0)
    assert (constant.values == 1.0).all()
    assert (constant.eigenvalue, constant.n_components) == (0.0, 21)
    for mode in (1, 2, 3):
        found = one_harmonic(*mesh, mode)
        assert found.eigenvalue == pytest.approx(2.0, rel=0.01)
        assert (found.values[:642] != 0.0).mean() > 0.9
        assert (found.values[642:] == 0.0).all()
        assert found.share_of_area == pytest.approx(1.0, abs=0.01)


def test_a_mode_of_a_small_component_is_told() -> None:
    """The share of the area is that of the component on which the mode is not 0."""
    vertices, faces = icosphere(1)
    both: Mesh = np.vstack([vertices, 0.5 * vertices + 3.0]), np.vstack([faces, faces + np.int32(len(vertices))])
    found = [one_harmonic(*both, mode) for mode in range(1, 30)]
    small = [bool((one.values[: len(vertices)] == 0.0).all()) for one in found]
    assert any(small)
    assert not all(small)
    for on_small, one in zip(small, found, strict=True):
        assert one.share_of_area == pytest.approx(0.2 if on_small else 0.8)


@pytest.mark.parametrize(
    ("mesh", "mode", "message"),
    [
        (icosphere(1), 42, "mode 42 does not exist: this mesh has modes 0 to 41"),
        (icosphere(1), -1, "mode is -1"),
        ((np.zeros((3, 3)), np.array([[0, 1, 2]], dtype=np.int32)), 0, "no triangle of this mesh has an area"),
        (AWKWARD["empty"](), 0, "no triangle of this mesh has an area"),
    ],
)
def test_modes_that_do_not_exist_are_refused(mesh: Any, mode: Any, message: str) -> None:
    """The message says which there are."""
    with pytest.raises(FilterInputError, match=message):
        one_harmonic(mesh[0], mesh[1], mode)

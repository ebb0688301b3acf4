"""Spikes are put back among their neighbours, and nothing else is moved."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.diffusion import remove_spikes
from tests.meshes import cube, grid, icosphere, renumbered, rotation, wheel


def pyramid(height: float, spokes: int = 8) -> tuple[np.ndarray, np.ndarray]:
    """A wheel with its hub at that height over the middle of a rim of radius 1; the rim is a border."""
    vertices, faces = wheel(spokes)
    radius = np.linalg.norm(vertices[1:] - vertices[0], axis=1).max()
    vertices = (vertices - vertices[0]) / radius
    vertices[0] = [0.0, 0.0, height]
    return vertices, faces


@pytest.mark.parametrize(("height", "goes"), [(1.49, False), (1.51, True)])
def test_a_pyramid_is_a_spike_above_its_closed_form(height: float, goes: bool) -> None:
    """The rim of radius 1 has a spread of 1, so that the steepness of the hub is its height."""
    vertices, faces = pyramid(height)
    found, spikes = remove_spikes(vertices, faces, steepness=1.5)
    assert spikes.tolist() == [goes] + [False] * 8
    np.testing.assert_array_equal(found[1:], vertices[1:])
    np.testing.assert_allclose(found[0], [0.0, 0.0, 0.0 if goes else height], atol=1e-15)


def test_needles_on_a_ball_go_and_nothing_else() -> None:
    """Vertices pulled out to thrice the radius come back near the ball, neighbours of one another too; the rest stays."""
    vertices, faces = icosphere(4)
    tips = np.array([20, 300, 301, 1000])
    spiky = vertices.copy()
    spiky[tips] *= 3.0
    found, spikes = remove_spikes(spiky, faces)
    assert np.flatnonzero(spikes).tolist() == tips.tolist()
    assert np.abs(np.linalg.norm(found[tips], axis=1) - 1.0).max() < 0.02
    others = np.delete(np.arange(len(vertices)), tips)
    np.testing.assert_array_equal(found[others], vertices[others])


@pytest.mark.parametrize("mesh", [icosphere(3), grid(), cube(2)], ids=["ball", "sheet", "box"])
def test_shapes_without_spikes_keep_every_bit(mesh: tuple[np.ndarray, np.ndarray]) -> None:
    """Balls, sheets and the corners of a box are no spikes."""
    found, spikes = remove_spikes(*mesh)
    assert not spikes.any()
    np.testing.assert_array_equal(found, mesh[0])


@pytest.mark.parametrize("height", [0.0, 2.0], ids=["cone", "tower"])
def test_the_apex_of_a_closed_cone_or_of_a_tower_stays(height: float) -> None:
    """The roof is three times as high as wide, steeper than a spike need be, and bends little where it meets base or walls."""
    vertices, roof = pyramid(3.0, 32)
    upper, lower = roof[:, 1:].T, roof[:, 1:].T + (32 if height else 0)
    walls = np.concatenate([np.column_stack([upper[0], lower[0], upper[1]]), np.column_stack([upper[1], *lower])])
    base = np.column_stack([np.full(32, 65), *lower[::-1]])
    closed = np.concatenate([roof, base, walls] if height else [roof, base])
    points = np.concatenate([vertices, vertices[1:] - [0.0, 0.0, height], [[0.0, 0.0, -height]]])
    assert not remove_spikes(points, closed)[1].any()


def test_place_size_and_numbering_do_not_matter() -> None:
    """The same tips of the mesh moved, turned, scaled and renumbered."""
    vertices, faces = icosphere(3)
    vertices[[5, 77, 400]] *= 2.5
    mixed, cells, origin = renumbered((vertices, faces))
    _, spikes = remove_spikes(1e3 * mixed @ rotation().T + 1e4, cells)
    assert sorted(origin[spikes].tolist()) == [5, 77, 400]


def test_what_may_not_move_stays_and_nonsense_is_refused() -> None:
    """A spike that is not movable is kept; a steepness below 0 is an error."""
    vertices, faces = pyramid(5.0)
    found, spikes = remove_spikes(vertices, faces, movable=np.zeros(9, dtype=bool))
    assert not spikes.any()
    np.testing.assert_array_equal(found, vertices)
    with pytest.raises(FilterInputError, match="steepness"):
        remove_spikes(vertices, faces, steepness=-1.0)

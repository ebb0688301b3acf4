"""How the box around a surface has changed, noise at its ends aside, and the similarity that takes points back."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.inspection import carried, side_changes
from tests.meshes import icosphere, rotation


def test_what_did_not_move_has_not_changed() -> None:
    """The same vertices twice: 0 on every side."""
    vertices, faces = icosphere(2)
    assert side_changes(vertices, vertices, faces).tolist() == [0.0, 0.0, 0.0]


def test_a_scaled_ball_by_its_closed_form() -> None:
    """Moves of x are the sphere's modes of eigenvalue 2: steps of 2/3 L keep about (1 - 2/3 h^2 / 2)^12 of them, h the edge.

    The uniform operator is h^2 / 4 times that of Laplace and Beltrami on even triangles; a tenth is left to uneven ones.
    """
    vertices, faces = icosphere(4)
    kept = (1.0 - mean_edge_length(vertices, faces) ** 2 / 3.0) ** 12
    found = side_changes(vertices, 1.05 * vertices, faces)
    np.testing.assert_allclose(found, 1.05 / (1.05 - 0.05 * kept) - 1.0, rtol=0.1)


def test_noise_that_is_taken_off_is_averaged_away() -> None:
    """Of noise of half an edge the box loses a tenth; what is left is an eighth of that, for noise of single vertices."""
    vertices, faces = icosphere(4)
    heights = np.random.default_rng(0).normal(scale=0.5 * mean_edge_length(vertices, faces), size=(len(vertices), 1))
    noisy = vertices * (1.0 + heights)
    plain = np.ptp(vertices, axis=0) / np.ptp(noisy, axis=0) - 1.0
    assert plain.max() < -0.05
    assert np.abs(side_changes(noisy, vertices, faces)).max() < np.abs(plain).min() / 8


def test_a_side_of_no_length_has_no_change() -> None:
    """A plane has no thickness of which there could be a share; vertices that no face uses do not count."""
    flat = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 9.0]])
    found = side_changes(flat, flat, np.array([[0, 1, 2]]))
    assert found[:2] == pytest.approx([0.0, 0.0])
    assert np.isnan(found[2])


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_points_are_carried_by_the_similarity_of_others(mirror: float) -> None:
    """Turned, scaled, shifted far away and maybe mirrored, some of the points tell where all of them went."""
    points = np.random.default_rng(0).normal(size=(40, 3)) + 5.0
    moved = 0.03 * points @ (rotation(1) * [1.0, 1.0, mirror]).T + [1e4, -2e4, 3.0]
    np.testing.assert_allclose(carried(points, points[:9], moved[:9]), moved, rtol=0, atol=1e-10)  # a few roundings of 2e4


def test_no_similarity_carries_points_nearer() -> None:
    """What is left is at a right angle to shifts, to growth and to turns about the middle: the sum of its squares is least."""
    rng = np.random.default_rng(1)
    source = rng.normal(size=(30, 3)) + 2.0
    target = 7.0 * source @ rotation(2).T + rng.normal(size=(30, 3))
    found = carried(source, source, target)
    left, arm = target - found, found - found.mean(axis=0)
    assert np.abs(left).max() > 1.0
    np.testing.assert_allclose([*left.sum(axis=0), (left * arm).sum(), *np.cross(arm, left).sum(axis=0)], 0.0, atol=1e-11)
